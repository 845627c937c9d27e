r"""A vehicle watched on line: parallel filters, one as all is believed to be and one for each failure.

Of each failure the log likelihood ratio of the readings accumulates as CUSUM:

    g <- max(0, g + log p(y | failure) - log p(y | well) - doubt d - forget dt),   alarm at g >= threshold

with d = |r_well - r_failure|^2 / 2, what the failure would gain on average if it were there: the readings must lie well
nearer to the failure, not only as near as a misfit of the healthy vehicle may push them for a while. A filter of a
failure that is not believed (g = 0) begins at the believed state with each piece, as the failure would.

Failures are the hypotheses of single parts whose effects say at which sizes they are followed (`Suspected.watched`), of
sensors that the healthy vehicle had. One that does not matter (a thruster at rest) adds nothing either way. What a
failure of size s changes in the readings, c = r_well - r_failure, tells how large it is:

    size = s sum(r_well c) / sum(c^2),     deviation^2 = theta s^2 / sum(c^2) + (BEND (size - s))^2

with theta of the false alarms' tail, by which log ratios are worth less than they say (`false_alarms`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.baseline import Baseline
from gap_diagnosis.vehicle.false_alarms import excess, probabilities
from gap_diagnosis.vehicle.filtering import at_rest, followed, initial_state, rotor_decay, starting
from gap_diagnosis.vehicle.gains import filter_gains, motion_of, rotor_gains, slopes
from gap_diagnosis.vehicle.hypotheses import Hypothesis, described, hypotheses
from gap_diagnosis.vehicle.inflow import inflow, thrusts_at
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.unknowns import Key
from rov_sim.vehicle.effects.active import VEHICLE_LIBRARY, ActiveVehicleEffect
from rov_sim.vehicle.innovations import innovations, past_width, states_of, states_width
from rov_sim.vehicle.kernel import FINE
from rov_sim.vehicle.plant import sheet_of
from rov_sim.vehicle.tables import STATE
from thruster_model.compilation import compiled

__all__ = ["Alarm", "Watch"]

Array = NDArray[np.float64]
_FARTHEST = 1e3  # deviations: farther out a filter is lost, not more or less so
_BEND = 0.1
"""Share of its distance from the size that was followed by which a size errs, as readings are no straight line in it:
losses of 0.6, told by filters of 0.3, came out as 0.60 to 0.67 (tuning seeds 5 and 6)."""


@dataclass(frozen=True, kw_only=True)
class Alarm:
    """A failure, its size with deviation, log likelihood ratio, probability, since when and found when [s]."""

    failure: Hypothesis
    size: float
    deviation: float
    log_ratio: float
    probability: float
    since: float
    found: float

    @property
    def words(self) -> str:
        """It in a sentence."""
        sure = f"p {self.probability:.2f}" if self.probability < 0.995 else "p > 0.99"
        told = f"{sure}; {self.found - self.since:.0f} s after it began"
        unit = self.failure.units[self.failure.parameters[0]]
        scale, unit = (100.0, "%") if unit == "1" else (1.0, unit)
        size = f"{_told(scale * self.size, scale * self.deviation)} {unit}"
        if self.failure.effect == "thrust_loss":
            return f"thruster {self.failure.thruster}: loses {size} thrust, {told}"
        return f"{self.failure.words}: {size}, {told}"

    @property
    def name(self) -> str:
        """Identifier of the failure: its effect, what it acts on and the parameter that is off."""
        place = [str(part) for part in self.failure.place[1:] if part is not None]
        return " ".join((self.failure.effect, *place, self.failure.parameters[0]))


def _told(value: float, deviation: float) -> str:
    """Return both in words; the deviation has a digit that is not 0, and the value no more places than it."""
    places = max(0, -int(np.floor(np.log10(deviation))))
    return f"{value:.{places}f} ± {deviation:.{places}f}"


class _Branch:
    """One filter of the bank with its state."""

    def __init__(
        self, model: Model, values: Mapping[Key, float], effects: Sequence[ActiveVehicleEffect], log: VehicleLog
    ) -> None:
        built = model.built(values, effects, signed=log.signed, initial=initial_state(log))
        self.body = built.settings.coefficients
        self._sheet, self._tables = sheet_of(built.settings), built.settings.tables
        self._sensing = built.sensors, built.tach / [1.0, log.period]
        self._steps = built.steps(log.period)
        self._wrench, self._charge = np.zeros(6), followed(log, built)
        self._past = np.full(past_width(log.thrusters), np.nan)

    def follow(self, other: "_Branch") -> None:
        """Take the state of another branch of this bank."""
        self._sheet[STATE] = other._sheet[STATE]
        self._wrench, self._charge, self._past = other._wrench, other._charge.copy(), other._past.copy()

    def step(self, log: VehicleLog, gains: Array, speed_gains: Array, keep: Array, out: tuple[Array, ...]) -> bool:
        """Fill out as `innovations` does and return whether the state stayed finite; keep: (K,), of the wrench."""
        carried = self._wrench * keep[:-1, None]
        kernel: Any = innovations
        done = kernel(
            self._sheet, np.ascontiguousarray(log.commands), *self._steps, FINE, carried,
            float(keep[1]), *self._tables, *self._sensing, log.attitude, log.told, log.speeds, log.battery,
            log.lateness, gains, speed_gains, self._charge, self._past, *out,
        )  # fmt: skip
        self._wrench = self._wrench * keep[-1] + states_of(out[3][-1]).wrench * keep[1]
        return bool(done == log.count)


@compiled
def _accumulated(  # type: ignore[no-untyped-def]
    body, rotor, whitener, spread, most, doubt, forget, period, begun, ratios, sums, since
):
    """Take innovations (B, K, 13) and (B, K, N) of the bank, as all is believed to be first, into the log ratios.

    A reading that is far from what is believed counts less, by 1 / (1 + r^2 / most^2): the most that one can add is
    most^2 / 2, and failures are still told from each other where all of them are far off. One that a failure's filter
    no longer foresees, since its state is not finite, is as far off as can be.
    """
    B, K, M = body.shape
    N = rotor.shape[2]
    believed, gained, fitted, changed = np.zeros(M + N), np.zeros(B), np.zeros(B), np.zeros(B)
    for k in range(K):
        now = begun + (k + 1) * period
        for j in range(B):
            gained[j], fitted[j], changed[j] = 0.0, 0.0, 0.0
            for i in range(M + N):
                if i < M:
                    there, r = np.isfinite(body[0, k, i]), 0.0
                    for m in range(M):
                        r += whitener[k, i, m] * body[j, k, m] if np.isfinite(body[0, k, m]) else 0.0
                else:
                    there, r = np.isfinite(rotor[0, k, i - M]), rotor[j, k, i - M] / spread[k, i - M]
                if there:
                    r = min(max(r, -_FARTHEST), _FARTHEST) if np.isfinite(r) else _FARTHEST
                    believed[i] = r if j == 0 else believed[i]
                    well = believed[i]
                    weight = 1.0 / (1.0 + (well / most) ** 2)
                    gained[j] += weight * (well * well - r * r - doubt * (well - r) ** 2)
                    fitted[j] += well * (well - r)
                    changed[j] += (well - r) ** 2
        for j in range(B - 1):
            ratios[j] += 0.5 * gained[j + 1] - forget * period
            sums[0, j] += fitted[j + 1]
            sums[1, j] += changed[j + 1]
            if ratios[j] < 0.0:
                ratios[j], sums[0, j], sums[1, j], since[j] = 0.0, 0.0, 0.0, now


class Watch:
    """All of it; fed with pieces of a log that follow each other without a gap."""

    def __init__(
        self, model: Model, healthy: Baseline, threshold: float = rules.WATCH_THRESHOLD
    ) -> None:  # fmt: skip
        """Begin with what recordings of the healthy vehicle taught."""
        self.threshold = threshold
        self._model, self._values, self._noises = model, healthy.values, healthy.noises
        self._conventions = healthy.conventions
        self.followed = [(h, size) for h in _of_single_parts(model, healthy.there) for size in h.watched]
        """Failures, each at a size."""
        self.ratios = np.zeros(len(self.followed))
        self._sums = np.zeros((2, len(self.followed)))
        """Since the last reset, no reading bounded: of r_well c and of c^2, see the module."""
        self._since, self._found = np.zeros(len(self.followed)), np.full(len(self.followed), np.nan)
        self.time = 0.0
        self.begin()

    @property
    def words(self) -> str:
        """What is watched for, in a sentence."""
        titles = dict.fromkeys(described(h.effect).title for h, _ in self.followed)
        return f"{', '.join(titles)} on {self._model.thrusters} thrusters, the body and its sensors"

    def begin(self) -> None:
        """Begin anew with what sensors tell next: after a gap, or where the vehicle was lost."""
        self._branches: list[_Branch] = []
        self._P: Array | None = None
        self._flows: Array | None = None
        self._P_n: Array | None = None
        self._state: Array | None = None
        self._begun = self.time

    def step(self, log: VehicleLog) -> list[Alarm]:
        """Take the next piece; return what is over the threshold, the strongest first."""
        log = self._conventions.read(log)
        if not self._branches:
            bank: list[tuple[ActiveVehicleEffect, ...]] = [(), *((h.active((size,)),) for h, size in self.followed)]
            self._branches = [_Branch(self._model, self._values, effects, log) for effects in bank]
        first, noises = self._branches[0], self._noises
        nu = np.zeros((log.count, 6)) if self._state is None else np.tile(states_of(self._state).nu, (log.count, 1))
        rates = log.told[:, 3:6]
        nu[:, 3:] = np.where(np.isfinite(rates), rates, nu[:, 3:])
        q = np.where(np.isfinite(log.attitude), log.attitude, [1.0, 0.0, 0.0, 0.0])
        places = (np.asarray(getattr(self._model.sensors, s).position) for s in ("imu", "velocity", "depth"))
        N, K_t = log.thrusters, first.body.K_t
        n, v = np.zeros((2, log.count, N))
        if self._state is not None:
            n, v = n + states_of(self._state).speeds, v + states_of(self._state).flows
        own = [s.coefficients for s in self._model.sets]
        water = inflow(own, first.body, nu, n, v, log.period, self._flows)
        A, H = slopes(q, nu, water.slopes, first.body, *places)
        thrusts = thrusts_at(own, first.body, np.where(np.isfinite(log.speeds), log.speeds, n))
        doubts = (K_t * np.hypot(water.doubts, rules.WATCH_THRUST * thrusts)[:, None] ** 2) @ K_t.T
        begun = max(round((rules.START - self.time) / log.period), 0)
        gains = filter_gains(motion_of(*starting(A, H, log, begun), log.period, doubts), noises, self._P)
        self._P, self._flows = gains.last, water.last
        driven = np.isfinite(log.speeds) & ~at_rest(self._model, log, noises)
        decay = rotor_decay(self._model, log.period)
        speed_gains, spread, self._P_n = rotor_gains(driven, decay, noises, self._P_n)
        keep = np.exp(-log.period / noises.time) ** np.arange(log.count + 1)
        for ratio, branch in zip(self.ratios, self._branches[1:], strict=True):
            if ratio <= 0.0:  # a failure that is not believed has not begun yet
                branch.follow(first)
        B, K = len(self._branches), log.count
        out = [np.full((B, K, width), np.nan) for width in (13, N, 2, states_width(N))]
        done = [
            branch.step(log, gains.gains, speed_gains, keep, tuple(each[j] for each in out))
            for j, branch in enumerate(self._branches)
        ]
        _accumulated(
            out[0], out[1], gains.whitener, spread, rules.MOST_DEVIATIONS, rules.WATCH_DOUBT, rules.WATCH_FORGET,
            log.period, self.time, self.ratios, self._sums, self._since,
        )  # fmt: skip
        self.time += K * log.period
        self._state = out[3][0, -1]
        if self.time < self._begun + rules.WATCH_SETTLING:
            self.ratios[:], self._sums[:], self._since[:] = 0.0, 0.0, self.time
        if not done[0]:  # the vehicle is lost
            self.begin()
        over = self.ratios >= self.threshold
        self._found[over & np.isnan(self._found)] = self.time
        self._found[self.ratios <= 0.0] = np.nan
        return self._alarms()

    def _alarms(self) -> list[Alarm]:
        """Return what is over the threshold; each failure by the size that is nearer, beside all that are believed."""
        if self.ratios.max() < self.threshold:
            return []
        nearer: dict[Hypothesis, int] = {}
        for j in np.argsort(-self.ratios):
            if self.ratios[j] > 0.0:
                nearer.setdefault(self.followed[j][0], int(j))
        leading = list(nearer.values())
        sure = probabilities(list(self.ratios[leading]))
        return [
            self._alarm(j, float(p)) for j, p in zip(leading, sure, strict=True) if self.ratios[j] >= self.threshold
        ]

    def _alarm(self, j: int, probability: float) -> Alarm:
        failure, size = self.followed[j]
        fitted, deviation = _fitted(size, *self._sums[:, j])
        return Alarm(
            failure=failure, size=fitted, deviation=deviation, log_ratio=float(self.ratios[j]),
            probability=probability, since=float(self._since[j]), found=float(self._found[j]),
        )  # fmt: skip


def _of_single_parts(model: Model, there: Mapping[str, bool]) -> list[Hypothesis]:
    """Return the hypotheses that these sensors can show and that are not of all thrusters at once."""
    return [h for h in hypotheses(model, there) if h.thruster is not None or h.effect in VEHICLE_LIBRARY]


def _fitted(along: float, fitted: float, changed: float) -> tuple[float, float]:
    """Return a failure's size and its deviation from both sums along the size that was followed, see the module."""
    size = along * fitted / changed
    return size, float(np.hypot(along * np.sqrt(excess() / changed), _BEND * (size - along)))
