"""Fixtures for all tests."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of example recordings that are not part of the project; tests that need it skip without it."""
    default = Path(__file__).resolve().parents[2] / "shared" / "data"
    folder = Path(os.environ.get("EXOID_SHARED_DATA", default))
    if not folder.is_dir():
        pytest.skip(f"no example recordings in {folder}")
    return folder
