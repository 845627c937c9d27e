"""Fixtures for the tests of all packages, and a ROS domain for this process of pytest alone."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from thruster_runtime.domains import reserved_domain

# Whatever the shell has: in one domain, the graphs of two processes of tests (or a live one) would hear each other.
os.environ["ROS_DOMAIN_ID"] = str(reserved_domain())


def data_folder(variable: str, name: str, what: str) -> Path:
    """Return the folder of data that cannot be part of the project, or skip.

    The environment variable names it; else it is looked for beside the repository.
    """
    given = os.environ.get(variable)
    folder = Path(given) if given else Path(__file__).resolve().parent / "../shared/data" / name
    if not folder.is_dir():
        pytest.skip(f"no {what} at {folder}; {variable} names the folder")
    return folder.resolve()


@pytest.fixture(scope="session")
def thruster_bench_data() -> Path:
    """Return the folder with the bench's recordings, or skip."""
    return data_folder("THRUSTER_BENCH_DATA", "thruster_bench", "recordings of the thruster bench")


@pytest.fixture(scope="session")
def t200_data() -> Path:
    """Return the folder with the maker's performance data of the T200, or skip."""
    return data_folder("T200_DATA", "t200", "performance data of the T200")


@pytest.fixture(scope="session")
def pool_data() -> Path:
    """Return the folder with recordings of a vehicle in a pool, or skip."""
    return data_folder("POOL_DATA", "bluerov_pool", "recordings of a vehicle in a pool")
