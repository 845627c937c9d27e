"""Where the sign of a speed comes from, where the map does not say it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .decisions import Decisions
from .sources import Array

__all__ = ["SIGN_UNKNOWN", "magnitudes", "of_noise", "sign_source"]

SIGN_UNKNOWN, SIGN_MEASURED = 0, 1
_NEXT_TO_REST = 0.02
"""Of the largest speed: negative readings of less are those of a magnitude whose zero is off, or of noise."""


def sign_source(topic: str, fields: Mapping[str, Any], log: Decisions) -> int:
    """Decide where the sign of n comes from: only a sensor that tells the direction gives negative speeds."""
    channel = f"{topic}.sign_source"
    if np.any(fields["n"] < 0):
        log.add(
            channel, SIGN_MEASURED, "1", "the sensor tells the direction: not in the map, and n is negative at times"
        )
        return SIGN_MEASURED
    log.add(channel, SIGN_UNKNOWN, "1", "n is a magnitude: not in the map, and n is never negative")
    return SIGN_UNKNOWN


def of_noise(topic: str, speeds: Array) -> list[str]:
    """Return the warning about speeds that count as signed by readings that a magnitude may have about rest."""
    lowest, highest = float(np.nanmin(speeds, initial=0.0)), float(np.nanmax(speeds, initial=0.0))
    if not 0.0 < -lowest < _NEXT_TO_REST * highest:
        return []
    channel = f"{topic}.sign_source"
    return [
        f"{channel} is not in the map, and n is never below {lowest:.2g} rad/s, up to {highest:.3g}: {SIGN_MEASURED} "
        f"is written, n is signed; say `{channel}: {{value: {SIGN_UNKNOWN}}}` if the sensor tells no direction and its "
        f"zero is off, {{value: {SIGN_MEASURED}}} if it tells one"
    ]


def magnitudes(topics: Sequence[str]) -> list[str]:
    """Return the warning about speeds that count as magnitudes, one for all of them."""
    if not topics:
        return []
    channel = f"{topics[0]}.sign_source"
    of = "is not in the map" if len(topics) == 1 else f"and those of {', '.join(topics[1:])} are not in the map"
    return [
        f"{channel} {of}, and n is never negative: {SIGN_UNKNOWN} is written, n counts as a magnitude; "
        f"`{channel}: {{value: {SIGN_UNKNOWN}}}` says so without this warning, {{value: {SIGN_MEASURED}}} that the "
        "sensor tells the direction"
    ]
