"""Gather the pages of the repository, and what they show, into one folder for mkdocs, at the same places in it.

site_source.py FOLDER
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SHOWN = (".png", ".svg")


def slug(heading: str, separator: str = "-") -> str:
    """Return the anchor of a heading, as the hosts of repositories make it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", separator)


def sources() -> list[Path]:
    """Return pages and pictures in the repository, relative to it."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", "*.md", *(f"*{x}" for x in SHOWN)]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, check=True, text=True).stdout
    return [Path(name) for name in listed.split("\0") if name and (ROOT / name).is_file()]


def main() -> None:
    """Copy them; a changelog is no page."""
    target = Path(sys.argv[1])
    shutil.rmtree(target, ignore_errors=True)
    for source in sources():
        if source.name != "CHANGELOG.md":
            (target / source).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / source, target / source)


if __name__ == "__main__":
    main()
