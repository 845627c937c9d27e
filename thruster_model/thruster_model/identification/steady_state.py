"""Steady states: what recordings show once the throttle has been constant for a while, and what models predict."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from thruster_model.equations.thruster import ThrusterCoefficients
from thruster_model.flow_tank import AT_REST, simulate
from thruster_model.identification.experiment import Experiment

__all__ = ["SteadyState", "predicted_steady_states", "steady_states"]

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class SteadyState:
    """Means of one plateau of the throttle: level [V], and (mean, standard error) of each signal."""

    experiment: str
    throttle: float
    signals: Mapping[str, tuple[float, float]]


def steady_states(
    experiments: Sequence[Experiment], *, settle: float = 2.0, least: float = 1.0, blocks: int = 5
) -> list[SteadyState]:
    """Return the plateaus that last `settle` + `least` [s] or longer, each averaged after `settle`.

    Standard errors come from the means of `blocks` equal parts, as neighbouring cells are correlated.
    """
    found = []
    for experiment in experiments:
        edges = np.flatnonzero(np.diff(experiment.throttle) != 0.0) + 1
        bounds = np.concatenate(([0], edges, [experiment.throttle.size]))
        for first, last in pairwise(bounds):
            start, end = first * experiment.dt + settle, last * experiment.dt
            if end - start < least or experiment.throttle[first] == 0.0:
                continue
            signals = {}
            for name, m in experiment.measurements.items():
                part = m.values[(m.time > start) & (m.time < end)]
                means = [float(np.nanmean(p)) for p in np.array_split(part, blocks) if np.any(np.isfinite(p))]
                if len(means) >= 2:
                    error = float(np.std(means, ddof=1) / np.sqrt(len(means)))
                    signals[name] = (float(np.nanmean(part)), error)
            level = float(experiment.throttle[first])
            found.append(SteadyState(experiment=experiment.name, throttle=level, signals=signals))
    return found


def predicted_steady_states(coefficients: ThrusterCoefficients, throttles: Array) -> dict[str, Array]:
    """Return n [rad/s], v, U [m/s], T [N], Q [N m] after 40 s at each throttle [V], each of shape (K,)."""
    fields = {"speed": "n", "axial": "v", "ambient": "ambient", "thrust": "thrust", "torque": "torque"}
    states = [simulate(coefficients, np.full(400, u), 0.1, initial=AT_REST, largest_step=0.002) for u in throttles]
    return {name: np.array([getattr(s, field)[-1] for s in states]) for name, field in fields.items()}
