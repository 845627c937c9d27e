"""Stamps that scatter: whether the samples were taken then, or at regular instants while the log stamped them anyhow.

Both are fitted. Where the model is wrong by much, as that of a sluggish tachometer is without its lag, the better one
is better by chance: the question is asked again of the hypothesis that explains the recordings.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gap_diagnosis.problem import CONVENTION, Problem
from gap_diagnosis.recording import Recording
from gap_diagnosis.rules import LOG_RULES
from gap_diagnosis.scatter import Scatter, masks_of, scattered_before_sorting
from gap_diagnosis.suspects import betrayed_by
from system_identification.fitting import Fitted, fit
from system_identification.noise import white_noise

__all__ = ["gain_of_regular", "jitter_of_stamps", "on_regular_stamps", "regular_fit_better"]

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


def _with_clocks(problem: Problem) -> Problem:
    """Return the problem with a clock of its own for each signal of each recording, as runs may have."""
    found = []
    for recording in problem.recordings:
        measured = {
            name: replace(m, shift_std=float(np.hypot(m.shift_std, CONVENTION)))
            for name, m in recording.experiment.measurements.items()
        }
        found.append(replace(recording, experiment=replace(recording.experiment, measurements=measured)))
    return replace(problem, recordings=tuple(found))


def gain_of_regular(given: Problem, regular: Problem, like: Fitted | None = None) -> float:
    """Return by how much, in cost, regular stamps fit better than those given, clocks as free on either side.

    Args:
        given: the problem on the stamps in the log.
        regular: the same on regular ones.
        like: the hypothesis that is fitted to both; None: re-tuned parameters alone.
    """
    costs = []
    for problem in map(_with_clocks, (given, regular)):
        posed = problem if like is None else problem.with_effects(like.problem.slots, like.problem.gates)
        start = posed.start()
        if like is not None:  # it has not these clocks
            start[: len(posed.names)] = like.x[: len(posed.names)]
            start[posed.nuisances :] = like.x[like.problem.nuisances :]
        costs.append(fit(posed, white_noise(given), start, iterations=20).cost)
    return costs[0] - costs[1]


def regular_fit_better(gain: float) -> bool:
    """Tell whether a gain in cost is enough to believe that the log's stamps scatter."""
    return gain >= 2.0 * LOG_RULES.jitter


def jitter_of_stamps(given: Problem, gain: float) -> Scatter:
    """Return what it says that regular stamps fit better by a gain in cost."""
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
        log_odds=0.5 * gain,
        sentence=f"stamps scatter by {1000 * size:.1f} ms; regular ones fit better",
    )
