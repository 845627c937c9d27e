"""Fewer samples for display, with every extreme kept (min–max decimation)."""

import numpy as np
import numpy.typing as npt


def keep_extremes(*values: npt.ArrayLike, max_points: int) -> npt.NDArray[np.intp]:
    """Choose the samples to draw so that no peak and no gap is lost.

    The samples are cut into equal buckets; each keeps the smallest and the largest finite sample of every
    channel and its first NaN, so that a gap stays a gap. First and last sample are always kept.

    Args:
        values: one or more channels of one length (n,); what is kept serves all of them.
        max_points: at most about this many samples remain (two per bucket and channel; NaNs come on top).

    Returns:
        rising indices (k,) into the samples; all of them when n <= max_points.
    """
    channels = [np.asarray(v, dtype=np.float64) for v in values]
    n = channels[0].shape[0]
    if n <= max_points:
        return np.arange(n, dtype=np.intp)
    width = int(np.ceil(n / max(1, max_points // (2 * len(channels)))))
    buckets = int(np.ceil(n / width))
    start = np.arange(buckets, dtype=np.intp) * width
    kept = [np.array([0, n - 1], dtype=np.intp)]
    for channel in channels:
        padded = np.full(buckets * width, np.inf)
        padded[:n] = channel
        table = padded.reshape(buckets, width)
        missing = ~np.isfinite(table)
        kept.append(start + np.argmin(np.where(missing, np.inf, table), axis=1))
        kept.append(start + np.argmax(np.where(missing, -np.inf, table), axis=1))
        gap = missing & (np.arange(buckets * width).reshape(buckets, width) < n)
        first = np.argmax(gap, axis=1)
        kept.append((start + first)[gap.any(axis=1)])
    indices = np.unique(np.concatenate(kept))
    return indices[indices < n]


def compact(values: npt.ArrayLike) -> npt.NDArray[np.floating]:
    """Return the values in single precision where nobody could see the difference, else in double precision.

    Single precision is taken when its rounding stays below 1e-5 of the values' range; infinities become NaN
    (a gap).
    """
    wide = np.array(values, dtype=np.float64)
    wide[~np.isfinite(wide)] = np.nan
    with np.errstate(over="ignore", invalid="ignore"):
        narrow = wide.astype(np.float32)
        finite = np.isfinite(wide)
        if not finite.any():
            return narrow
        rounding = np.max(np.abs(narrow[finite] - wide[finite]))
        spread = np.ptp(wide[finite])
    return narrow if rounding <= 1e-5 * spread or rounding == 0.0 else wide
