r"""A vehicle watched on line: parallel filters, one as all is believed to be and one for each failure.

Of each failure the log likelihood ratio of the readings accumulates as CUSUM:

    g <- max(0, g + log p(y | failure) - log p(y | well) - doubt d - forget dt),   alarm at g >= threshold

with d = |r_well - r_failure|^2 / 2, what the failure would gain on average if it were there: the readings must lie well
nearer to the failure, not only as near as a misfit of the healthy vehicle may push them for a while. Of a piece all
count less, by one factor, where the largest g would grow by more than `rules.WATCH_MOST`. A filter of a failure that is
not believed (g = 0) begins at the believed state with each piece, as the failure would. Readings are those without what
the dive differs by from the baseline's (`dive`).

Failures are the hypotheses of single parts whose effects say at which sizes they are followed (`Suspected.watched`), of
sensors that the healthy vehicle had. One that does not matter (a thruster at rest) adds nothing either way. What a
failure of size s changes in the readings, c = r_well - r_failure, tells how large it is:

    size = s sum(r_well c) / sum(c^2),     deviation^2 = theta s^2 / sum(c^2) + (BEND (size - s))^2

with theta of the false alarms' tail, by which log ratios are worth less than they say (`false_alarms`).

Sensors that jump have filters of their own kind (`jumps`); those that tell nothing new are not used (`stuck`). What
was accumulated while a reading stood still is taken back; what a silent sensor left to the others stays.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.baseline import Baseline
from gap_diagnosis.vehicle.branch import Branch, Steered, accumulated, shifted, whitened
from gap_diagnosis.vehicle.dive import Dive
from gap_diagnosis.vehicle.false_alarms import excess, probabilities
from gap_diagnosis.vehicle.filtering import at_rest, rotor_decay, slopes_along, starting, wrench_of
from gap_diagnosis.vehicle.gains import Gains, filter_gains, motion_of, rotor_gains
from gap_diagnosis.vehicle.hypotheses import Hypothesis, described, hypotheses
from gap_diagnosis.vehicle.inflow import thrusts_at
from gap_diagnosis.vehicle.jumps import Jump
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.running import outputs
from gap_diagnosis.vehicle.stuck import Stuck
from rov_sim.vehicle.innovations import states_of

__all__ = ["Alarm", "Watch"]

Array = NDArray[np.float64]
_BEND = 0.1
"""Share of its distance from the size that was followed by which a size errs, as readings are no straight line in it:
losses of 0.6, told by filters of 0.3, came out as 0.60 to 0.67 (tuning seeds 5 and 6)."""


class _Evidence(NamedTuple):
    """For failures that last, each (F,): log ratios; sums since the last reset of r_well c and of c^2, no reading
    bounded, (2, F); since when [s]. Changed in place."""

    ratios: Array
    sums: Array
    since: Array

    def copy(self) -> "_Evidence":
        return _Evidence(*(each.copy() for each in self))

    def take_back(self, before: "_Evidence") -> None:
        for mine, then in zip(self, before, strict=True):
            mine[:] = then

    def begin_anew(self, now: float) -> None:
        self.ratios[:], self.sums[:], self.since[:] = 0.0, 0.0, now

    def add(self, readings: Array, period: float, now: float) -> None:
        """Take whitened readings of a piece that begins at `now` [s]; of all the same share counts, see the module."""
        before, most = self.ratios.copy(), rules.WATCH_MOST * readings.shape[1] * period
        accumulated(
            readings, rules.MOST_DEVIATIONS, rules.WATCH_DOUBT, rules.WATCH_FORGET, period, now, self.ratios, self.sums,
            self.since,
        )  # fmt: skip
        rises = np.maximum(self.ratios - before, 0.0)
        self.ratios[:] -= (1.0 - min(1.0, most / max(float(rises.max()), 1e-9))) * rises


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
        if self.failure.effect == "thrust_loss" and self.size - 3.0 * self.deviation > 1.0:
            return f"thruster {self.failure.thruster}: pushes the other way (loses {size} thrust), {told}"
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


class Watch:
    """All of it; fed with pieces of a log that follow each other without a gap."""

    def __init__(
        self, model: Model, healthy: Baseline, threshold: float = rules.WATCH_THRESHOLD
    ) -> None:  # fmt: skip
        """Begin with what recordings of the healthy vehicle taught."""
        self.threshold = threshold
        self._model, self._noises = model, healthy.noises
        self._conventions, self._stuck = healthy.conventions, Stuck(healthy.unchanged)
        lasting = [(h, size) for h in hypotheses(model, healthy.there) if h.begins for size in h.watched]
        self._sudden = hypotheses(model, healthy.there, sudden=True)
        self._lasting = len(lasting)
        self.followed = lasting + [(h, h.sudden) for h in self._sudden]
        """Failures, each at a size; those that jump last."""
        self._dive = Dive(model, healthy.values, healthy.differing, healthy.run, 1 + len(lasting))
        self._evidence = _Evidence(np.zeros(len(lasting)), np.zeros((2, len(lasting))), np.zeros(len(lasting)))
        self._found = np.full(len(self.followed), np.nan)
        self.time = 0.0
        self._believed = [(self.time, self._evidence.copy(), self._found.copy())]
        """After each piece, back to where a sensor may have got stuck."""
        self.begin()

    @property
    def words(self) -> str:
        """What is watched for, in a sentence."""
        titles = dict.fromkeys(described(h.effect).title for h, _ in self.followed)
        return f"{', '.join(titles)} on {self._model.thrusters} thrusters, the body and its sensors"

    @property
    def ratios(self) -> Array:
        """Log likelihood ratios of `followed`."""
        jumps = [jump.ratio(self.time) for jump in self._jumps] or np.zeros(len(self._sudden))
        return np.concatenate((self._evidence.ratios, jumps))

    @property
    def stuck(self) -> dict[str, str]:
        """Sensors that tell nothing new, in words."""
        return self._stuck.words(self.time)

    def begin(self) -> None:
        """Begin anew with what sensors tell next: after a gap, or where the vehicle was lost."""
        self._branches: list[Branch] = []
        self._jumps: list[Jump] = []
        self._P: Array | None = None
        self._flows: Array | None = None
        self._P_n: Array | None = None
        self._state: Array | None = None
        self._begun = self._known = self.time

    def step(self, log: VehicleLog) -> list[Alarm]:
        """Take the next piece; return what is over the threshold, the strongest first."""
        log = self._read(log)
        if not self._branches:
            self._dive.begin(log)
            self._branches = self._filters(log)
            self._jumps = [Jump(h, self._dive.branch(log)) for h in self._sudden]
        first, by, ends = self._branches[0], self._steered(log), self.time + log.count * log.period
        settling = ends < self._begun + rules.WATCH_SETTLING
        for j in np.flatnonzero(self._evidence.ratios <= 0.0) + 1:  # a failure that is not believed has not begun yet
            self._branches[j].state, self._dive.numbers[j] = first.state, self._dive.numbers[0]
        for jump in self._jumps:
            if jump.outdated(self.time, self.threshold):
                jump.forget(first)
        bank = [*self._branches, *self._dive.branches]
        out = outputs(log.count, log.thrusters, len(bank))
        done = [branch.step(by, tuple(each[j] for each in out)) for j, branch in enumerate(bank)]
        told = whitened(out[0], out[1], by.whitener, by.spread)
        readings = self._dive.freed(told, log.period, learned=not settling)
        for jump in self._jumps:
            self._test(jump, by, out[0][0], out[1][0], settling=settling)
        if settling:
            self._evidence.begin_anew(ends)
        elif not any(jump.size for jump in self._jumps):  # what moves the healthy vehicle's filter tells of no other
            self._evidence.add(readings, log.period, self.time)
        self.time, self._state = ends, out[3][0, -1]
        if not done[0]:  # the vehicle is lost
            self.begin()
        elif not settling and self.time >= self._known + rules.WATCH_KNOWN:
            self._know_dive(log)
        ratios = self.ratios
        self._found[(ratios >= self.threshold) & np.isnan(self._found)] = self.time
        self._found[ratios <= 0.0] = np.nan
        self._believed.append((self.time, self._evidence.copy(), self._found.copy()))
        while len(self._believed) > 1 and self._believed[1][0] <= self._stuck.oldest:
            del self._believed[0]
        return self._alarms()

    def _read(self, log: VehicleLog) -> VehicleLog:
        """Return a piece without what tells nothing new, and without jumps that are known."""
        stuck = set(self._stuck.since)
        log = self._stuck.step(self._conventions.read(log), self.time)
        for name in self._stuck.since.keys() - stuck:
            self._disbelieve(name)
        self._know_jumps()
        for jump in self._jumps:
            log = jump.freed(log)
        return log

    def _test(self, jump: Jump, by: Steered, body: Array, rotor: Array, *, settling: bool) -> None:
        """Take a piece into the filter of a jump, see `Jump.step`."""
        first = self._branches[0]
        if settling:
            jump.forget(first)
        else:
            jump.step(by, body, rotor, self.time)
        if jump.back:
            jump.correct(first)
            self._dive.follow(first)

    def _steered(self, log: VehicleLog) -> Steered:
        """Return what steers all filters through a piece: gains along the states of the healthy vehicle's filter.

        They are at first made as if it stayed where the piece before has ended.
        """
        first, noises, period = self._branches[0], self._noises, log.period
        settings, begun = first.settings, max(round((rules.START - self.time) / period), 0)
        driven = np.isfinite(log.speeds) & ~at_rest(self._model, log, noises)
        speed_gains, spread, P_n = rotor_gains(driven, rotor_decay(self._model, period), noises, self._P_n)
        keep = np.exp(-period / noises.time) ** np.arange(log.count + 1)

        def along(states: Array | None) -> tuple[Gains, Array]:
            A, H, water = slopes_along(self._model, log, states, settings, self._flows)
            speeds = states_of(states).speeds if states is not None else np.zeros(log.speeds.shape)
            thrusts = thrusts_at(settings, np.where(np.isfinite(log.speeds), log.speeds, speeds))
            doubts = wrench_of(settings.coefficients, np.hypot(water.doubts, rules.WATCH_THRUST * thrusts))
            return filter_gains(motion_of(*starting(A, H, log, begun), period, doubts), noises, self._P), water.last

        state, (gains, _) = first.state, along(None if self._state is None else np.tile(self._state, (log.count, 1)))
        out = outputs(log.count, log.thrusters)
        first.step(Steered(log, gains.gains, speed_gains, gains.whitener, spread, keep), tuple(out))
        first.state = state
        gains, self._flows = along(out[3])
        self._P, self._P_n = gains.last, P_n
        return Steered(log, gains.gains, speed_gains, gains.whitener, spread, keep)

    def _filters(self, log: VehicleLog) -> list[Branch]:
        """Return filters that begin: of the healthy vehicle, and of each failure that lasts."""
        lasting = self.followed[: self._lasting]
        return [self._dive.branch(log), *(self._dive.branch(log, (h.active((size,)),)) for h, size in lasting)]

    def _know_dive(self, log: VehicleLog) -> None:
        """Take what is learned of the dive as known, unless a failure or a jump is believed: it may be that."""
        if self.ratios.max() >= self.threshold or any(jump.size for jump in self._jumps):
            return
        states = [branch.state for branch in self._branches]
        moved = self._dive.know(log, self._branches[0])
        self._branches = self._filters(log)
        for branch, state in zip(self._branches, states, strict=True):
            branch.state = shifted(state, moved)
        for jump in self._jumps:
            jump.go_on(self._dive.branch(log), moved)
        self._known = self.time

    def _know_jumps(self) -> None:
        """Take what is believed of jumps as known once one has settled; all else begins anew from the state with it."""
        if not any(jump.settled(self.time, self.threshold) for jump in self._jumps):
            return
        first, believed = self._branches[0], [jump for jump in self._jumps if jump.believed(self.threshold)]
        for jump in believed:
            jump.know(first, self.time)
        self._dive.follow(first)
        for jump in self._jumps:
            jump.forget(first)
        if self._evidence.ratios.max() < self.threshold:
            self._evidence.begin_anew(self.time)
        for branch in self._branches[1:]:  # what was told stays so; nothing has counted since the jump
            branch.state = first.state
        if len(believed) > 1:  # each had a state that the other's jump had moved
            self._begun = self.time

    def _disbelieve(self, sensor: str) -> None:
        """Take back what filters made of a reading that stood still; a silent sensor's own jump is tested no more."""
        since = self._stuck.misleading.get(sensor)
        for jump in self._jumps:
            if since is not None or jump.failure.read_by == sensor:
                jump.forget(self._branches[0])
        if since is None:
            return
        _, then, found = next(each for each in reversed(self._believed) if each[0] <= since)
        self._evidence.take_back(then)
        self._found[: self._lasting] = found[: self._lasting]

    def _alarms(self) -> list[Alarm]:
        """Return what is over the threshold; each failure by the size that is nearer, beside all that are believed."""
        ratios = self.ratios
        if ratios.max() < self.threshold:
            return []
        nearer: dict[Hypothesis, int] = {}
        for j in np.argsort(-ratios):
            if ratios[j] > 0.0:
                nearer.setdefault(self.followed[j][0], int(j))
        leading = list(nearer.values())
        sure = probabilities(list(ratios[leading]))
        told = zip(leading, map(float, ratios[leading]), map(float, sure), strict=True)
        return [self._alarm(j, ratio, p) for j, ratio, p in told if ratio >= self.threshold]

    def _alarm(self, j: int, ratio: float, probability: float) -> Alarm:
        failure, along = self.followed[j]
        if failure.sudden:
            jump = self._jumps[j - len(self.followed)]
            size, deviation, since = jump.total, jump.deviation, jump.since
        else:
            (size, deviation), since = _fitted(along, *self._evidence.sums[:, j]), float(self._evidence.since[j])
        return Alarm(
            failure=failure, size=size, deviation=deviation, log_ratio=ratio, probability=probability,
            since=since, found=float(self._found[j]),
        )  # fmt: skip


def _fitted(along: float, fitted: float, changed: float) -> tuple[float, float]:
    """Return a failure's size and its deviation from both sums along the size that was followed, see the module."""
    size = along * fitted / changed
    return size, float(np.hypot(along * np.sqrt(excess() / changed), _BEND * (size - along)))
