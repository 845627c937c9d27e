"""A program that misses a module which no rosdep key brings says so in one sentence, with the command that mends it."""

from __future__ import annotations

import sys
from types import TracebackType

__all__ = ["PIP_ONLY", "tell_missing"]

PIP_ONLY = {
    "filterpy": "filterpy", "lz4": "lz4", "mcap": "mcap", "numba": "numba", "plotly": "plotly", "proadv": "proadv",
    "rich": "rich", "rosbags": "rosbags", "threadpoolctl": "threadpoolctl", "typer": "typer",
    "zstandard": "zstandard",
}  # fmt: skip
"""What pip has to bring where `scripts/setup.sh` does not: module, and what pip knows it as."""


def tell_missing() -> None:
    """Let this process end with that sentence, instead of a traceback, where it ends by such a module's absence."""
    if sys.excepthook is not _told:
        _before.append(sys.excepthook)
        sys.excepthook = _told


_before = [sys.__excepthook__]


def _told(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    missing = (error.name or "").partition(".")[0] if isinstance(error, ModuleNotFoundError) else ""
    if missing not in PIP_ONLY:
        _before[-1](kind, error, trace)
        return
    program = sys.argv[0].rpartition("/")[2] or "python"
    sys.stderr.write(
        f"{program}: the Python module {missing} is missing; scripts/setup.sh installs it, "
        f"and so does: {sys.executable} -m pip install {PIP_ONLY[missing]}\n"
    )


tell_missing()
