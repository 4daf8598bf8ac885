"""Stages of the user's own, named in a setting: ``stages.tracker=my_tracker.py:MyTracker`` or ``package.module:MyTracker``."""

import importlib
import importlib.util
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from vipr.diagrams.stages import Maker
from vipr.systems.errors import InputError


def load_stages(named: Mapping[str, str]) -> dict[str, Maker]:
    """What takes the place of each stage: the class or function that ``FILE.py:NAME`` or ``MODULE:NAME`` names.

    A file is found from the working directory, and may import what lies beside it. InputError where there is no such thing; an error in
    the user's own code comes through as it is.
    """
    return {stage: _load(stage, place) for stage, place in named.items()}


def stages_given(options: Sequence[str]) -> dict[str, str]:
    """What the options ``--stage NAME=FILE.py:CLASS`` name, by the stages' names."""
    named = {}
    for option in options:
        stage, equals, place = option.partition("=")
        if not equals or not stage:
            raise InputError(f"--stage {option}: expected NAME=FILE.py:CLASS or NAME=MODULE:CLASS")
        named[stage] = place
    return named


def _load(stage: str, place: str) -> Maker:
    where, colon, name = place.rpartition(":")
    if not colon or not where or not name.isidentifier():
        raise InputError(f"stages.{stage}: expected FILE.py:CLASS or MODULE:CLASS, got {place!r}")
    if where.endswith(".py"):
        path = Path(where).resolve()
        if not path.is_file():
            raise InputError(f"stages.{stage}: there is no file {where}")
        module = _run_file(path)
    else:
        try:
            module = importlib.import_module(where)
        except ModuleNotFoundError as error:
            raise InputError(f"stages.{stage}: cannot import {where} ({error})") from None
    make = getattr(module, name, None)
    if not callable(make):
        raise InputError(f"stages.{stage}: {where} has no class or function {name}")
    return make


@cache
def _run_file(path: Path):
    """The module that the file makes, loaded once a process."""
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))
    spec = importlib.util.spec_from_file_location(f"vipr_stage_{path.stem}", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up there
    spec.loader.exec_module(module)
    return module
