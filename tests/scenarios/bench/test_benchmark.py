"""What the benchmarks have in common: their parts are those that the command names; unknown parts and missing data are refused at once."""

import importlib

import pytest

from vipr.scenarios.bench.benchmark import measure
from vipr.scenarios.command.bench import TABLES
from vipr.systems.errors import InputError


@pytest.mark.parametrize("name", TABLES)
def test_the_command_names_the_parts_that_there_are(name):
    module = importlib.import_module(f"vipr.scenarios.bench.{name}")
    assert TABLES[name][1].split(", ") == list(module.PARTS)
    assert set(module.NEEDS_DATA) <= set(module.PARTS)


@pytest.mark.parametrize("name", TABLES)
def test_an_unknown_part_is_refused_before_anything_is_measured(name):
    with pytest.raises(InputError, match=f"bench {name}: unknown part 'noses', allowed are "):
        measure(name, ["noses"])


@pytest.mark.parametrize(
    ("name", "part"), [("tracking", "recordings"), ("people", "clips"), ("gestures", "handwriting")]
)
def test_a_part_that_needs_data_says_so(name, part, tmp_path):
    with pytest.raises(InputError, match=f"{part} needs --data FOLDER with .*, got None"):
        measure(name, [part])
    with pytest.raises(InputError, match=f"{part} needs --data FOLDER with .*, got {tmp_path}/nowhere"):
        measure(name, [part], data=tmp_path / "nowhere")
