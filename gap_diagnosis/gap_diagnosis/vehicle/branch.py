"""One filter of a bank that goes through the same pieces of a log side by side."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.filtering import initial_state
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.running import Running, State, followed
from gap_diagnosis.vehicle.unknowns import Key
from rov_sim.vehicle.effects.active import ActiveVehicleEffect
from thruster_model.compilation import compiled

__all__ = ["FARTHEST", "Branch", "Steered", "accumulated", "shifted", "whitened"]

Array = NDArray[np.float64]
FARTHEST = 1e3  # deviations: farther out a filter is lost, not more or less so


class Steered(NamedTuple):
    """What all filters of a bank share in a piece of K instants: the log; gains (K, 16, 13), of the rotors (K, N);
    whitener (K, 13, 13) and spread (K, N) of the innovations; share of a wrench that is kept for 0 to K periods,
    (K + 1,)."""

    log: VehicleLog
    gains: Array
    speed_gains: Array
    whitener: Array
    spread: Array
    keep: Array

    def part(self, first: int, last: int) -> "Steered":
        """Return instants first to before last."""
        at = slice(first, last)
        return Steered(
            self.log.part(first, last), self.gains[at], self.speed_gains[at], self.whitener[at], self.spread[at],
            self.keep[: last - first + 1],
        )  # fmt: skip


class Branch(Running):
    """One filter of the bank."""

    def __init__(
        self, model: Model, values: Mapping[Key, float], effects: Sequence[ActiveVehicleEffect], log: VehicleLog,
        run: int = 0,
    ) -> None:  # fmt: skip
        """Begin as sensors tell of a recording's begin; run: its number."""
        built = model.built(values, effects, run=run, signed=log.signed, initial=initial_state(log))
        super().__init__(built, log.period, followed(log, built))

    def step(self, by: Steered, out: Sequence[Array]) -> bool:
        """Fill out as `innovations` does and return whether the state stayed finite."""
        return self.run(by.log, by.gains, by.speed_gains, by.keep, out)


def shifted(state: State, by: State) -> State:
    """Return the state of a filter moved by so much."""
    return tuple(part + more for part, more in zip(state, by, strict=True))


@compiled
def whitened(body, rotor, whitener, spread):  # type: ignore[no-untyped-def]
    """Return innovations (B, K, 13) and (B, K, N) of a bank whitened, (B, K, 13 + N); NaN: nothing was told.

    One that a filter no longer foresees, since its state is not finite, is as far off as can be.
    """
    B, K, M = body.shape
    out = np.full((B, K, M + rotor.shape[2]), np.nan)
    for j in range(B):
        for k in range(K):
            for i in range(out.shape[2]):
                if i < M:
                    there, r = np.isfinite(body[0, k, i]), 0.0
                    for m in range(M):
                        r += whitener[k, i, m] * body[j, k, m] if np.isfinite(body[0, k, m]) else 0.0
                else:
                    there, r = np.isfinite(rotor[0, k, i - M]), rotor[j, k, i - M] / spread[k, i - M]
                if there:
                    out[j, k, i] = min(max(r, -FARTHEST), FARTHEST) if np.isfinite(r) else FARTHEST
    return out


@compiled
def accumulated(readings, most, doubt, forget, period, begun, ratios, sums, since):  # type: ignore[no-untyped-def]
    """Take whitened readings (B, K, M) of the bank, as all is believed to be first, into the log ratios.

    A reading that is far from what is believed counts less, by 1 / (1 + r^2 / most^2): the most that one can add is
    most^2 / 2, and failures are still told from each other where all of them are far off.
    """
    B, K, M = readings.shape
    for k in range(K):
        now = begun + (k + 1) * period
        for j in range(B - 1):
            gained, fitted, changed = 0.0, 0.0, 0.0
            for i in range(M):
                well, r = readings[0, k, i], readings[j + 1, k, i]
                if np.isfinite(well):
                    weight = 1.0 / (1.0 + (well / most) ** 2)
                    gained += weight * (well * well - r * r - doubt * (well - r) ** 2)
                    fitted += well * (well - r)
                    changed += (well - r) ** 2
            ratios[j] += 0.5 * gained - forget * period
            sums[0, j] += fitted
            sums[1, j] += changed
            if ratios[j] < 0.0:
                ratios[j], sums[0, j], sums[1, j], since[j] = 0.0, 0.0, 0.0, now
