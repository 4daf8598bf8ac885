"""Where the recordings are, and what a test says that cannot find them."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of the recordings: ``VIPR_DATA``, or ``../shared/data`` beside the checkout."""
    for candidate in (os.environ.get("VIPR_DATA"), Path(__file__).parents[2] / "shared" / "data"):
        if candidate and Path(candidate).is_dir():
            return Path(candidate)
    pytest.skip("recordings not found: set VIPR_DATA to the folder that holds tracking/, gestures/, video/")


@pytest.fixture(scope="session")
def shared_facts() -> Path:
    """Folder of the reference vectors: ``VIPR_FACTS``, or ``../shared/facts`` beside the checkout."""
    for candidate in (os.environ.get("VIPR_FACTS"), Path(__file__).parents[2] / "shared" / "facts"):
        if candidate and Path(candidate).is_dir():
            return Path(candidate)
    pytest.skip("reference vectors not found: set VIPR_FACTS to the folder that holds puma560_vectors.npz")
