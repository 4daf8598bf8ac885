"""Files that are either whole or not there, and the sentence said when one cannot be written."""

import os
from pathlib import Path

from vipr.systems.errors import InputError


def cannot_be_written(path: Path, error: OSError) -> InputError:
    """The user's error for a failed write: names the file and the system's reason."""
    return InputError(f"{path}: cannot be written ({os.strerror(error.errno) if error.errno else error})")


def write_whole(path: Path, data: bytes | str) -> None:
    """Write beside the file and rename, so that a reader, a crash or a full disk never meets half of it."""
    data = data.encode() if isinstance(data, str) else data
    partial = path.with_name(f".{path.name}.partial")
    try:
        try:
            partial.write_bytes(data)
            os.replace(partial, path)
        except OSError:
            partial.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise cannot_be_written(path, error) from None
