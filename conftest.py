"""Fixtures for the tests of all packages."""

from __future__ import annotations

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def thruster_bench_data() -> Path:
    """Return the folder with the bench's recordings, or skip: they cannot be part of the project.

    THRUSTER_BENCH_DATA names it; else it is looked for beside the repository.
    """
    given = os.environ.get("THRUSTER_BENCH_DATA")
    folder = Path(given) if given else Path(__file__).resolve().parent / "../shared/data/thruster_bench"
    if not folder.is_dir():
        pytest.skip(f"no recordings of the thruster bench at {folder}; THRUSTER_BENCH_DATA names the folder")
    return folder.resolve()
