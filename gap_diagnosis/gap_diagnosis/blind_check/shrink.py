"""How far the gap really shrank: predictions against the sealed noise-free channels."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from gap_diagnosis.blind_check.generator import NOISE

__all__ = ["Channels", "actual_shrink"]

Channels = Mapping[str, Mapping[str, ArrayLike]]


def actual_shrink(clean: Channels, retuned: Channels, with_effect: Channels) -> float | None:
    """Return 1 - (with_effect^2 - floor^2)/(retuned^2 - floor^2) with errors against the truth, whose floor is zero.

    Args:
        clean: noise-free channels by run and channel (n, ambient, thrust, torque), (N,) each, sample by sample as
            recorded, in rad/s, m/s, N, N m.
        retuned, with_effect: predictions of the same samples by the re-tuned model and by the one with the effect;
            what is not there (runs, channels, samples as NaN) or is of another length is left out.

    Returns:
        The shrink, errors weighted by the sensors' noise; None where nothing is predicted or nothing was to shrink.
    """
    before = after = 0.0
    for run, channels in clean.items():
        for channel, values in channels.items():
            first, second = retuned.get(run, {}).get(channel), with_effect.get(run, {}).get(channel)
            if first is None or second is None:
                continue
            truth = np.asarray(values, dtype=np.float64)
            if len(np.atleast_1d(first)) != truth.size or len(np.atleast_1d(second)) != truth.size:
                continue
            errors = [(_array(p) - truth) / NOISE[channel] for p in (first, second)]
            both = np.isfinite(errors[0]) & np.isfinite(errors[1])
            before += float(np.sum(errors[0][both] ** 2))
            after += float(np.sum(errors[1][both] ** 2))
    return 1.0 - after / before if before > 0.0 else None


def _array(values: ArrayLike) -> np.ndarray:
    return np.array([np.nan if v is None else v for v in np.asarray(values, dtype=object)], dtype=np.float64)
