"""Which samples of an acoustic Doppler velocimeter can be used, from the recording alone.

Spikes are found by phase-space thresholding (Goring and Nikora 2002, doi:10.1061/(ASCE)0733-9429(2002)128:1(117))
as implemented by proadv, on the signal less its running median. What then still scatters too much over a second, or
consists mostly of spikes, is an unusable stretch; a channel of which too little is left is unusable as a whole.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter, uniform_filter1d

__all__ = ["FlowLimits", "FlowQuality", "assess_flow"]

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True)
class FlowLimits:
    """What counts as unusable.

    Attributes:
        velocity: largest credible |velocity| [m/s]; a Vectrino set to 0.30 m/s wraps beyond it.
        window: length over which scatter and the share of spikes are judged [s].
        scatter: largest robust standard deviation within a window [m/s].
        spike_share: largest share of spikes within a window.
        least_share: a channel with a smaller usable share is dropped as a whole.
    """

    velocity: float = 0.30
    window: float = 1.0
    scatter: float = 0.05
    spike_share: float = 0.35
    least_share: float = 0.5


@dataclass(frozen=True, kw_only=True)
class FlowQuality:
    """Masks over the samples, shape (M,), and what they amount to in a sentence."""

    usable: Mask
    spikes: Mask
    sentence: str


def assess_flow(velocity: Array, rate: float, limits: FlowLimits | None = None) -> FlowQuality:
    """Judge a velocity channel [m/s], shape (M,), sampled at `rate` [Hz]."""
    limits = limits or FlowLimits()
    half = max(2, round(limits.window * rate / 2))
    incredible = ~np.isfinite(velocity) | (np.abs(velocity) > limits.velocity)
    spikes = incredible | _phase_space_spikes(_filled(velocity, incredible), half)
    rest = _filled(velocity, spikes)
    deviation = np.abs(rest - median_filter(rest, 2 * half + 1, mode="nearest"))
    scatter = median_filter(deviation, 2 * half + 1, mode="nearest") / 0.6744897501960817
    share = uniform_filter1d(spikes.astype(np.float64), 2 * half + 1, mode="nearest")
    unusable = (scatter > limits.scatter) | (share > limits.spike_share)
    usable = ~(unusable | spikes)
    percent = 100.0 * usable.mean()
    sentence = (
        f"{100 * spikes.mean():.0f} % of the samples are spikes, {100 * unusable.mean():.0f} % lie in unusable "
        f"stretches, {percent:.0f} % remain"
    )
    if percent < 100.0 * limits.least_share:
        usable = np.zeros_like(usable)
        sentence += f": fewer than {100 * limits.least_share:.0f} %, so the channel is left out"
    return FlowQuality(usable=usable, spikes=spikes, sentence=sentence)


def _filled(values: Array, gaps: Mask) -> Array:
    """Replace gaps by straight lines between their neighbours; zeros where nothing is left."""
    kept = np.flatnonzero(~gaps)
    if kept.size == 0:
        return np.zeros_like(values)
    return np.interp(np.arange(values.size), kept, values[kept])


def _phase_space_spikes(velocity: Array, half: int, *, passes: int = 10) -> Mask:
    """Repeat the thresholding, spikes replaced by straight lines in between, until it finds nothing new."""
    from proadv.filtration.detection.phasespace import phasespace_thresholding  # 1.6 s to import

    found = np.zeros(velocity.shape, dtype=bool)
    for _ in range(passes):
        current = _filled(velocity, found)
        fluctuation = current - median_filter(current, 4 * half + 1, mode="nearest")
        if not np.any(fluctuation):
            break
        # In mm/s: proadv rounds derivatives to four decimals.
        fresh = np.asarray(phasespace_thresholding(1e3 * fluctuation), dtype=np.int64)
        if not np.any(~found[fresh]):
            break
        found[fresh] = True
    return found
