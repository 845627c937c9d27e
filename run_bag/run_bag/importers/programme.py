"""The throttle of an open-loop recording, which was not logged, from the times at which the rotor answered.

The bench's programme is a straight line from 0 V to the setting over two seconds, held for eight, then off (thesis,
4.1.2). The rotor starts when the line leaves the dead zone, so what `ramp.fit_ramp` sees is only the end of the line:
its plateau is reached R = 2 s after the throttle began, whatever the dead zone is, and its shutdown comes 10 s after
that. Where ramp or plateau do not have the lengths that this implies, the throttle is taken to have jumped to the edge
of the dead zone and gone straight to the setting from there. Outside the dead zone the two hardly differ.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .decisions import Decisions
from .ramp import Ramp

Array = NDArray[np.float64]
RAMP = 2.0  # [s] from 0 V to the setting
HOLD = 8.0  # [s] at the setting
EDGE_TOLERANCE = 0.15  # [V] by which the edge of the dead zone may be off
HOLD_TOLERANCE = 0.2  # [s] between the plateau seen and HOLD
LEAST_STD = 0.01  # [s] the times of one recording are not known better than the sampling of the programme


@dataclass(frozen=True, kw_only=True)
class Programme:
    """A reconstructed throttle: from `first` [V] at `on` [s] straight to `setting` [V] at `reached`, 0 V from `off`."""

    first: float
    setting: float
    on: float
    on_std: float
    reached: float
    off: float

    def throttle(self, time: Array) -> Array:
        """Return the throttle [V] at these times [s]."""
        fraction = np.clip((time - self.on) / max(self.reached - self.on, 1e-9), 0.0, 1.0)
        running = (time >= self.on) & (time < self.off)
        return np.where(running, self.first + fraction * (self.setting - self.first), 0.0)


def programme(ramp: Ramp, setting: float, edge: float, log: Decisions) -> Programme:
    """Return the programme that explains the ramp, and log what was decided.

    Args:
        ramp: as seen in |n|.
        setting: throttle at the plateau [V].
        edge: of the dead zone on that side [V].
        log: gets the decisions.
    """
    implied = RAMP * (1.0 - edge / setting)
    hold = ramp.shutdown - ramp.start - ramp.duration
    as_long = abs(ramp.duration - implied) < RAMP * EDGE_TOLERANCE / abs(setting)
    if not (as_long and abs(hold - HOLD) < HOLD_TOLERANCE):
        how = (
            f"ramp and plateau last {ramp.duration:.2f} and {hold:.2f} s; the bench's line from 0 V would show "
            f"{implied:.2f} and {HOLD:.2f} s: taken as a line from the edge of the dead zone"
        )
        log.add("throttle at the start of the ramp", edge, "V", how)
        found = Programme(
            first=edge,
            setting=setting,
            on=ramp.start,
            on_std=max(ramp.start_std, LEAST_STD),
            reached=ramp.start + ramp.duration,
            off=ramp.shutdown,
        )
    else:
        found = _line_from_zero(ramp, setting, log)
    log.add("throttle switched on", found.on, "s", "see the start of the ramp", found.on_std)
    return found


def _line_from_zero(ramp: Ramp, setting: float, log: Decisions) -> Programme:
    reached = ramp.start + ramp.duration
    estimates = np.array([reached - RAMP, ramp.shutdown - RAMP - HOLD])
    deviations = np.array([np.hypot(ramp.start_std, ramp.duration_std), ramp.shutdown_std])
    weights = 1.0 / np.maximum(deviations, LEAST_STD) ** 2
    on = float(np.average(estimates, weights=weights))
    spread = float(np.ptp(estimates)) / 2.0
    how = (
        f"a line from 0 V over {RAMP:g} s, held for {HOLD:g} s (thesis 4.1.2): it begins {RAMP:g} s before the plateau "
        f"of |n| and {RAMP + HOLD:g} s before the shutdown; the mean of both, weighed by their deviations"
    )
    log.add("throttle at the start of the ramp", 0.0, "V", how)
    return Programme(
        first=0.0,
        setting=setting,
        on=on,
        on_std=max(float(weights.sum() ** -0.5), spread, LEAST_STD),
        reached=on + RAMP,
        off=ramp.shutdown,
    )
