"""Files that are there complete or not at all."""

import os
from pathlib import Path

__all__ = ["replace_file"]


def replace_file(file: Path, content: bytes) -> None:
    """Write a file, in place of an earlier one, complete or not at all; its folder is made where there is none."""
    file.parent.mkdir(parents=True, exist_ok=True)
    temporary = file.with_name(f".{file.name}.{os.getpid()}.part")
    temporary.write_bytes(content)
    temporary.replace(file)
