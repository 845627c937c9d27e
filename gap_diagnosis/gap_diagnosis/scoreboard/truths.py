r"""What can be known about a case: how far off its effects are to see, and what share of the gap each makes.

Distance of an effect (Fisher): with d what it moves in all readings, in units of their noise,

    D^2 = d^T V^-1 d,   V = I + J J^T + P P^T

where the columns of J are the readings' responses to parameters, one stated deviation (5 %) each, and P P^T is the
covariance of what random pushes of rotor and water do, from `_PUSHES` draws. D is what is left of d after re-tuning.

Share of a cause: Shapley value of "squared gap removed" for the traces t_i of the causes alone (all parameters are one
cause), to which their interactions (full gap less sum of traces) are given in equal parts: <t_i, g> / |g|^2.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.scoreboard.case import Generator, Truth

__all__ = ["PARAMETERS", "SCATTERS", "distances", "shares"]

Array = NDArray[np.float64]
PARAMETERS = "parameters"
"""Name of all parameters together as one cause."""
SCATTERS = ("timestamp_jitter", "dropped_samples", "flow_spikes")
"""Effects that move no reading in the mean: no distance is stated for them."""
_PUSHES = 24
_DEVIATION, _STEP = 0.05, 0.01


def distances(generator: Generator, truth: Truth) -> dict[str, float]:
    """Return the distance of every effect of a case, known or not, that moves the readings of `clean`."""
    hidden = {**truth.effects, **truth.outside}
    if not hidden:
        return {}

    def clean(effects: dict, outside: dict, factors: Mapping[str, float], push: int | None = None) -> Array:  # type: ignore[type-arg]
        return generator.clean(truth, effects, outside, factors, push)

    effects, outside, factors = dict(truth.effects), dict(truth.outside), dict(truth.factors)
    here = clean(effects, outside, factors)
    columns = []
    for name, factor in factors.items():
        moved = clean(effects, outside, {**factors, name: factor * (1.0 + _STEP)}) - here
        if np.any(moved):
            columns.append(moved * (_DEVIATION / _STEP))
    for seed in range(_PUSHES):
        pushed = clean(effects, outside, factors, 10_000 + seed) - here
        if np.any(pushed):
            columns.append(pushed / np.sqrt(_PUSHES))
    loose = np.array(columns).T
    core = np.linalg.inv(np.eye(loose.shape[1]) + loose.T @ loose)
    found = {}
    for name in hidden:
        if name in SCATTERS:
            continue
        rest, others = ({k: s for k, s in table.items() if k != name} for table in (effects, outside))
        d = here - clean(rest, others, factors)
        if not np.any(d):  # an effect of the log, or another class of model, which `clean` does not know
            continue
        along = loose.T @ d
        found[name] = float(np.sqrt(np.maximum(d @ d - along @ core @ along, 0.0)))
    return found


def shares(generator: Generator, truth: Truth) -> dict[str, float]:
    """Return the share of the gap that parameters and every effect make; empty where there is no gap."""
    plain: dict[str, float] = {}
    stated = generator.clean(truth, {}, {}, plain, None)
    gap = generator.clean(truth, truth.effects, truth.outside, truth.factors, None) - stated
    size = float(gap @ gap)
    if size == 0.0:
        return {}
    traces = {PARAMETERS: generator.clean(truth, {}, {}, truth.factors, None) - stated}
    for name, sizes in truth.effects.items():
        traces[name] = generator.clean(truth, {name: sizes}, {}, plain, None) - stated
    for name, sizes in truth.outside.items():
        traces[name] = generator.clean(truth, {}, {name: sizes}, plain, None) - stated
    together = (gap - np.sum(list(traces.values()), axis=0)) / len(traces)
    return {name: float((trace + together) @ gap) / size for name, trace in traces.items()}
