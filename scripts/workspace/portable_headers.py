"""Make the CMake files of the ROS wheels find this Python's and this NumPy's headers.

The wheels' CMake exports hold absolute paths of the machine they were built on. Run with the Python of the
virtual environment, after each installation; a second run changes nothing.
"""

import os
import re
import sys
import sysconfig
from pathlib import Path

import numpy

NUMPY = re.compile(r"/[^\";()\n]*/site-packages/numpy/_?core/include")
PYTHON = re.compile(r"/[^\";()\n]*/include/python3\.\d+")


def localised(text: str, python_include: str, numpy_include: str) -> str:
    """Return `text` with the header folders of whatever machine or environment replaced by this one's."""
    # Functions as replacement, because a backslash in a path would be read as a group reference.
    text = NUMPY.sub(lambda _: numpy_include, text)
    return PYTHON.sub(lambda _: python_include, text)


def localise(exports: list[Path], python_include: str, numpy_include: str) -> None:
    """Rewrite the CMake files `exports` that name other headers.

    The installer links files from its cache into every environment. So a file is replaced, never written into:
    else all environments would look for headers in the one that was made last.
    """
    for path in exports:
        before = path.read_text(encoding="utf-8")
        after = localised(before, python_include, numpy_include)
        if after != before:
            written = path.with_suffix(".new")
            written.write_text(after, encoding="utf-8")
            os.replace(written, path)


if __name__ == "__main__":
    localise(
        sorted(Path(sys.prefix, "share").glob("*/cmake/*.cmake")), sysconfig.get_path("include"), numpy.get_include()
    )
