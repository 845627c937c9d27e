"""Stamps that scatter: samples were taken then, or at regular instants while the log stamped them anyhow."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gap_diagnosis.problem import Problem
from gap_diagnosis.recording import Recording
from gap_diagnosis.scatter import Scatter, masks_of, scattered_before_sorting
from gap_diagnosis.suspects import betrayed_by

__all__ = ["jitter_of_stamps", "on_regular_stamps"]

_SORTED = 0.05
"""Share by which the scatter of stamps may be misjudged, since sorting them has mixed them up."""


def on_regular_stamps(problem: Problem, regular: Sequence[Recording]) -> Problem | None:
    """Return the problem on recordings whose scattered stamps are replaced by regular ones; None: none scatter.

    None as well where other readings would be taken together: what is not the same data cannot be compared.
    """
    if all(recording.regular is None for recording in problem.recordings):
        return None
    posed = replace(problem, recordings=tuple(regular), masks=masks_of(regular))
    return posed if posed.known.size == problem.known.size else None


def jitter_of_stamps(given: Problem, gain: float) -> Scatter:
    """Return what it says that regular stamps are better by a gain in evidence, nats."""
    found = []
    for recording in given.recordings:
        for signal, size in recording.log.scatter.items():
            found.append(scattered_before_sorting(size, recording.log.period[signal]))
    size = float(np.sqrt(np.mean(np.square(found))))
    count = sum(m.values.size for r in given.recordings for m in r.experiment.measurements.values())
    return Scatter(
        effect=betrayed_by("stamps"),
        signal="",
        parameter="deviation",
        size=size,
        deviation=float(np.hypot(size / np.sqrt(2.0 * count), _SORTED * size)),
        log_odds=gain,
        sentence=f"stamps scatter by {1000 * size:.1f} ms; regular ones fit better",
    )
