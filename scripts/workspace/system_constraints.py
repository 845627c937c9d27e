"""Print constraints.txt with the versions of a ROS installation where ROS was built against them.

Compiled extensions of NumPy 1 do not load under NumPy 2 (`_ARRAY_API not found`), so where the system has
these packages they stay as they are. Run with the Python of a virtual environment made with --system-site-
packages.

usage: system_constraints.py CONSTRAINTS_FILE
"""

import re
import sys
from collections.abc import Mapping
from importlib.metadata import distributions
from pathlib import Path

# numpy and scipy are compiled against each other; the others belong to the generators and the build of ROS.
OWNED_BY_ROS = ("catkin-pkg", "empy", "lark", "lark-parser", "numpy", "scipy")


def system_versions(venv: Path) -> dict[str, str]:
    """Return name -> version of the packages in OWNED_BY_ROS that are installed outside `venv`."""
    found: dict[str, str] = {}
    for distribution in distributions():
        name = re.sub(r"[-_.]+", "-", distribution.metadata["Name"] or "").lower()
        location = Path(str(distribution.locate_file(""))).resolve()
        if name in OWNED_BY_ROS and venv.resolve() not in (location, *location.parents):
            found.setdefault(name, distribution.version)
    return found


def constrained(lines: list[str], versions: Mapping[str, str]) -> list[str]:
    """Return `lines` without the packages in `versions`, followed by one line for each of those."""
    kept = [line for line in lines if line.partition("==")[0] not in versions]
    return [*kept, *(f"{name}=={version}" for name, version in sorted(versions.items()))]


def main() -> None:
    """Print the constraints for the environment of the running Python."""
    lines = Path(sys.argv[1]).read_text(encoding="utf-8").splitlines()
    sys.stdout.write("\n".join(constrained(lines, system_versions(Path(sys.prefix)))) + "\n")


if __name__ == "__main__":
    main()
