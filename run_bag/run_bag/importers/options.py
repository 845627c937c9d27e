"""What the user can decide instead of the importer, and what the name of a recording says."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

TACHOMETER_GAIN = 49.9723
"""[rad/s per V] of the bench's tachometer."""
THROTTLE_LIMIT = 5.0
"""[V] of the bench's amplifier, to either side."""
START_NS = 1_000_000_000
"""Stamp of the first csv sample: the date is mostly unknown, so the clock starts at one second."""

_SETTING = re.compile(r"(?:(?P<sign>[pm+-])|_)(?P<volts>\d+(?:[.p]\d+)?)v$", re.IGNORECASE)
_ESTIMATORS = {"KFNLO": "kfnlo", "NLO": "nlo", "KF": "ekf", "1state": "ekf of n"}


@dataclass(frozen=True, kw_only=True)
class BenchOptions:
    """Decisions left to the importer (None, "auto") or taken by the user.

    Attributes:
        throttle_set: signed throttle at the plateau [V]; None: from the name.
        adv: which velocity the velocimeter measured; None: ambient if the name says so, else axial.
        adv_offset: time of the first velocimeter sample after the first load-cell sample [s]; None: 0.
        load_cell: whether the fixture was turned round.
        throttle_limit: largest throttle that the device takes [V]; what is said to be larger is not believed.
        dead_zone_edge: throttle at which the rotor starts, backward and forward [V].
        tachometer_gain: rad/s per volt.
        water: whether the thruster was in water; None: from name and thrust.
    """

    throttle_set: float | None = None
    adv: Literal["axial", "ambient"] | None = None
    adv_offset: float | None = None
    load_cell: Literal["auto", "as-recorded", "reversed"] = "auto"
    throttle_limit: float = THROTTLE_LIMIT
    dead_zone_edge: tuple[float, float] = (-0.83, 0.86)
    tachometer_gain: float = TACHOMETER_GAIN
    water: bool | None = None


def throttle_from_name(stem: str) -> float | None:
    """Return the signed throttle that a name such as "2statem2p5V" or "201808061450_3V" ends in [V]."""
    match = _SETTING.search(stem)
    if match is None:
        return None
    volts = float(match["volts"].lower().replace("p", "."))
    return -volts if match["sign"] in ("m", "M", "-") else volts


def estimator_from_name(stem: str) -> str:
    """Return the estimator that a name such as "CL2stateKFNLO1Step" tells, "" if none."""
    return next((name for key, name in _ESTIMATORS.items() if key.lower() in stem.lower()), "")
