"""What is on disk is what is installed, under the one name ``vipr``."""

import os
import sys
import tomllib
from importlib.resources import files
from pathlib import Path

import vipr.systems.signals

ROOT = Path(__file__).parents[1]
TOPS = ("systems", "diagrams", "models", "scenarios")


def test_every_package_is_listed():
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    folders = {
        "vipr." + ".".join(path.parent.relative_to(ROOT).parts) for top in TOPS for path in (ROOT / top).rglob("*.py")
    }
    assert sorted(listed) == sorted(folders)


def test_model_files_are_package_data():
    assert (files("vipr.models") / "package.xml").is_file()


def test_it_is_the_wheel_that_is_tested_where_the_makefile_says_so():
    installed = os.environ.get("VIPR_INSTALLED")
    place = Path(vipr.systems.signals.__file__).resolve()
    assert place.is_relative_to(ROOT / (installed or "systems"))


def test_bare_names_are_not_imported():
    assert vipr.systems.signals
    for name in TOPS:
        module = sys.modules.get(name)
        assert module is None or not str(getattr(module, "__file__", "")).startswith(str(ROOT)), name
