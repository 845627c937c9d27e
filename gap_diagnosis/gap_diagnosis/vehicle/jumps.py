r"""Sensors whose readings jump, each followed by a filter that does not take a jump for the state.

The filter of a healthy vehicle follows a jump within seconds, and fits as well then as one that knows of it. So a jump
is tested where it begins (Willsky and Jones, 1976). A reading with innovation e of covariance S, of which a jump of
size 1 makes h, tells

    size = h . e / h . h,     deviation = sqrt(h . S h) / h . h

and is taken for one where it is far off and nothing was just before, neither it nor what tells of the motion. All
readings of that sensor are freed of it from then on. One that jumps back soon was an outlier. Two log ratios
accumulate, and the smaller one counts:

    against a vehicle that moved so: the healthy filter's innovations beside this one's, in full
    against outliers: this filter's innovations with the jump left in beside these, each bounded
"""

from collections.abc import Callable
from dataclasses import replace
from math import inf, pi, remainder
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.branch import Branch, Steered, accumulated, shifted, whitened
from gap_diagnosis.vehicle.gains import down_of
from gap_diagnosis.vehicle.hypotheses import Hypothesis
from gap_diagnosis.vehicle.log import CHANNELS_OF, VehicleLog
from gap_diagnosis.vehicle.running import State, outputs
from rov_sim.vehicle.innovations import CHANNELS
from thruster_model.equations.attitude import quaternion_product

__all__ = ["Jump"]

Array = NDArray[np.float64]
_OFTEN = 2.0
"""Times the innovation before it that a jump is: a vehicle that moves unforeseen, or a drift, has come nearer to it."""
_MISLED = 1.0
"""[s] before a jump in which no reading that tells of the motion was an outlier that leads a filter as far astray."""


class _Sensor(NamedTuple):
    """What a jump of 1 adds to the innovations (K, 13); a log freed of a jump; size that is none, a full turn."""

    sight: Callable[[VehicleLog], Array]
    freed: Callable[[VehicleLog, float], VehicleLog]
    turn: float


def _depth_sight(log: VehicleLog) -> Array:
    sight = np.zeros((log.count, CHANNELS))
    sight[:, CHANNELS_OF["depth"]] = 1.0
    return sight


def _heading_sight(log: VehicleLog) -> Array:
    """Return it of a yaw, about the earth's down in the axes of the attitude."""
    sight = np.zeros((log.count, CHANNELS))
    sight[:, CHANNELS_OF["attitude"]] = np.nan_to_num(down_of(log.attitude))
    return sight


def _depth_freed(log: VehicleLog, size: float) -> VehicleLog:
    told = log.told.copy()
    told[:, CHANNELS_OF["depth"]] -= size
    return replace(log, told=told)


def _heading_freed(log: VehicleLog, size: float) -> VehicleLog:
    back = (np.cos(0.5 * size), 0.0, 0.0, -np.sin(0.5 * size))
    turned = np.stack(quaternion_product(back, log.attitude.T), axis=1)
    return replace(log, attitude=turned)


_SENSORS = {
    "depth": _Sensor(_depth_sight, _depth_freed, inf),
    "attitude": _Sensor(_heading_sight, _heading_freed, 2.0 * pi),
}


class Jump:
    """One such sensor with its filter.

    Attributes:
        failure: that begins with a jump.
        off: what its readings are known to be off by and freed of; size: what they are believed to be off by beside, 0:
            nothing; deviation: of both.
        since: when they began to be [s].
        back: whether they jumped back in the last piece: an outlier, of which the state of its filter knows nothing.
    """

    def __init__(self, failure: Hypothesis, branch: Branch) -> None:
        """Begin with a sensor that is well and a filter of the healthy vehicle."""
        self.failure = failure
        self.off = self.size = self.deviation = self.since = 0.0
        self._of, self._branch = _SENSORS[failure.read_by], branch
        self._least, self.back = 0.5 * failure.sudden, False
        self._ratios, self._before, self._moved, self._lost = np.zeros(2), 0.0, 0.0, False
        self._known, self._told, self._until, self._misled = (0.0, 0.0), 0.0, -inf, -inf

    def ratio(self, now: float) -> float:
        """Return its log likelihood ratio, for a while that of a jump that is known; 0 where it has jumped back."""
        if abs(self.total) < self._least:
            return 0.0
        return max(float(self._ratios.min()), self._told if now < self._until else 0.0)

    @property
    def total(self) -> float:
        """What its readings are off by."""
        return remainder(self.off + self.size, self._of.turn)

    def freed(self, log: VehicleLog) -> VehicleLog:
        """Return a log without what is known."""
        return self._of.freed(log, self.off) if self.off else log

    def go_on(self, branch: Branch, moved: State) -> None:
        """Go on with another filter from where the present one is, moved by so much."""
        branch.state = shifted(self._branch.state, moved)
        self._branch = branch

    def forget(self, healthy: Branch) -> None:
        """Believe nothing beside what is known, and take the state of the healthy vehicle."""
        self._branch.state = healthy.state
        self._before, self._lost = 0.0, False
        self._disbelieve()

    def correct(self, healthy: Branch) -> None:
        """Give the healthy vehicle's filter the state of this one."""
        healthy.state = self._branch.state

    def _disbelieve(self) -> None:
        self.size, self._ratios[:] = 0.0, 0.0
        self.deviation, self.since = self._known

    def outdated(self, now: float, threshold: float) -> bool:
        """Tell whether what it followed is lost, or is not believed and will not be."""
        against = self._ratios[0] < threshold and self._ratios[0] <= self._moved
        late = now - self.since > rules.WATCH_JUMP[1]
        return self._lost or (self.size != 0.0 and (self._ratios.min() <= 0.0 or against or late))

    def believed(self, threshold: float) -> bool:
        """Tell whether there is enough evidence for it."""
        return bool(self._ratios.min() >= threshold)

    def settled(self, now: float, threshold: float) -> bool:
        """Tell whether it is believed and began long enough ago to be known."""
        return self.believed(threshold) and now - self.since > rules.WATCH_JUMP[0]

    def know(self, healthy: Branch, now: float) -> None:
        """Free readings of it from now on, and give the healthy vehicle's filter the state that goes with that."""
        self.off, self._told, self._until = self.total, float(self._ratios.min()), now + rules.WATCH_TOLD
        self._known = self.deviation, self.since
        self.correct(healthy)
        self.forget(healthy)

    def step(self, by: Steered, body: Array, rotor: Array, begun: float) -> None:
        """Take a piece that begins at `begun` [s].

        body, rotor: innovations (K, 13) and (K, N) of the healthy vehicle's filter.
        """
        K, at, jumped, self._moved, self.back = by.log.count, 0, False, float(self._ratios[0]), False
        sight = self._of.sight(by.log)
        while True:
            rest, before = by.part(at, K), self._branch.state
            out, self._lost = self._followed(rest)
            S = _covariances(rest.whitener)
            sizes, deviations = _sizes(S, out[0], sight[at:])
            now = begun + by.log.period * np.arange(at, K, dtype=np.float64)
            astray = _astray(S, out[0], by.log.period, self._least)
            misled = np.maximum.accumulate(np.where(astray, now, self._misled))
            first = self._surprise(sizes, deviations, now - misled > _MISLED, int(jumped))
            self._misled = float(misled[min(first, K - at - 1)])
            if first < K - at:  # again, up to there
                self._branch.state = before
                if first > 0:
                    self._followed(rest.part(0, first))
            self._accumulate(rest, (body[at:], rotor[at:]), (out[0], out[1]), sight[at:], first)
            at += first
            if at == K:
                return
            jumped = True
            self._take(float(sizes[first]), float(deviations[first]), begun + at * by.log.period)

    def _followed(self, by: Steered) -> tuple[list[Array], bool]:
        out = outputs(by.log.count, by.log.thrusters)
        log = self._of.freed(by.log, self.size) if self.size else by.log
        return out, not self._branch.step(by._replace(log=log), tuple(out))

    def _surprise(self, sizes: Array, deviations: Array, led: NDArray[np.bool_], first: int) -> int:
        """Return the first row, from `first` on, in which a jump begins; their count where none does."""
        for k in np.flatnonzero(np.isfinite(sizes)):
            size, before = abs(sizes[k]), self._before
            least = max(self._least, rules.MOST_DEVIATIONS * deviations[k], _OFTEN * before)
            if k >= first and size > least and led[k]:
                return int(k)
            self._before = size
        return len(sizes)

    def _take(self, size: float, deviation: float, now: float) -> None:
        """Take a reading for a jump by so much more."""
        new = remainder(self.size + size, self._of.turn)
        self._before = 0.0
        if abs(new) < max(self._least, rules.MOST_DEVIATIONS * deviation):
            self._disbelieve()
            self.back = True
            return
        if self.size == 0.0:
            self.since = now
        else:  # as an outlier costs
            self._ratios[1] = max(self._ratios[1] - 0.5 * rules.MOST_DEVIATIONS**2, 0.0)
        self.size, self.deviation = new, float(np.hypot(self.deviation, deviation))

    def _accumulate(
        self, by: Steered, healthy: tuple[Array, Array], own: tuple[Array, Array], sight: Array, count: int
    ) -> None:  # fmt: skip
        """Add the first instants to both log ratios."""
        if self.size == 0.0 or count == 0:
            return
        (body, rotor), left_in = own, own[0] + self.size * sight
        for j, (most, other) in enumerate(((inf, healthy), (rules.MOST_DEVIATIONS, (left_in, rotor)))):
            bodies, rotors = (np.stack(each)[:, :count].copy() for each in zip(other, (body, rotor), strict=True))
            accumulated(
                whitened(bodies, rotors, by.whitener[:count], by.spread[:count]), most, rules.WATCH_DOUBT,
                rules.WATCH_FORGET, by.log.period, 0.0, self._ratios[j : j + 1], np.zeros((2, 1)), np.zeros(1),
            )  # fmt: skip


def _covariances(whitener: Array) -> Array:
    """Return S (K, 13, 13) of the innovations; that of one that nothing tells is 1."""
    silent = np.einsum("kii->ki", whitener) == 0.0
    L = np.linalg.inv(whitener + silent[:, :, None] * np.eye(CHANNELS))
    return np.asarray(L @ L.transpose(0, 2, 1))


def _sizes(S: Array, e: Array, sight: Array) -> tuple[Array, Array]:
    """Return the size of a jump that each row of innovations e (K, 13) tells, NaN: none, and its deviation."""
    square = np.einsum("ki,ki->k", sight, sight)
    told = np.einsum("ki,ki->k", sight, np.where(sight == 0.0, 0.0, e))
    with np.errstate(invalid="ignore"):
        return told / square, np.sqrt(np.einsum("ki,kij,kj->k", sight, S, sight)) / square


def _astray(S: Array, e: Array, period: float, least: float) -> NDArray[np.bool_]:
    """Return which rows of innovations e (K, 13) lead a filter astray: outliers of what tells of the motion that move
    it by `least` [rad, m] in `_MISLED`; an acceleration acts for a period [s]."""
    speeds = np.abs(e) * np.repeat((0.0, 1.0, period, 0.0, 1.0), (3, 3, 3, 1, 3))
    with np.errstate(invalid="ignore"):
        far = e**2 > rules.LONE_NOISE**2 * np.einsum("kii->ki", S)
        return np.asarray((far & (_MISLED * speeds > least)).any(axis=1))
