"""Re-tuned parameters: how far each was moved, in its stated deviations."""

import re
from collections.abc import Mapping
from typing import Any

from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.problem import DEFAULT_DEVIATION
from gap_diagnosis.report.wording import number, titles_of, unit
from run_bag.report import Axis, Bars, Cell, Column, Report, bars, theme

__all__ = ["add_parameters"]

_FLAGGED = 2.0
_EQUATIONS = re.compile(r",? *\(\d+\.\d+\)")


def add_parameters(report: Report, found: Diagnosis, content: Mapping[str, Any]) -> None:
    """Add the parameters of the chosen hypothesis, those of the fit without effect where none is chosen."""
    problem, retuned = found.problem, content["retuned_parameters"]
    if problem is None or not retuned:
        return
    report.section("Re-tuned parameters")
    parameters = found.parameter_set.parameters
    assumed = [name for name in retuned if parameters[name].standard_deviation is None]
    chosen = found.verdict.chosen
    text = f"Values with {titles_of(chosen.keys)} beside them." if chosen else "Values without any effect."
    text += " A shift beyond two stated deviations says that the set or its deviations are wrong."
    if assumed:
        which = "any parameter" if len(assumed) == len(retuned) else ", ".join(assumed)
        text += f" The set states no deviation for {which}: {100 * DEFAULT_DEVIATION:.0f} % of the value are assumed."
    report.paragraph(text)
    shifts = {n: round((v["value"] - v["nominal"]) / problem.deviations[n], 6) + 0.0 for n, v in retuned.items()}
    spreads = {n: v["std"] / problem.deviations[n] for n, v in retuned.items()}
    rows: list[list[object]] = []
    for name, values in retuned.items():
        shift = shifts[name]
        rows.append(
            [
                name,
                number(values["nominal"]),
                number(problem.deviations[name], 2),
                number(values["value"]),
                number(values["std"], 2),
                Cell(shift, "worse") if abs(shift) > _FLAGGED else round(shift, 2) + 0.0,
                unit(parameters[name].unit),
                _EQUATIONS.sub("", found.parameter_set.model.definition(name).meaning),
            ]
        )
    right = ("Nominal", "± stated", "Re-tuned", "± here")
    report.table(
        [
            "Parameter",
            *(Column(name=name, align="right") for name in right),
            Column(name="Shift", unit="stated ±", format="+.2f"),
            "Unit",
            "Meaning",
        ],
        rows,
        caption="Parameters as stated and re-tuned; ±: standard deviations.",
        notes=[
            f"▲: shifted by more than {_FLAGGED:g} stated deviations. Where ± here is as large as ± stated, these "
            "recordings say nothing about the parameter."
        ],
    )
    order = sorted(shifts, key=lambda name: -abs(shifts[name]))
    plot = bars(
        order,
        [
            Bars(
                name="shift",
                value=[shifts[n] for n in order],
                low=[shifts[n] - spreads[n] for n in order],
                high=[shifts[n] + spreads[n] for n in order],
            )
        ],
        quantity=Axis(name="shift in stated deviations", unit="–"),
        reference=0.0,
    )
    for limit in (-_FLAGGED, _FLAGGED):
        plot.figure.add_vline(limit, line={"color": theme.REFERENCE, "width": 1.2, "dash": "4px,3px"})
    report.figure(
        plot,
        caption="Shift of each parameter over its stated deviation, with one standard deviation of the estimate; "
        f"dashed: {_FLAGGED:g} stated deviations.",
        alt="; ".join(f"{name} {shifts[name]:+.1f}" for name in order),
    )
