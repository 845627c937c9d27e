"""What was run: the record that a recording carries, so that it can be understood years later."""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Iterable, Mapping
from datetime import datetime, timezone
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from safe_files.errors import YamlError
from safe_files.yaml_io import parse_yaml

from .errors import InvalidRunError

MAX_FILE_BYTES = 1 << 20
RESERVED = ("recorder", "nodes", "files")


def machine() -> dict[str, Any]:
    """Return host, versions and the time of day."""
    return {
        "started": datetime.now(timezone.utc).isoformat(timespec="milliseconds"),
        "host": platform.node(),
        "system": platform.platform(),
        "python": platform.python_version(),
        "version": _version(),
        "ros_distro": os.environ.get("ROS_DISTRO", ""),
        "ros_domain_id": os.environ.get("ROS_DOMAIN_ID", "0"),
    }


def said_by_the_user(about: str, files: Iterable[str]) -> dict[str, Any]:
    """Return what a user wants to keep with a run.

    Args:
        about: a YAML mapping, for example "{seed: 3, what: dive at the pier}"; "" is none.
        files: text files, such as parameter sets, whose content is kept under "files".

    Raises:
        InvalidRunError: all that is wrong with them.
    """
    problems: list[str] = []
    result: dict[str, Any] = {}
    try:
        loaded = parse_yaml(about, "about") if about.strip() else {}
        if not isinstance(loaded, dict):
            problems.append(f"expected a mapping such as '{{seed: 3}}', found {about!r}")
        else:
            result = plain(loaded)
    except YamlError as error:
        problems.append(f"{about!r} is no YAML: {error.told}")
    problems += [f"the key {key!r} is the recorder's own" for key in RESERVED if key in result]
    contents = {}
    for name in files:
        try:
            if Path(name).stat().st_size > MAX_FILE_BYTES:
                problems.append(f"{name}: larger than {MAX_FILE_BYTES} bytes")
                continue
            contents[name] = Path(name).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            problems.append(f"{name}: cannot be read as text: {error}")
    if problems:
        raise InvalidRunError("about the run", problems)
    return {**result, "files": contents} if contents else result


def plain(value: Any) -> Any:
    """Return a value as JSON has it; numbers that JSON lacks, and anything else, as text."""
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, (bytes, bytearray)):
        return list(value)
    if isinstance(value, (str, bool, int)) or value is None:
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, Iterable):
        return [plain(inner) for inner in value]
    return str(value)


def _version() -> str:
    try:
        return version("run_bag")
    except PackageNotFoundError:
        return "source"
