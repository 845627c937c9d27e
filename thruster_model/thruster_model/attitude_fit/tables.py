"""The study's tables as rows of text, for the report and for Markdown."""

import numpy as np

from thruster_model.attitude_fit.model import AXES, DEFINITIONS
from thruster_model.attitude_fit.scores import Share
from thruster_model.attitude_fit.study import Study

__all__ = ["MISSING", "markdown", "matrix_rows", "share_rows", "unknown_rows"]

MISSING = (
    "No linear velocity was measured: moments by drag and added mass of a vehicle that moves through the water, and "
    "thrust lost in that flow, are missing from the model.",
    "Rates and attitude are the vehicle's own filter's, not a reference. An angle that wraps does no harm: attitude "
    "enters as the direction of gravity.",
    "One constant bias per axis stands for trim, ballast and what a tether pulls. It is the same in all recordings "
    "of a fit, though ballast may have changed between days.",
    "Thrust comes from a static table at one supply voltage: the battery's was not recorded.",
)
"""What the model and the recordings leave out."""
_PUSHED = "*"


def _share(share: Share, axis: int, *, interval: bool = True) -> str:
    value = f"{100.0 * share.value[axis]:.0f} %"
    return f"{value} ({100.0 * share.low[axis]:.0f} to {100.0 * share.high[axis]:.0f})" if interval else value


def share_rows(study: Study) -> list[list[str]]:
    """Return rows of recording, axis, spread of the rate, and shares: fitted, left out, left out in pieces.

    Axes about which no moment was commanded are left out of the table unless the vehicle turned about them by more
    than 0.3 rad/s.
    """
    rows = []
    for k, each in enumerate(study.recordings):
        for axis, name in enumerate(AXES):
            fitted = _share(study.fitted[k], axis) if k < len(study.fitted) else "–"
            spread, pushed = float(np.std(each.rates[:, axis])), each.pushed[axis]
            if not pushed and spread < 0.3:
                continue
            row = [each.name, name + ("" if pushed else f" {_PUSHED}"), f"{spread:.2f}", fitted]
            held = [study.predicted, study.predicted_pieces] if study.held else []
            rows.append([*row, *(_share(found[k], axis) for found in held)])
    return rows


def matrix_rows(study: Study, axis: int) -> list[list[str]]:
    """Return what the fit to one recording alone (row) explains of each (column) about one axis.

    Recordings in which no moment was commanded about that axis are left out.
    """
    used = [k for k in range(len(study.matrix)) if study.recordings[k].pushed[axis]]
    return [[study.recordings[i].name, *(_share(study.matrix[i][j], axis, interval=False) for j in used)] for i in used]


def unknown_rows(study: Study) -> list[list[str]]:
    """Return rows of unknown, value, standard deviation and unit of the fit to all."""
    fit = study.together
    return [
        [d.name, f"{value:.3g}", "not determined" if np.isnan(deviation) else f"{deviation:.2g}", d.unit]
        for d, value, deviation in zip(DEFINITIONS, fit.values, fit.deviations, strict=True)
    ]


def heads(study: Study) -> list[str]:
    """Return the headings of `share_rows`."""
    piece = f"left out, begun anew every {study.options.piece:g} s"
    held = ["left out, free run", piece] if study.held else []
    return ["recording", "axis", "spread [rad/s]", "fitted to all, free run", *held]


def markdown(study: Study) -> str:
    """Return all tables as Markdown."""
    parts = ["## Share of the variance explained\n", *_table(heads(study), share_rows(study))]
    parts += [f"\n{_PUSHED} no moment was commanded about this axis.\n"]
    for axis, name in enumerate(AXES):
        rows = matrix_rows(study, axis)
        if len(rows) > 1:
            parts += [f"\n## {name.capitalize()}: fitted to one recording alone, free run of each\n"]
            parts += _table(["fitted to", *(f"predicts {row[0]}" for row in rows)], rows)
    parts += ["\n## Unknowns of the fit to all\n"]
    parts += _table(["unknown", "value", "standard deviation", "unit"], unknown_rows(study))
    return "\n".join(parts) + "\n"


def _table(titles: list[str], rows: list[list[str]]) -> list[str]:
    return [f"| {' | '.join(cells)} |" for cells in (titles, ["---"] * len(titles), *rows)]
