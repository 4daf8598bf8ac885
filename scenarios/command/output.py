"""What every subcommand prints with: the error line and output folders."""

import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from vipr.systems.errors import InputError

EVERY = 30.0  # s between two lines of progress where there is no terminal


@contextmanager
def progress_line(what: str) -> Iterator[Callable[[str], None]]:
    """Tells how far a long command has come, on standard error: in a terminal one line that changes, elsewhere a new line now and then."""
    from rich.console import Console

    console = Console(stderr=True, soft_wrap=True, highlight=False)
    told = time.monotonic()

    def tell(text: str) -> None:
        nonlocal told
        if time.monotonic() - told >= EVERY:
            told = time.monotonic()
            console.print(text, markup=False)

    if not console.is_terminal:
        yield tell
        return
    with console.status(what) as status:
        yield status.update


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
