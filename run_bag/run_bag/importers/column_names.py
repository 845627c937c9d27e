"""What the name of a column says."""

import re

__all__ = ["bare_name", "called_time"]

_UNIT = re.compile(r"\s*[\[(][^\])]*[\])]\s*$")
_TIME = re.compile(r"(t|time|timestamp|stamp|elapsed)(_?(s|ms|us|ns|sec|usec|msec))?|seconds", re.IGNORECASE)


def bare_name(name: str) -> str:
    """Return the name of a column without its unit in brackets."""
    return _UNIT.sub("", name).strip().replace(" ", "_")


def called_time(name: str) -> bool:
    """Tell whether a column is called a time."""
    return bool(_TIME.fullmatch(bare_name(name)))
