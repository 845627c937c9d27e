"""Outer loop and allocation of a vehicle while odometry arrives: what it remembers, what has failed, what it says."""

from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_control.allocation.allocate import AllocationStatus
from thruster_control.allocation.failures import Failure, FailureKind, allocation, failures_in_words, known, problem
from thruster_control.allocation.settings import AllocationSettings
from thruster_control.outer_loop.controller import Controller, compiled_controller, controller_memory
from thruster_control.outer_loop.settings import VehicleSetPoint
from thruster_control.outer_loop.step import OuterStatus

__all__ = ["HAND_OVER", "NOWHERE", "Answer", "VehicleLoop", "between"]

Array = NDArray[np.float64]
Level = Literal["ok", "warn", "error"]
HAND_OVER = 1.0
"""[s] In which one law becomes another of its kind, so that no wrench jumps."""
NOWHERE = VehicleSetPoint(*5 * ((np.nan, np.nan, np.nan),))
"""No set point."""
_OUTER: dict[OuterStatus, tuple[Level, str]] = {
    OuterStatus.FOLLOWING: ("ok", "following the set point"),
    OuterStatus.ATTITUDE_ONLY: ("warn", "linear velocity is unknown: attitude is controlled, speeds are fed forward"),
    OuterStatus.BEYOND: ("warn", "pitch is steeper than the law is for"),
    OuterStatus.NO_SET_POINT: ("warn", "no set point: no thrust"),
    OuterStatus.NO_STATE: ("error", "odometry without a finite attitude or rates: no thrust"),
    OuterStatus.BAD_PERIOD: ("error", "no valid period: no thrust"),
}
_ALLOCATED: dict[AllocationStatus, tuple[Level, str]] = {
    AllocationStatus.EXACT: ("ok", ""),
    AllocationStatus.REDUCED: ("ok", "thrusters at their limits: less wrench than asked for"),
    AllocationStatus.BEYOND_LIMITS: ("warn", "thrusters are asked for more than they can give"),
    AllocationStatus.NOT_FINITE: ("error", "the wrench is not a number: no thrust"),
}


class Answer(NamedTuple):
    """Thrusts (N,) [N], the wrench (6,) that the law asks for [N, N m], health and why in words."""

    thrusts: Array
    wrench: Array
    level: Level
    words: str


def between(old: Any, new: Any, share: float) -> Any:
    """Return the law that lies between two of one kind: the old one at a share of 0, the new one at 1."""
    if share >= 1.0:
        return new
    mixed = [a + share * (b - a) for a, b in zip(old, new, strict=True)]
    for found, like in zip(mixed, old, strict=True):
        if isinstance(found, np.ndarray):
            found.flags.writeable = like.flags.writeable  # else kernels would be compiled anew
    return type(old)(*mixed)


class VehicleLoop:
    """A controller, its memory and the failures reported to it."""

    def __init__(self, controller: Controller, settings: AllocationSettings, period: float) -> None:
        """Begin at rest; `period` [s] is that of the first step."""
        self._controller, self._settings, self._period = controller, settings, float(period)
        self._law: tuple[Any, Any, float] | None = None  # old and new one, share of the new one
        self._failures: dict[int, Failure] = {}
        self._thrusts = np.zeros(controller.coefficients.K_t.shape[1])
        self._lost = failures_in_words(controller.coefficients.K_t, {}, settings.given_up)
        self.restart()

    def restart(self) -> None:
        """Forget what was: at rest, but for the failures."""
        self._memory = controller_memory(self._thrusts.size)
        self._thrusts[:] = 0.0

    @property
    def law(self) -> Any:
        """The law as it is now."""
        return self._controller.law

    def take_up(self, law: Any) -> None:
        """Let another law of the same kind take over, little by little."""
        self._law = (self.law, law, 0.0)

    @property
    def inflow(self) -> Array:
        """K_t (6, N) of U = K_t^T nu."""
        return np.asarray(self._controller.coefficients.inflow)

    @property
    def thrusters(self) -> int:
        """Number of thrusters."""
        return int(self._thrusts.size)

    def report(self, thruster: int, kind: int, effectiveness: float, stuck_thrust: float) -> str:
        """Take in that a thruster has failed, or is well again; return what is wrong with the report, "" else."""
        if wrong := problem(thruster, kind, effectiveness, stuck_thrust, self.thrusters):
            return wrong
        found = dict(self._failures)
        found.pop(thruster, None)
        if kind != FailureKind.NONE:
            failure = Failure(FailureKind(kind), effectiveness, stuck_thrust)
            found[thruster] = known(failure, float(self._thrusts[thruster]))
        self._failures = dict(sorted(found.items()))
        K_t = self._controller.coefficients.K_t
        self._controller = self._controller._replace(allocation=allocation(K_t, self._settings, self._failures))
        self._lost = failures_in_words(K_t, self._failures, self._settings.given_up)
        return ""

    def advance(self, dt: float | None, q: Sequence[float], nu: Array, set_point: VehicleSetPoint, U: Array) -> Answer:
        """Return the answer to a state, dt [s] after the former one, None for the first; else as `controller_step`."""
        if dt is None:
            self.restart()
        if self._law is not None:
            old, new, share = self._law
            share += (self._period if dt is None else dt) / HAND_OVER
            self._controller = self._controller._replace(law=between(old, new, share))
            self._law = None if share >= 1.0 else (old, new, share)
        outer, allocated, _ = compiled_controller(
            self._memory, np.array(q, dtype=np.float64), nu, set_point, U, self._period if dt is None else dt,
            self._controller, self._thrusts,
        )  # fmt: skip
        level, words = self._in_words(OuterStatus(outer), AllocationStatus(allocated))
        return Answer(self._thrusts.copy(), self._memory.wrench.copy(), level, words)

    def _in_words(self, outer: OuterStatus, allocated: AllocationStatus) -> tuple[Level, str]:
        said = [_OUTER[outer], _ALLOCATED[allocated], ("warn" if self._failures else "ok", self._lost)]
        order: tuple[Level, ...] = ("ok", "warn", "error")
        worst = max((level for level, words in said if words), key=order.index)
        return worst, "; ".join(words for _, words in said if words)  # type: ignore[return-value]
