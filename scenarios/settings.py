"""Settings of a scenario: a dataclass, a YAML file of values, and ``key=value`` overrides.

pydantic checks the types; the dataclasses check their values in ``__post_init__``; unknown keys are named here with the allowed ones.

Where a setting is one of several dataclasses (``servo: Annotated[ServoLaw, ONE_OF]``), each has a field ``kind: Literal["its_name"]``.
``servo=image_based`` chooses one, ``servo.gain=2`` sets a value of the one chosen, in whatever order; with none chosen it is the default.
"""

import dataclasses
import difflib
from collections.abc import Iterable
from pathlib import Path
from typing import Any, get_args, get_origin, get_type_hints

import yaml
from pydantic import Field, TypeAdapter, ValidationError

from vipr.systems.errors import InputError

KIND = "kind"  # the field that tells the options of a union apart
ONE_OF = Field(discriminator=KIND)


def load_settings(schema: type, path: Path | None, overrides: list[str] = ()) -> Any:
    """Settings of type ``schema`` from a YAML file (None: the defaults) and overrides such as ``servo.gain=2``, in that order.

    Raises:
        InputError: naming the key, what was given and what is allowed.
    """
    values = (yaml.safe_load(path.read_text()) or {}) if path is not None else {}
    for override in overrides:
        _set(values, override)
    values = _checked(schema, values, "")
    try:
        return TypeAdapter(schema).validate_python(values)
    except ValidationError as error:
        errors = error.errors()  # of each option of a union; our own checks speak last and best
        first = next((e for e in errors if e["type"] == "value_error"), errors[0])
        key = ".".join(str(part) for part in first["loc"] if str(part) in _keys(values))
        given = "" if isinstance(first["input"], dict) else f", got {first['input']!r}"
        message = first["msg"].removeprefix("Value error, ")
        raise InputError(f"setting {key}: {message}{given}" if key else message) from None


def as_dict(settings: Any) -> dict:
    """The settings as plain nested dictionaries, for a summary."""
    return TypeAdapter(type(settings)).dump_python(settings, mode="json")


def require_within(settings: Any, **ranges: tuple[float, float]) -> None:
    """InputError unless each of these settings is a number within its range, the ends included."""
    for name, (least, most) in ranges.items():
        if not least <= getattr(settings, name) <= most:
            raise InputError(f"{name} must be {least:g} to {most:g}, got {getattr(settings, name)}")


def require_one_of(what: str, given: str, allowed: Iterable[str]) -> None:
    """InputError unless what is given is among the allowed."""
    if given not in allowed:
        raise InputError(f"unknown {what} {given!r}; there are: {', '.join(allowed)}")


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
        if isinstance(child, str):
            child = values[parent] = {KIND: child}
        elif isinstance(child, float | int):  # a number beside which there is a dataclass, such as a gain
            child = values[parent] = {}
        if not isinstance(child, dict):
            raise InputError(f"--set {override}: {parent} has no settings below it")
        values = child
    if isinstance(value, str) and isinstance(values.get(last), dict):
        values[last] = {**values[last], KIND: value}
    else:
        values[last] = value


def _checked(schema: Any, values: Any, prefix: str) -> Any:
    """The values, known to have no unknown keys, with the kind filled in wherever there is a choice of dataclasses."""
    if get_args(schema) and get_origin(schema) not in (tuple, list, dict):
        schema, values = _chosen(schema, values, prefix)
    if not dataclasses.is_dataclass(schema) or not isinstance(values, dict):
        return values
    hints = get_type_hints(schema)
    for key in values:
        if key not in hints:
            near = difflib.get_close_matches(str(key), hints, n=1)
            hint = f" Did you mean {prefix}{near[0]}?" if near else ""
            raise InputError(
                f"unknown setting {prefix}{key}; allowed are {', '.join(prefix + name for name in hints)}.{hint}"
            )
    defaults = {f.name: f.default for f in dataclasses.fields(schema)}
    filled = {}
    for key, value in values.items():
        if isinstance(value, dict) and KIND not in value and hasattr(defaults[key], KIND):
            value = {KIND: getattr(defaults[key], KIND), **value}
        filled[key] = _checked(hints[key], value, f"{prefix}{key}.")
    return filled


def _chosen(union: Any, values: Any, prefix: str) -> tuple[Any, Any]:
    """The dataclass of a union that the values are for, and the values as a dictionary with its kind."""
    kinds = {_kind(option): option for option in get_args(union) if dataclasses.is_dataclass(option)}
    if None in kinds:  # one dataclass beside plain types
        return kinds[None] if isinstance(values, dict) else None, values
    if not kinds:
        return None, values
    if isinstance(values, str):
        values = {KIND: values}
    kind = values.get(KIND) if isinstance(values, dict) else values
    if kind not in kinds:
        raise InputError(f"setting {prefix.rstrip('.')}: must be one of {', '.join(kinds)}, got {kind!r}")
    return kinds[kind], values


def _kind(schema: type) -> str | None:
    """The word by which a dataclass is chosen from a union."""
    hint = get_type_hints(schema).get(KIND)
    return get_args(hint)[0] if hint else None


def _keys(values: Any) -> set[str]:
    """Every key of nested dictionaries: pydantic's error paths name the options of a union too."""
    if not isinstance(values, dict):
        return set()
    return {str(key) for key in values}.union(*map(_keys, values.values()))
