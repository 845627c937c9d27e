r"""What one dive differs by from those of the baseline, learned while it lasts: biases of its sensors, its trim.

Readings are nearly linear in numbers b as small as these. One filter more for each, of the healthy vehicle with b = 1
(its deviation from dive to dive), tells what it makes of a whitened reading, c = r_well - r_with. Beside each failure,
and beside none, b is estimated from the readings before (recursive least squares):

    r' = (r - c . b) / sqrt(s),    s = 1 + c P c,    b <- b + P c (r - c . b) / s,    P <- P - P c c P / s

and from instant to instant b <- k b, P <- k P k + I - k k: biases wander, and stay within their deviations; a trim, or
the charge as a dive begins, stays (k = 1). So r' is of unit variance where the failure is there, and one failure
differs from another by what these numbers cannot be.

Linear they are next to what the filters know. An accelerometer that is 0.07 m/s^2 off moves the velocity of a filter by
5 cm/s, and one of a velocity log with another scale reads less of that, which no c tells. So what is learned becomes
known now and then: the filters have it from there on, and their states are where it would have led them.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.branch import FARTHEST, Branch, shifted
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.running import State
from gap_diagnosis.vehicle.unknowns import Key
from rov_sim.vehicle.effects.active import ActiveVehicleEffect
from thruster_model.compilation import compiled

__all__ = ["Dive"]

Array = NDArray[np.float64]
_WANDERING = ("gyro", "force", "tilt")
"""First parts of keys of numbers that change during a dive: biases of sensors."""


class Dive:
    """Numbers of a dive beside each of some failures, the first of which is none.

    Attributes:
        numbers: beyond what is known, in their deviations, (failures, S).
        branches: a filter for each number, (S,).
    """

    def __init__(
        self, model: Model, values: Mapping[Key, float], deviations: Mapping[Key, float], run: int, failures: int
    ) -> None:
        """Believe that this dive is as the others.

        Args:
            model, values: of the healthy vehicle.
            deviations: of the numbers, by key, of the recording of number `run`.
            failures: how many there are, none included.
        """
        self._model, self._deviations, self._run = model, deviations, run
        self._values = {**values, **dict.fromkeys(deviations, 0.0)}
        self.numbers = np.zeros((failures, len(deviations)))
        self._P, self._wanders = np.eye(len(deviations)), np.array([key[0] in _WANDERING for key in deviations])
        self.branches: list[Branch] = []

    def begin(self, log: VehicleLog) -> None:
        """Begin with filters anew; what was learned stays."""
        self.branches = [self.branch(log, beside={key: size}) for key, size in self._deviations.items()]

    def branch(
        self, log: VehicleLog, effects: Sequence[ActiveVehicleEffect] = (), beside: Mapping[Key, float] | None = None
    ) -> Branch:  # fmt: skip
        """Return a filter of the vehicle with what is known of this dive, with effects or with numbers beside that."""
        values = self._values | {key: self._values[key] + size for key, size in (beside or {}).items()}
        return Branch(self._model, values, effects, log, self._run)

    def know(self, log: VehicleLog, healthy: Branch) -> State:
        """Take what is learned beside none as known from here on; return by how much that moves a filter's state."""
        by, states, well = self.numbers[0].copy(), [each.state for each in self.branches], healthy.state
        moved = tuple(
            np.nan_to_num(sum(b * (state[part] - well[part]) for b, state in zip(by, states, strict=True)))
            for part in range(len(well))
        )
        for b, (key, size) in zip(by, self._deviations.items(), strict=True):
            self._values[key] += float(b) * size
        self.numbers -= by
        self.begin(log)
        for branch, state in zip(self.branches, states, strict=True):
            branch.state = shifted(state, moved)
        return moved

    def follow(self, healthy: Branch) -> None:
        """Take the state of the healthy vehicle's filter, which has jumped."""
        for branch in self.branches:
            branch.state = healthy.state

    def freed(self, whitened: Array, period: float, *, learned: bool = True) -> Array:
        """Return readings (failures, K, M) as they would be without these numbers, and learn them.

        whitened: (failures + S, K, M), those of `branches` last; learned: not where states are still being found.
        """
        keep = np.where(self._wanders, np.exp(-period / rules.WATCH_WANDER), 1.0)
        out = np.empty((len(self.numbers), *whitened.shape[1:]))
        known = (self.numbers, self._P) if learned else (self.numbers.copy(), self._P.copy())
        _freed(whitened, rules.MOST_DEVIATIONS, keep, *known, out)
        return out


@compiled
def _freed(whitened, most, keep, numbers, P, out):  # type: ignore[no-untyped-def]
    """Fill out, see `Dive.freed`; numbers and P are taken along. An outlier teaches little, as it counts little."""
    B, S = numbers.shape
    c, Pc = np.zeros(S), np.zeros(S)
    for k in range(whitened.shape[1]):
        for a in range(S):
            for b in range(S):
                P[a, b] *= keep[a] * keep[b]
            P[a, a] += 1.0 - keep[a] * keep[a]
            for j in range(B):
                numbers[j, a] *= keep[a]
        for i in range(whitened.shape[2]):
            well, spread = whitened[0, k, i], 1.0
            if not np.isfinite(well):
                out[:, k, i] = whitened[:B, k, i]
                continue
            for a in range(S):
                slope = well - whitened[B + a, k, i]
                c[a] = slope if abs(slope) < FARTHEST else 0.0
            for a in range(S):
                Pc[a] = 0.0
                for b in range(S):
                    Pc[a] += P[a, b] * c[b]
                spread += c[a] * Pc[a]
            for j in range(B):
                left = whitened[j, k, i]
                for a in range(S):
                    left -= c[a] * numbers[j, a]
                out[j, k, i] = left / np.sqrt(spread)
            weight = 1.0 / (1.0 + (out[0, k, i] / most) ** 2)
            share = weight / (1.0 + weight * (spread - 1.0))
            for j in range(B):
                left = out[j, k, i] * np.sqrt(spread) * share
                if abs(left) < FARTHEST:
                    for a in range(S):
                        numbers[j, a] += Pc[a] * left
            for a in range(S):
                for b in range(S):
                    P[a, b] -= share * Pc[a] * Pc[b]
