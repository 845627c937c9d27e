"""The attitude fit's report: how much is explained, measured rates against free runs, unknowns, what is missing."""

from collections.abc import Mapping

import numpy as np

from run_bag.report import Axis, Column, Panel, Report, Series, time_series
from thruster_model.attitude_fit.model import AXES, simulate
from thruster_model.attitude_fit.study import Study
from thruster_model.attitude_fit.tables import MISSING, heads, matrix_rows, share_rows, unknown_rows

__all__ = ["build_report"]

_SYMBOLS = ("p", "q", "r")


def build_report(study: Study, provenance: Mapping[str, object]) -> Report:
    """Return the report of a study."""
    count = len(study.recordings)
    report = Report("Attitude rates", f"{count} recording{'s' if count != 1 else ''}", provenance)
    report.paragraph(_answer(study))
    report.section("How much is explained")
    note = (
        "1 minus the squared error over the squared spread about the recording's own mean; 90 % intervals in brackets"
    )
    rows: list[list[object]] = [list(row) for row in share_rows(study)]
    stars = ["Negative: worse than that mean. * no moment was commanded about this axis."]
    report.table(heads(study), rows, caption=f"Share of the variance: {note}.", notes=stars)
    for axis, name in enumerate(AXES):
        found = matrix_rows(study, axis)
        if len(found) > 1:
            columns: list[Column | str] = ["fitted to", *(f"predicts {row[0]}" for row in found)]
            told = f"{name.capitalize()}: fitted to one recording alone, share of each explained in a free run."
            report.table(columns, [list(row) for row in found], caption=told)
    report.section("Free runs from the first sample")
    for k, each in enumerate(study.recordings):
        report.subsection(each.name)
        given = (each.rates, each.gravity, each.moments, each.dt)
        made = {"fitted to all": simulate(*given, study.together.values)}
        if study.held:
            made["this one left out"] = simulate(*given, study.held[k].values)
        panels = [
            Panel(
                axis=Axis(name=f"{name.capitalize()} rate", unit="rad/s", symbol=_SYMBOLS[axis]),
                series=[
                    Series(name="measured", x=each.time, y=each.rates[:, axis], role="data"),
                    *(Series(name=label, x=each.time, y=run[:, axis]) for label, run in made.items()),
                ],
            )
            for axis, name in enumerate(AXES)
        ]
        report.figure(
            time_series(panels),
            caption="Measured rates, and rates simulated from the first sample with the commands alone.",
            alt=f"Roll, pitch and yaw rates of {each.name} over time, measured and simulated.",
        )
    report.section("Unknowns")
    titles: list[Column | str] = ["unknown", "value", "standard deviation", "unit"]
    told = "Fit to all recordings, everything over the axis' inertia; inertia over roll's."
    report.table(titles, [list(row) for row in unknown_rows(study)], caption=told)
    report.section("What is missing")
    report.paragraph("\n\n".join(MISSING))
    return report


def _answer(study: Study) -> str:
    if not study.held:
        return "One recording: fitted and not predicted. Only recordings left out say what the model is worth."
    pushed = np.array([each.pushed for each in study.recordings])
    value = np.array([share.value for share in study.predicted])
    told = []
    for axis, name in enumerate(AXES):
        found = value[pushed[:, axis], axis]
        if found.size:
            span = f"{100 * found.min():.0f} to {100 * found.max():.0f} %"
            told.append(f"{name}: {span}, median {100 * np.median(found):.0f} %")
    return f"Of a recording that the fit has not seen, free runs explain this share of the variance: {'; '.join(told)}."
