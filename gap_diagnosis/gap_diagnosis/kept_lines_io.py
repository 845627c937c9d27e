"""Files to which results are appended, a JSON object a line, each as it is there."""

import json
import os
from pathlib import Path
from typing import Any

__all__ = ["keep_line", "kept_lines"]


def kept_lines(path: Path) -> list[dict[str, Any]]:
    """Return what the lines of a file hold; none where there is no file. A last line that was cut off is passed over.

    Raises:
        ValueError: with file and line, of a line that is no JSON object.
    """
    found = []
    lines = path.read_text("utf-8").splitlines(keepends=True) if path.exists() else []
    for number, line in enumerate(lines, start=1):
        if not line.endswith("\n"):
            break
        try:
            content = json.loads(line)
        except json.JSONDecodeError as error:
            content = error
        if not isinstance(content, dict):
            raise ValueError(f"{path}, line {number}: expected a JSON object; found {line.strip()[:40]!r}")
        found.append(content)
    return found


def keep_line(path: Path, content: dict[str, Any]) -> None:
    """Append an object as a line, in one step; a last line that was cut off is removed."""
    with path.open("a+b", buffering=0) as file:
        end = file.seek(0, os.SEEK_END)
        file.seek(max(end - 1, 0))
        if file.read(1) not in (b"", b"\n"):
            file.truncate(path.read_bytes().rfind(b"\n") + 1)
        file.write(json.dumps(content).encode() + b"\n")
