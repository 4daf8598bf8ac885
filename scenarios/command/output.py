"""What every subcommand prints with: the error line and output folders."""

import os
import sys
from pathlib import Path

from vipr.systems.errors import InputError


def print_error(message: str) -> None:
    """One line on standard error."""
    print(f"vipr: error: {' '.join(message.split())}", file=sys.stderr)


def output_folder(path: Path) -> Path:
    """The folder, made if need be, known to be writable."""
    try:
        path.mkdir(parents=True, exist_ok=True)
        probe = path / ".vipr-write-test"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise InputError(
            f"--out {path}: cannot be written ({os.strerror(error.errno) if error.errno else error})"
        ) from None
    return path
