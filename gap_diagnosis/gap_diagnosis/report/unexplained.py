"""What stays unexplained: what residuals still depend on after the chosen hypothesis."""

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.lines import A_LINE
from gap_diagnosis.report.wording import COLOURS, RETUNED, WITH_EFFECT, titles_of
from run_bag.report import TIME, Axis, Column, Plot, Report, Series, curves
from system_identification.fitting import Fitted
from system_identification.hypothesis import Hypothesis
from thruster_model.identification.experiment import SIGNALS

__all__ = ["add_unexplained"]

Array = NDArray[np.float64]
_AXES = {
    "time": TIME,
    "U": Axis(name="simulated ambient flow", unit="m/s", symbol="U"),
    "v": Axis(name="simulated axial flow", unit="m/s", symbol="v"),
    "T": Axis(name="simulated thrust", unit="N", symbol="T"),
    "u": Axis(name="throttle", unit="V", symbol="u"),
    "n": Axis(name="simulated rotor speed", unit="rad/s", symbol="n"),
}
_OUTPUTS = {"U": "ambient", "v": "axial", "T": "thrust", "n": "speed"}
_COLOURS = (COLOURS[RETUNED], COLOURS[WITH_EFFECT])
_BINS = 24
_DRAWN = 2


def add_unexplained(report: Report, found: Diagnosis, content: Mapping[str, Any]) -> None:
    """Add the features that residuals depend on, and the residuals against the strongest ones."""
    report.section("What stays unexplained")
    features = content["unexplained"]
    candidate = found.investigation.best if found.investigation else None
    what = titles_of(candidate.keys) if candidate and candidate.keys else "re-tuning alone"
    if not features:
        report.paragraph(
            f"Nothing: after {what} the residuals depend on none of some four hundred functions of states, inputs, "
            "their past and time beyond what a search among so many finds by chance, and have no line in their spectra."
        )
        return
    total = sum(each["gain"] for each in features)
    report.paragraph(
        f"After {what} residuals still depend on states or inputs. Functions were chosen one after the other out of "
        "some four hundred, parameters re-tuned beside each, and lines of the residuals' spectra beside them; a gain "
        "well above 10 is hardly chance. What they name is a description of the structure, not its cause."
    )
    report.table(
        ["Residual of", "Depends on", Column(name="Squared residuals taken off", format=".1f")],
        [
            [SIGNALS[f["signal"]].title if f["signal"] in SIGNALS else f["signal"], f["depends_on"], f["gain"]]
            for f in features
        ],
        caption=f"Structure in the residuals, {total:.0f} in all; noise alone leaves about one for each sample.",
    )
    _pictures(report, found.investigation.none if found.investigation else None, candidate, features)


def _pictures(
    report: Report, none: Hypothesis | None, candidate: Hypothesis | None, features: list[Mapping[str, Any]]
) -> None:
    if candidate is None or none is None:
        return
    shown = (
        {RETUNED: none} if not candidate.suspects else {RETUNED: none, "with " + titles_of(candidate.keys): candidate}
    )
    measured = {each.signal for each in none.fitted.problem.series}  # a push on a rotor may show in the thrust alone
    drawn = [f for f in features if f["signal"] in measured and not f["depends_on"].startswith(A_LINE)]
    pairs = [(f["signal"], _variable(f["depends_on"])) for f in drawn]
    plots = [_plot(shown, *pair) for pair in list(dict.fromkeys(pairs))[:_DRAWN]]
    if plots:
        report.figure(
            plots,
            caption="Residuals against the quantities that they depend on most: means over bins of equally many "
            "samples, with two standard errors.",
            alt="Binned residuals against simulated states.",
        )


def _variable(name: str) -> str:
    """Return the quantity that a feature is foremost a function of."""
    if re.search(r"time|from \d", name):
        return "time"
    letters = re.findall(r"(?<![A-Za-z])[nuUvT](?![A-Za-z])", name)
    return next((letter for letter in "UvTun" if letter in letters), "n")


def _plot(shown: Mapping[str, Hypothesis], signal: str, variable: str) -> Plot:
    series = []
    for number, (name, candidate) in enumerate(shown.items()):
        at, means, errors = _binned(*_residuals(candidate.fitted, signal, variable))
        low, high = means - 2.0 * errors, means + 2.0 * errors
        series.append(Series(name=name, x=at, y=means, low=low, high=high, points=True, color=_COLOURS[number]))
    residual = Axis(name=f"residual of {SIGNALS[signal].title.lower()}", unit=SIGNALS[signal].unit)
    return curves(series, x=_AXES[variable], y=residual)


def _residuals(fitted: Fitted, signal: str, variable: str) -> tuple[Array, Array]:
    """Return a quantity and the residuals of a signal at the same instants."""
    problem = fitted.problem
    x, y = [], []
    for index, happened in enumerate(problem.happened(fitted.x)):
        grid = problem.recordings[index].experiment.dt * np.arange(happened.throttle.size)
        for each in problem.series:
            if each.recording == index and each.signal == signal:
                time = problem.recordings[index].experiment.measurements[signal].time
                known = problem.known[each.rows]
                values = (
                    happened.throttle if variable == "u" else happened.outputs.get(_OUTPUTS.get(variable, ""), grid)
                )
                x.append(np.interp(time[known], grid, values))
                y.append(fitted.residuals[each.rows][known])
    return np.concatenate(x), np.concatenate(y)


def _binned(x: Array, y: Array) -> tuple[Array, Array, Array]:
    order = np.argsort(x, kind="stable")
    parts = [p for p in np.array_split(order, _BINS) if p.size]
    at = np.array([np.mean(x[p]) for p in parts])
    means = np.array([np.mean(y[p]) for p in parts])
    errors = np.array([np.std(y[p]) / np.sqrt(p.size) for p in parts])
    return at, means, errors
