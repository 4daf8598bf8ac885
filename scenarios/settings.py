"""Settings of a scenario: a dataclass, a YAML file of values, and ``key=value`` overrides.

pydantic checks the types; the dataclasses check their values in ``__post_init__``; unknown keys are named here with the allowed ones.
"""

import dataclasses
import difflib
from pathlib import Path
from typing import Any, get_type_hints

import yaml
from pydantic import TypeAdapter, ValidationError

from vipr.systems.errors import InputError


def load_settings(schema: type, path: Path | None, overrides: list[str] = ()) -> Any:
    """Settings of type ``schema`` from a YAML file (None: the defaults) and overrides such as ``servo.gain=2``, in that order.

    Raises:
        InputError: naming the key, what was given and what is allowed.
    """
    values = (yaml.safe_load(path.read_text()) or {}) if path is not None else {}
    for override in overrides:
        _set(values, override)
    _check_keys(schema, values, "")
    try:
        return TypeAdapter(schema).validate_python(values)
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        given = "" if isinstance(first["input"], dict) else f", got {first['input']!r}"
        message = first["msg"].removeprefix("Value error, ")
        raise InputError(f"setting {key}: {message}{given}" if key else message) from None


def as_dict(settings: Any) -> dict:
    """The settings as plain nested dictionaries, for a summary."""
    return TypeAdapter(type(settings)).dump_python(settings, mode="json")


def _set(values: dict, override: str) -> None:
    key, equals, text = override.partition("=")
    if not equals or not key.strip():
        raise InputError(f"--set {override}: expected key=value, such as servo.gain=2")
    try:
        value = yaml.safe_load(text)
    except yaml.YAMLError:
        raise InputError(f"--set {override}: {text!r} is not a YAML value") from None
    *parents, last = key.strip().split(".")
    for parent in parents:
        child = values.setdefault(parent, {})
        if not isinstance(child, dict):
            raise InputError(f"--set {override}: {parent} has no settings below it")
        values = child
    values[last] = value


def _check_keys(schema: type, values: Any, prefix: str) -> None:
    if not dataclasses.is_dataclass(schema) or not isinstance(values, dict):
        return
    hints = get_type_hints(schema)
    for key, value in values.items():
        if key not in hints:
            near = difflib.get_close_matches(str(key), hints, n=1)
            hint = f" Did you mean {prefix}{near[0]}?" if near else ""
            raise InputError(
                f"unknown setting {prefix}{key}; allowed are {', '.join(prefix + name for name in hints)}.{hint}"
            )
        _check_keys(hints[key], value, f"{prefix}{key}.")
