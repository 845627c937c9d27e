r"""A vehicle watched on line: parallel filters, one as all is believed to be and one for each failure.

Of each failure the log likelihood ratio of the readings accumulates as CUSUM:

    g <- max(0, g + log p(y | failure) - log p(y | well) - forget dt),   alarm at g >= threshold

A failure that does not matter (a thruster at rest) adds nothing either way. Loss of thrust is followed at two sizes, so
that its own size comes from the parabola through both: l(s) = a s - b s^2 / 2.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.filtering import initial_state
from gap_diagnosis.vehicle.gains import Noises, filter_gains, rotor_gains, slopes
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.model import Key, Model
from rov_sim.vehicle.effects.active import ActiveVehicleEffect
from rov_sim.vehicle.innovations import innovations
from rov_sim.vehicle.plant import sheet_of

__all__ = ["Alarm", "Watch"]

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Alarm:
    """A failure: of which thruster or sensor, its size with deviation, log likelihood ratio, since when [s]."""

    effect: str
    thruster: int | None
    sensor: str | None
    size: float
    deviation: float
    log_ratio: float
    since: float

    @property
    def words(self) -> str:
        """It in a sentence."""
        if self.thruster is not None:
            return (
                f"thruster {self.thruster}: loses {100 * self.size:.0f} ± {100 * self.deviation:.0f} % thrust, "
                f"since {self.since:.0f} s"
            )
        return f"{self.sensor}: off by {self.size:.3g}, since {self.since:.0f} s"


class _Branch:
    """One filter of the bank with its state."""

    def __init__(
        self, model: Model, values: Mapping[Key, float], effects: Sequence[ActiveVehicleEffect], log: VehicleLog
    ) -> None:
        self.built = model.built(values, effects, signed=log.signed, initial=initial_state(log))
        self.sheet = sheet_of(self.built.settings)
        self.wrench = np.zeros(6)

    def step(self, log: VehicleLog, gains: Array, speed_gains: Array, keep: float) -> tuple[Array, Array, Array]:
        K, N = log.count, log.thrusters
        out = np.full((K, 13), np.nan), np.full((K, N), np.nan), np.full((K, 2), np.nan), np.zeros((K, 19 + 2 * N))
        steps = self.built.settings.steps_in(log.period)
        carried = self.wrench * keep ** np.arange(K)[:, None]
        kernel: Any = innovations
        kernel(
            self.sheet, np.ascontiguousarray(log.throttles), steps, log.period / steps, carried, keep,
            *self.built.settings.tables, self.built.sensors, self.built.tach, log.attitude, log.told, log.speeds,
            log.battery, log.lateness, gains, speed_gains, *out,
        )  # fmt: skip
        self.wrench = (carried[-1] + out[3][-1, 13:19]) * keep
        return out[0], out[1], out[3]


class Watch:
    """All of it; fed with pieces of a log that follow each other without a gap."""

    def __init__(
        self, model: Model, noises: Noises, values: Mapping[Key, float] | None = None,
        threshold: float = rules.WATCH_THRESHOLD,
    ) -> None:  # fmt: skip
        """Begin with the noises and numbers that a recording of the healthy vehicle gave."""
        self.threshold = threshold
        self._model, self._noises, self._values = model, noises, dict(values or {})
        N = model.thrusters
        self._losses = (rules.WATCH_LOSS, 1.0)
        self.names: list[tuple[str, int | None, str | None, float]] = [
            ("thrust_loss", i, None, s) for i in range(N) for s in self._losses
        ]
        self.names += [
            ("imu_bias", None, f"gyro {axis}", sign * rules.WATCH_BIAS) for axis in "xyz" for sign in (1.0, -1.0)
        ]
        self.ratios = np.zeros(len(self.names))
        self._sums = np.zeros((2, len(self.names)))
        """Since the last reset, no reading bounded: of each size's own log ratio and of the other size's."""
        self._since = np.zeros(len(self.names))
        self._branches: list[_Branch] = []
        self._P: Array | None = None
        self._state: Array | None = None
        self.time = 0.0

    def _effects(self, name: tuple[str, int | None, str | None, float]) -> tuple[ActiveVehicleEffect, ...]:
        effect, thruster, sensor, size = name
        if effect == "thrust_loss":
            return (ActiveVehicleEffect(id=effect, sizes={"share": size}, thruster=thruster),)
        assert sensor is not None
        return (ActiveVehicleEffect(id=effect, sizes={"rate": size}, axis=sensor[-1]),)

    def step(self, log: VehicleLog) -> list[Alarm]:
        """Take the next piece; return what is over the threshold, the strongest first."""
        if not self._branches:
            bank: list[tuple[ActiveVehicleEffect, ...]] = [(), *(self._effects(n) for n in self.names)]
            self._branches = [_Branch(self._model, self._values, effects, log) for effects in bank]
        first, noises = self._branches[0], self._noises
        nu = np.zeros((log.count, 6)) if self._state is None else np.tile(self._state[7:13], (log.count, 1))
        rates = log.told[:, 3:6]
        nu[:, 3:] = np.where(np.isfinite(rates), rates, nu[:, 3:])
        q = np.where(np.isfinite(log.attitude), log.attitude, [1.0, 0.0, 0.0, 0.0])
        places = (np.asarray(getattr(self._model.sensors, s).position) for s in ("imu", "velocity", "depth"))
        A, H = slopes(q, nu, first.built.settings.coefficients, *places)
        there = log.telling
        gains = filter_gains(A, H, there, noises, log.period, self._P)
        self._P = gains.last
        decay = np.array([np.exp(-min(float(s.coefficients.k_n), 50.0) * log.period) for s in self._model.sets])
        speed_gains, spread = rotor_gains(np.isfinite(log.speeds), decay, noises)
        keep = float(np.exp(-log.period / noises.time))
        squares, whole = [], []
        for k, branch in enumerate(self._branches):
            body, rotor, states = branch.step(log, gains.gains, speed_gains, keep)
            r = np.einsum("kij,kj->ki", gains.whitener, np.nan_to_num(body)) * np.isfinite(body)
            r = np.concatenate((r, np.nan_to_num(rotor / spread)), axis=1)
            squares.append(np.minimum(r**2, rules.MOST_DEVIATIONS**2).sum(axis=1))
            whole.append((r**2).sum(axis=1))
            if k == 0:
                self._state = states[-1]
        gained = 0.5 * (squares[0] - np.array(squares[1:])).T  # (K, hypotheses)
        self._accumulate(gained, 0.5 * (whole[0] - np.array(whole[1:])).T, log.period)
        return self._alarms()

    def _accumulate(self, gained: Array, whole: Array, period: float) -> None:
        N = 2 * self._model.thrusters
        for row, every in zip(gained, whole, strict=True):
            self.time += period
            self.ratios += row - rules.WATCH_FORGET * period
            self._sums[0] += every
            self._sums[1, :N] += every[:N].reshape(-1, 2)[:, ::-1].ravel()
            reset = self.ratios < 0.0
            self.ratios[reset], self._sums[:, reset], self._since[reset] = 0.0, 0.0, self.time

    def _alarms(self) -> list[Alarm]:
        found: list[Alarm] = []
        for j in np.argsort(-self.ratios):
            if self.ratios[j] < self.threshold:
                break
            effect, thruster, sensor, size = self.names[j]
            if thruster is not None and any(a.thruster == thruster for a in found):
                continue
            fitted, deviation = size, abs(size)
            if effect == "thrust_loss":
                other = self._losses[1] if size == self._losses[0] else self._losses[0]
                fitted, deviation = _parabola(size, self._sums[0, j], other, self._sums[1, j])
            found.append(
                Alarm(
                    effect=effect,
                    thruster=thruster,
                    sensor=sensor,
                    size=fitted,
                    deviation=deviation,
                    log_ratio=float(self.ratios[j]),
                    since=float(self._since[j]),
                )
            )
        return found


def _parabola(s: float, l: float, t: float, m: float) -> tuple[float, float]:  # noqa: E741
    """Return the top of l(x) = a x - b x^2 / 2 through (s, l) and (t, m), and its deviation."""
    b = 2.0 * (l / s - m / t) / (t - s)
    a = l / s + 0.5 * b * s
    if b <= 0.0:
        return (s if l > m else t), abs(t - s)
    return float(np.clip(a / b, 0.0, 1.2)), float(b**-0.5)
