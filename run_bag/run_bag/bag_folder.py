"""The folder of a rosbag2 bag: its files in order, and what its metadata.yaml says is missing."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from safe_files.errors import YamlError
from safe_files.yaml_io import read_yaml

from .errors import NotARunError
from .mcap_content import Scan
from .other_bags import convert_command, other_files

MAX_PLACES = 5
SECOND = 1e9


def bag_files(path: Path, *, others: bool = False) -> tuple[list[Path], dict[str, Any], list[str]]:
    """Return the MCAP files of a run in order, what metadata.yaml says ({} without one), and warnings.

    `others`: take files of other storages too; the description then has "others".

    Raises:
        NotARunError: nothing there, another storage, or no MCAP file.
    """
    try:
        return _bag_files(path, others=others)
    except OSError as error:
        raise NotARunError(f"{path}: cannot be read: {error.strerror or error}", path=path) from error


def _bag_files(path: Path, *, others: bool) -> tuple[list[Path], dict[str, Any], list[str]]:
    if path.is_file():
        return [path], {"others": True} if others and other_files(path, {}) else {}, []
    if not path.is_dir():
        raise NotARunError(f"{path}: no such file or directory", path=path)
    description, warnings = _description(path / "metadata.yaml")
    storage = description.get("storage_identifier", "mcap")
    different = other_files(path, description)
    if different and others:
        return different, {**description, "others": True}, warnings
    if storage != "mcap" or different:
        found = storage if storage != "mcap" else different[0].name if different else ""
        text = f"{path}: expected storage mcap, found {found}"
        text += f"; `{convert_command(path, str(storage))}` makes one of the other"
        raise NotARunError(text, path=path, expected="mcap", found=found)
    found = sorted(
        path.glob("*.mcap"), key=lambda p: [int(x) if x.isdigit() else x for x in re.split(r"(\d+)", p.name)]
    )
    listed = [path / Path(str(name)).name for name in description.get("relative_file_paths") or []]
    files = [f for f in listed if f.is_file()]
    files += [f for f in found if f not in files]
    if not files:
        here = ", ".join(sorted(p.name for p in path.iterdir())[:10]) or "nothing"
        hint = f"; for all runs in it: {path}/*" if any(path.glob("*/*.mcap")) else ""
        raise NotARunError(f"{path}: expected an .mcap file in it, found {here}{hint}", path=path, found=here)
    return files, {**description, "absent": [f.name for f in listed if f not in files]}, warnings


def _description(file: Path) -> tuple[dict[str, Any], list[str]]:
    """Return what a bag's metadata.yaml says and no warning, or {} and why it cannot be used."""
    try:
        if not file.is_file():
            return {}, []
        loaded = read_yaml(file)
        content = loaded.get("rosbag2_bagfile_information") if isinstance(loaded, dict) else None
        if not isinstance(content, dict):
            raise ValueError("expected a mapping rosbag2_bagfile_information, found none")
        if not isinstance(content.get("relative_file_paths") or [], list):
            raise ValueError("expected relative_file_paths to be a list")
    except (OSError, ValueError) as error:
        reason = " ".join((error.told if isinstance(error, YamlError) else str(error)).split())
        return {}, [f"metadata.yaml cannot be used, so nothing says how many messages there should be: {reason}"]
    return content, []


def losses(description: Mapping[str, Any], scans: tuple[Scan, ...]) -> list[str]:
    """Compare what was found with what metadata.yaml promises: how many messages are missing, and where."""
    sentences = [f"the file {name} that metadata.yaml lists is missing" for name in description.get("absent", [])]
    promised = description.get("message_count")
    found = sum(s.message_count + len(s.told) for s in scans)
    if isinstance(promised, int) and promised > found:
        lost = f"{promised - found} of {promised} messages that metadata.yaml counts are lost"
        sentences.append(", ".join([lost, *_places(description, scans)]))
    return sentences


def _places(description: Mapping[str, Any], scans: tuple[Scan, ...]) -> list[str]:
    """Say where messages are missing, in seconds from the start of the bag; [] if its times are unknown."""
    try:
        start = int(description["starting_time"]["nanoseconds_since_epoch"])
        end = start + int(description["duration"]["nanoseconds"])
    except (KeyError, TypeError, ValueError):
        return []
    holes = sorted(hole for s in scans for hole in s.holes)
    places = [f"between {(a - start) / SECOND:.3f} s and {(b - start) / SECOND:.3f} s" for a, b in holes[:MAX_PLACES]]
    places += ["at more places"] if len(holes) > MAX_PLACES else []
    places += [f"at the end of {s.path.name}" for s in scans[:-1] if not s.complete]
    last = max((s.last_log_time for s in scans if s.last_log_time is not None), default=start)
    if last < end or not (scans[-1].complete or places):
        places.append(f"the last {max(0, end - last) / SECOND:.3f} s")
    return places
