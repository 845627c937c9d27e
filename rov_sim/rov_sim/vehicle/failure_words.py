"""Failures of thrusters and sensors to come, in words such as 'T2 dead at 12 s; velocity lost at 8 s'."""

import re
from math import nan

from rov_sim.vehicle.live import LOSABLE, Failing, FailureKind, Losing

__all__ = ["parse_failures"]

_FAILURE = re.compile(r"T(\d+)\s+(dead|weak|stuck)(?:\s+([\d.eE+-]+))?\s+at\s+([\d.eE+-]+)\s*s?", re.IGNORECASE)
_LOSS = re.compile(rf"({'|'.join(LOSABLE)})\s+lost\s+at\s+(\d[\d.eE+-]*)\s*s?", re.IGNORECASE)


def parse_failures(text: str) -> tuple[tuple[Failing, ...], tuple[Losing, ...]]:
    """Return the failures of thrusters and the losses of sensors that a text names; thrusters count from T1.

    Raises:
        ValueError: with each part of the text that names none.
    """
    found, lost, wrong = [], [], []
    for part in filter(None, map(str.strip, text.split(";"))):
        try:
            if match := _LOSS.fullmatch(part):
                lost.append(Losing(match[1].lower(), float(match[2])))
                continue
            match = _FAILURE.fullmatch(part)
            if match is not None and int(match[1]) >= 1 and (match[2].lower() == "weak") == (match[3] is not None):
                share = nan if match[3] is None else float(match[3])
                found.append(Failing(int(match[1]) - 1, FailureKind[match[2].upper()], float(match[4]), share))
                continue
        except ValueError:  # a number that is none
            pass
        expected = "'T2 dead at 12 s', 'T1 weak 0.5 at 20 s' or 'velocity lost at 8 s'"
        wrong.append(f"failures: expected such as {expected}; found {part!r}")
    if wrong:
        raise ValueError("; ".join(wrong))
    return tuple(found), tuple(lost)
