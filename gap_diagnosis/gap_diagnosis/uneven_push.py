r"""Whether what pushes the rotor at random goes with its speed: then a coefficient changes, in a way without a name.

Water and a drive's ripple push a rotor as hard at any speed. A damping that swings by some percent pushes it by that
times the speed, so that its random acceleration deviates by

    \sigma \sqrt{r^2 + n^2/\bar n^2},     \bar n^2 the mean of n^2

in place of \sigma. Both are compared at their likeliest \sigma.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from gap_diagnosis.rules import RULES
from system_identification.fitting import Fitted
from system_identification.noise import Whitener

__all__ = ["evidence_for_uneven_push"]

Array = NDArray[np.float64]
_AT_REST = (1.0, 0.3, 0.1)
"""r, tried."""
_AROUND, _EVALUATIONS = 1.2, 8
"""Logarithm by which the likeliest level may be another than the one learned, and how well it is found."""


def evidence_for_uneven_push(fitted: Fitted, noise: Whitener, loose: Array) -> float:
    """Return the logarithm of evidence that the rotor's random push grows with its speed, against one that does not.

    None, -inf, where it hardly moves the rotor. `loose`: what differs from run to run, (R,), is no push: a coefficient
    that is another in each run pushes in proportion to the speed, too.
    """
    if not noise.linear or "speed" not in fitted.problem.pushed:
        return -np.inf
    shapes = _shapes(fitted, noise)
    rows = fitted.residuals - loose
    even, _ = _likeliest(noise, rows, [np.ones_like(each) for each in shapes])
    uneven, level = max(_likeliest(noise, rows, [np.hypot(r, each) for each in shapes]) for r in _AT_REST)
    return uneven - even - float(np.log(len(_AT_REST))) if level > RULES.noteworthy else -np.inf


def _shapes(fitted: Fitted, noise: Whitener) -> list[Array]:
    """Return |n| over its root mean square at the instants of each linearised run, (N,)."""
    found = []
    for run, recording, happened in zip(
        noise.linear, fitted.problem.recordings, fitted.problem.happened(fitted.x), strict=True
    ):
        n = np.abs(np.nan_to_num(happened.outputs["speed"]))
        at = np.interp(run.dt * np.arange(len(run.push)), recording.experiment.dt * np.arange(n.size), n)
        found.append(at / max(float(np.sqrt(np.mean(at**2))), 1e-9))
    return found


def _likeliest(noise: Whitener, residuals: Array, shapes: Sequence[Array]) -> tuple[float, float]:
    """Return the log likelihood of residuals (R,) with the rotor's push of each run in a shape (N,), and its level."""
    place, rows = noise.system.pushed.index("speed"), np.nan_to_num(residuals)
    linear = []
    for run, shape in zip(noise.linear, shapes, strict=True):
        push = run.push.copy()
        push[:, :, place] *= shape[:, None]
        linear.append(run._replace(push=push))
    shaped = replace(noise, linear=linear)

    def cost(change: float) -> float:
        pushed = shaped.pushing(place, float(np.exp(change)))
        white = pushed.whiten(rows)
        return 0.5 * float(white @ white) + 0.5 * pushed.log_det

    found = minimize_scalar(cost, bounds=(-_AROUND, _AROUND), method="bounded", options={"maxiter": _EVALUATIONS})
    return -float(found.fun), noise.levels.pushes[place] * float(np.exp(found.x))
