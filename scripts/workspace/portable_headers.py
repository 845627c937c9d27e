"""Make the CMake files of the ROS wheels find this Python's and this NumPy's headers.

The wheels' CMake exports hold absolute paths of the machine they were built on. Run with the Python of the
virtual environment, after each installation; a second run changes nothing.
"""

import re
import sys
import sysconfig
from pathlib import Path

import numpy

BUILDER_NUMPY = re.compile(r"/opt/python/cp\d+-cp\d+/lib/python3\.\d+/site-packages/numpy/_?core/include")
BUILDER_PYTHON = re.compile(r"/opt/python/cp\d+-cp\d+/include/python3\.\d+")
BUILDER_ANY = "/opt/python/cp"


def localised(text: str, python_include: str, numpy_include: str) -> str:
    """Return `text` with the builder's header folders replaced by this machine's."""
    # Functions as replacement, because a backslash in a path would be read as a group reference.
    text = BUILDER_NUMPY.sub(lambda _: numpy_include, text)
    return BUILDER_PYTHON.sub(lambda _: python_include, text)


def main() -> int:
    """Rewrite every CMake export of the environment; return 1 and name the files in which a path stays."""
    left = []
    for path in sorted(Path(sys.prefix, "share").glob("*/cmake/*.cmake")):
        before = path.read_text(encoding="utf-8")
        after = localised(before, sysconfig.get_path("include"), numpy.get_include())
        if after != before:
            path.write_text(after, encoding="utf-8")
        if BUILDER_ANY in after:
            left.append(path)
    for path in left:
        sys.stderr.write(f"{path} still names a header folder of the machine that built the wheel\n")
    return 1 if left else 0


if __name__ == "__main__":
    sys.exit(main())
