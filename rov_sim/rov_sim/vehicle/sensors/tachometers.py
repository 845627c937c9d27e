"""What unmodelled effects of tachometers make of rotor speeds, one chain for each thruster, before noise is added.

Chains advance in steps of their own, which divide the tachometers' instants and are at most 10 ms: what they tell does
not depend on the other sensors, and a lag is followed between two readings.
"""

from collections.abc import Sequence
from math import gcd
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rov_sim.vehicle.sensors.settings import Sensor
from thruster_model.compilation import compiled
from thruster_model.effects.chains import Outputs, sensor_memory, sensor_seed, speed_sample

__all__ = ["SENSED_BY_TACHOMETERS", "TachometerChains", "chain_step"]

Array = NDArray[np.float64]
SENSED_BY_TACHOMETERS = ("n", "axial", "ambient", "thrust", "torque")
"""Of the truth: rotor speeds [rad/s], axial and ambient flows [m/s], thrusts [N], torques [N m]."""
_LONGEST = 10_000_000  # ns
_STREAM = 2000  # of the seeds, beside the streams of errors


@compiled
def tell(n, v, U, T, Q, memory, step, e, out):  # type: ignore[no-untyped-def]
    """Fill `out` (K, N) with the speeds told over K steps of `step` [s]; the chains' memory (N, ...) goes on."""
    for k in range(out.shape[0]):
        for i in range(out.shape[1]):
            outputs = Outputs(n[k, i], v[k, i], U[k, i], T[k, i], Q[k, i])
            out[k, i] = speed_sample(memory[i], n[k, i], outputs, step, e[i])


def chain_step(tachometer: Sensor) -> int:
    """Return the step of the chains [ns]."""
    common = gcd(tachometer.first, tachometer.period)
    parts = -(-common // _LONGEST)
    while common % parts:
        parts += 1
    return common // parts


class TachometerChains:
    """The chains of all tachometers of a vehicle in one run."""

    def __init__(self, tachometer: Sensor, effects: Sequence[Any], seed: int) -> None:
        """Begin at time 0.

        Args:
            tachometer: settings of all of them.
            effects: `EffectValues` of each thruster.
            seed: of effects that scatter.
        """
        self.step = chain_step(tachometer)
        self._effects, self._seconds = tuple(effects), 1e-9 * self.step
        sizes = [sensor_memory("speed", self._seconds, e) for e in self._effects]
        self._memory = np.zeros((len(sizes), max(sizes, default=0)))
        for i, e in enumerate(self._effects):
            drawn = np.random.SeedSequence(seed, spawn_key=(_STREAM, i)).generate_state(1)[0]
            sensor_seed(self._memory[i], "speed", 1 + int(drawn) % 1_000_000, self._seconds, e)

    def told(self, *given: Any) -> Array:
        """Return what reaches the tachometers' read-out, shape (K, N), over the next K steps.

        given: the truth of `SENSED_BY_TACHOMETERS` at the ends of these steps, shapes (K, N), or (N,) of a single one.
        """
        n, v, U, T, Q = (np.ascontiguousarray(np.atleast_2d(np.asarray(x, dtype=np.float64))) for x in given)
        out = np.empty(n.shape)
        tell(n, v, U, T, Q, self._memory, self._seconds, self._effects, out)
        return out
