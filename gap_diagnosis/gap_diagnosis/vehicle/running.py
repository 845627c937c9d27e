"""One filter with its state, which goes on through a recording piece by piece."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.model import Built
from rov_sim.vehicle.innovations import followed_charge, innovations, past_width, states_of, states_width
from rov_sim.vehicle.kernel import FINE
from rov_sim.vehicle.plant import sheet_of, stand_still
from rov_sim.vehicle.tables import STATE

__all__ = ["Running", "State", "followed", "outputs"]

Array = NDArray[np.float64]
State = tuple[Array, ...]


class Running:
    """A filter of one model in a recording."""

    def __init__(self, built: Built, period: float, charge: Array) -> None:
        """Begin as the model does; charge: how a battery's is followed, see `followed`."""
        self.settings = built.settings
        self._sheet, self._tables = sheet_of(built.settings), built.settings.tables
        self._sensing = built.sensors, built.tach / [1.0, period]
        self._steps = built.steps(period)
        self._wrench, self._charge = np.zeros(6), charge
        self._past = np.full(past_width(built.settings.count), np.nan)

    @property
    def state(self) -> State:
        """Of the filter, to be given back to it or to another one."""
        return self._sheet[STATE].copy(), self._wrench, self._charge.copy(), self._past.copy()

    @state.setter
    def state(self, given: State) -> None:
        self._sheet[STATE], self._wrench = given[:2]
        stand_still(self._sheet, self.settings)
        self._charge, self._past = given[2].copy(), given[3].copy()

    def run(
        self, log: VehicleLog, gains: Array, speed_gains: Array, keep: Array, out: Sequence[Array],
        extra: Array | None = None, fidelity: Any = FINE,
    ) -> bool:  # fmt: skip
        """Fill out as `innovations` does and return whether the state stayed finite.

        Args:
            log: a piece of K instants.
            gains, speed_gains: of its filter.
            keep: share of a wrench that is kept for 0 to K periods, (K + 1,).
            out: see `outputs`.
            extra: wrenches (K, 6) beside.
            fidelity: of the kernel's steps.
        """
        carried = self._wrench * keep[:-1, None]
        kernel: Any = innovations
        done = kernel(
            self._sheet, np.ascontiguousarray(log.commands), *self._steps, fidelity,
            carried if extra is None else extra + carried, float(keep[1]), *self._tables, *self._sensing, log.attitude,
            log.told, log.speeds, log.battery, log.lateness, gains, speed_gains, self._charge, self._past, *out,
        )  # fmt: skip
        self._wrench = self._wrench * keep[-1] + states_of(out[3][-1]).wrench * keep[1]
        states_of(out[3]).wrench[:] += carried
        return bool(done == log.count)


def followed(log: VehicleLog, built: Built) -> Array:
    """Return how a battery's charge is followed from a log's first instant on, see `innovations`."""
    charge: Array = followed_charge(rules.CHARGE_TIME / log.period)
    level, rate = built.charge
    charge[0] += level + rate * log.period * log.cut
    charge[2] += rate * log.period
    return charge


def outputs(count: int, thrusters: int, *branches: int) -> list[Array]:
    """Return what `innovations` fills in so many instants, for so many branches, if any, as the first axis."""
    return [np.full((*branches, count, width), np.nan) for width in (13, thrusters, 2, states_width(thrusters))]
