"""What the name of a column says."""

import re

__all__ = ["bare_name", "called_time", "is_stamp", "unit_behind", "without_unit"]

_UNIT = re.compile(r"(?<=\S)(?!(?<=\w)\[\d+\]\s*$)\s*[\[(](?P<unit>[^\])]*)[\])]\s*$")
"""In brackets behind the name; data[0] is an element of an array."""
_STAMP = re.compile(r"(.*_)?header_stamp|time_(boot_ms|usec)", re.IGNORECASE)
"""Of ROS' and MAVLink's messages."""
_TIME = re.compile(r"%?(t|time|timestamp|stamp|elapsed)(_?(s|ms|us|ns|sec|usec|msec))?|seconds", re.IGNORECASE)


def without_unit(name: str) -> str:
    """Return the name of a column without its unit in brackets."""
    return _UNIT.sub("", name).strip()


def unit_behind(name: str) -> str | None:
    """Return the unit in brackets behind the name of a column, None where there is none."""
    match = _UNIT.search(name)
    return match["unit"] if match else None


def bare_name(name: str) -> str:
    """Return the name of a column without its unit in brackets, as one word: imu.gx is imu_gx."""
    return re.sub(r"[ ./]", "_", without_unit(name))


def called_time(name: str) -> bool:
    """Tell whether a column is called a time."""
    return bool(_TIME.fullmatch(bare_name(name))) or is_stamp(name)


def is_stamp(name: str) -> bool:
    """Tell whether a column is a message's own stamp: when it was measured, not when it was written."""
    return bool(_STAMP.fullmatch(bare_name(name)))
