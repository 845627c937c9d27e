"""What each candidate explains: which residuals it takes off, by channel, and what strain it takes off parameters."""

import numpy as np

from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.report.wording import signals_of, titles_of
from run_bag.report import Cell, Column, Report
from system_identification.hypothesis import Hypothesis
from thruster_model.identification.experiment import SIGNALS

__all__ = ["add_explained"]

_LISTED = 6


def add_explained(report: Report, found: Diagnosis) -> None:
    """Add what the leading candidates take off the squared, whitened residuals of each channel."""
    looked = found.investigation
    if looked is None or found.problem is None or not looked.best.suspects:
        return
    signals = signals_of(found.problem)
    rows_of = found.problem.signal_rows
    none = looked.none.fitted
    before = {s: float(np.sum(none.white[rows] ** 2)) for s, rows in rows_of.items()}
    counts = {s: int(np.sum(found.problem.known[rows])) for s, rows in rows_of.items()}
    table: list[list[object]] = []
    table.append(["samples", *(float(counts[s]) for s in signals), None])
    table.append(["left by re-tuning alone", *(before[s] for s in signals), _strain(looked.none)])
    for candidate in [each for each in looked.ranked if each.suspects][:_LISTED]:
        white = candidate.fitted.white
        gains = [before[s] - float(np.sum(white[rows_of[s]] ** 2)) for s in signals]
        largest = int(np.argmax(gains))
        gains = [round(gain) + 0.0 for gain in gains]
        cells = [Cell(g, "emphasis") if k == largest and g > 0.0 else g for k, g in enumerate(gains)]
        table.append([titles_of(candidate.keys), *cells, _strain(looked.none) - _strain(candidate)])
    report.table(
        [
            "What",
            *(Column(name=SIGNALS[s].title, format=".0f") for s in signals),
            Column(name="Strain of the parameters", format=".1f"),
        ],
        table,
        caption="What each candidate explains: squared, whitened residuals that it takes off what re-tuning leaves.",
        notes=[
            "Noise alone leaves about one for each sample. Bold: where a candidate explains most. Strain: squares of "
            "the shifts of parameters, clocks and rest values over their stated deviations."
        ],
    )


def _strain(candidate: Hypothesis) -> float:
    nuisances = candidate.fitted.x[: candidate.fitted.problem.nuisances]
    return float(nuisances @ nuisances)
