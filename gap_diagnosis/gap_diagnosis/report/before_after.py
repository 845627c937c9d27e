"""Before and after: the most telling runs over time, measured against simulated, with residuals."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.problem import Problem
from gap_diagnosis.report.telling import Telling, run_error, telling_runs
from gap_diagnosis.report.wording import AS_STATED, COLOURS, KINDS, RETUNED, WITH_EFFECT, axis_of
from run_bag.report import Axis, Column, Panel, Plot, Report, Series, Span, time_series
from system_identification.noise import Whitener

__all__ = ["add_before_and_after"]

Array = NDArray[np.float64]
_RUNS = 2
_PANEL = 118  # pixels
_POINTS = 520  # about one for each pixel
_WIDTH = 1.2  # of lines over a whole run [pixels]
_BEYOND = 3.0  # ranges of the measured values beyond which a simulated one is not drawn


def add_before_and_after(report: Report, found: Diagnosis) -> None:
    """Add the runs as a table and the most telling ones as pictures."""
    if found.problem is None or found.investigation is None or "retuned" not in found.predictions:
        return
    problem, noise = found.problem, found.investigation.noise
    predictions = {KINDS[k]: found.predictions[k] for k in KINDS if k in found.predictions}
    if WITH_EFFECT in predictions:
        what = "the effect takes off most squared error"
        runs = telling_runs(problem, noise, predictions[RETUNED], predictions[WITH_EFFECT])
    elif found.verdict.verdict in ("unknown", "cannot_tell"):
        what = "re-tuning leaves most squared error"
        runs = telling_runs(problem, noise, predictions[RETUNED], None)
    else:
        what = "re-tuning takes off most squared error"
        runs = telling_runs(problem, noise, predictions[AS_STATED], predictions[RETUNED])
    if not runs:
        return
    report.section("Before and after")
    _table(report, problem, noise, predictions, runs, what)
    for run in runs[:_RUNS]:
        report.subsection(problem.recordings[run.recording].name)
        _figure(report, problem, noise, predictions, run, what)


def _table(
    report: Report, problem: Problem, noise: Whitener, predictions: Mapping[str, Array], runs: list[Telling],
    what: str,
) -> None:  # fmt: skip
    rows: list[list[object]] = []
    for k, run in enumerate(runs):
        recording = problem.recordings[run.recording]
        errors = [run_error(problem, noise, predicted, run.recording) for predicted in predictions.values()]
        row: list[object] = [recording.name, recording.experiment.duration, *errors]
        rows.append([*row, f"{run.start:.1f} to {run.stop:.1f}", "below" if k < _RUNS else "not drawn"])
    report.table(
        [
            "Run",
            Column(name="Length", unit="s", format=".1f"),
            *(Column(name=name.capitalize(), format=".2f") for name in predictions),
            Column(name="Shows most at [s]", align="right"),
            "Picture",
        ],
        rows,
        caption="Errors of each run over the noise of its channels (1: noise alone), the most telling run first.",
        notes=[
            f"Shows most: where {what}. Held out, except as stated: there clocks, rest values and states at the start "
            "alone are fitted."
        ],
    )


def _figure(
    report: Report, problem: Problem, noise: Whitener, predictions: Mapping[str, Array], run: Telling, what: str
) -> None:
    name = problem.recordings[run.recording].name
    duration = problem.recordings[run.recording].experiment.duration
    zoom = (run.start, run.stop)
    stretch = f"{run.start:g} to {run.stop:g} s"
    if run.stop - run.start < 0.8 * duration:
        spans = [Span(*zoom, f"{stretch}, drawn beside")]
        plots = [
            _drawn(problem, noise, predictions, run.recording, (0.0, duration), spans),
            _drawn(problem, noise, predictions, run.recording, zoom, (), points=True),
        ]
        seen = f"whole run (left) and {stretch} (right), where {what}"
    else:
        plots = [_drawn(problem, noise, predictions, run.recording, (0.0, duration), ())]
        seen = "whole run"
    report.figure(
        plots,
        caption=f"{name}: {seen}. Below each channel its residuals (measured less simulated) with two standard "
        "deviations of its noise.",
        alt=f"Throttle, then each channel measured and simulated, and its residuals, over time of the run {name}.",
    )


def _drawn(
    problem: Problem,
    noise: Whitener,
    predictions: Mapping[str, Array],
    index: int,
    window: tuple[float, float],
    spans: Sequence[Span],
    *,
    points: bool = False,
) -> Plot:
    panels = [_throttle(problem, index, window)]
    last_two = list(predictions)[-2:]
    for each in problem.series:
        if each.recording != index:
            continue
        time = problem.recordings[index].experiment.measurements[each.signal].time
        inside = (time >= window[0]) & (time <= window[1])
        if np.sum(inside) < 2 or not np.any(np.isfinite(problem.measured[each.rows][inside])):
            continue
        t, measured = time[inside], problem.measured[each.rows][inside]
        series = [Series(name="measured", x=t, y=measured, role="data", points=points)]
        left = [_band(noise.level(each.signal), t)]
        reach = _BEYOND * max(float(np.nanmax(measured) - np.nanmin(measured)), noise.level(each.signal))
        for name, rows in predictions.items():
            simulated = rows[each.rows][inside]
            near = np.abs(simulated - np.nanmean(measured)) <= reach
            series.append(Series(name=name, x=t, y=np.where(near, simulated, np.nan), color=COLOURS[name]))
            if name in last_two:
                difference = np.where(near, measured - simulated, np.nan)
                left.append(Series(name=name, x=t, y=difference, color=COLOURS[name]))
        axis = axis_of(each.signal)
        panels.append(Panel(axis=axis, series=series))
        residual = Axis(name=f"Residual of {axis.name.lower()}", unit=axis.unit, symbol=f"Δ{axis.symbol}")
        panels.append(Panel(axis=residual, series=left))
    plot = time_series(panels, spans=spans, max_points=_POINTS, panel_height=_PANEL)
    plot.figure.update_traces(marker_size=4, selector={"mode": "markers", "name": "measured"})
    for trace in plot.figure.data:
        if trace.mode == "lines" and trace.line.width > _WIDTH and not points:
            trace.line.width = _WIDTH
    return plot


def _throttle(problem: Problem, index: int, window: tuple[float, float]) -> Panel:
    experiment = problem.recordings[index].experiment
    time = experiment.dt * np.arange(experiment.throttle.size)
    inside = np.flatnonzero((time >= window[0]) & (time <= window[1]))
    kept = inside[:: -(-inside.size // _POINTS) or 1]
    volts = np.round(experiment.throttle[kept], 6)  # else a constant one shows its rounding
    series = Series(name="throttle", x=time[kept], y=volts, role="reference")
    return Panel(axis=Axis(name="Throttle", unit="V", symbol="u"), series=[series])


def _band(deviation: float, time: Array) -> Series:
    ends = np.array([time[0], time[-1]])
    width = np.full(2, 2.0 * deviation)
    return Series(name="± 2 σ of the noise", x=ends, y=np.zeros(2), low=-width, high=width, role="reference")
