"""Opened cases as compressed JSON Lines, a case a line: what figures are made of, for readers and other machines."""

import gzip
import json
import zlib
from collections.abc import Sequence
from pathlib import Path

from gap_diagnosis.blind_check.opened import Opened
from safe_files.whole_files_io import write_whole

__all__ = ["read_opened", "write_opened"]

_FIELDS = ("seal", "key", "diagnosis", "shrink")


def write_opened(cases: Sequence[Opened], file: Path) -> None:
    """Write cases in place of an earlier file."""
    lines = (json.dumps({name: getattr(case, name) for name in _FIELDS}, allow_nan=False) for case in cases)
    write_whole(file, gzip.compress("".join(f"{line}\n" for line in lines).encode(), mtime=0), replace=True)


def read_opened(file: Path) -> list[Opened]:
    """Read cases.

    Raises:
        ValueError: not compressed, or a line is not an opened case; it is named.
        OSError: no such file.
    """
    try:
        lines = gzip.decompress(file.read_bytes()).decode().splitlines()
    except (gzip.BadGzipFile, EOFError, zlib.error, UnicodeDecodeError) as error:
        raise ValueError(f"{file}: expected JSON Lines compressed by gzip; found {error}") from error
    cases = []
    for number, line in enumerate(lines, 1):
        try:
            content = json.loads(line)
            case = Opened(**{name: content[name] for name in _FIELDS})
            _ = case.key["case"], case.key["seed"], case.diagnosis["verdict"]
        except (ValueError, KeyError, TypeError) as error:
            raise ValueError(
                f"{file}, line {number}: expected an opened case with {', '.join(_FIELDS)}; found {line[:60]!r}"
            ) from error
        cases.append(case)
    return cases
