"""A recorded tracking experiment: its signals read from the run, and its report."""

import json
from collections.abc import Mapping
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rov_sim.experiment_scores import Experiment, Recorded, experiment_of
from run_bag import MissingTopicError, Run, read_run
from run_bag.report import Axis, Column, Panel, Report, Series, time_series
from thruster_control.scores import Scores
from thruster_model.identification.speed_sign import signed_speed

__all__ = ["build_report", "dump_scores", "read_experiment", "verdict"]

_LOADS = ("daq/{}/load.wrench.force.x", "{}/load.wrench.force.x")
_TOPICS = (
    "{}/thrust_setpoint", "{}/throttle", "{}/state", "{}/flow", "{}/load", "daq/{}/load", "{}/estimate", "{}/truth",
)  # fmt: skip
_SIGNALS = (
    ("n", "Rotor speed", "rad/s", (("measured", "state.n"), ("estimate", "estimate.n"), ("truth", "truth.n"))),
    ("v", "Axial flow", "m/s", (("estimate", "estimate.v"), ("truth", "truth.axial"))),
    (
        "U", "Ambient flow", "m/s",
        (("measured", "flow.ambient"), ("estimate", "estimate.ambient"), ("truth", "truth.ambient")),
    ),
)  # fmt: skip


def read_experiment(path: Path, kind: str, *, thruster: int = 0) -> tuple[Run, Experiment]:
    """Return a run and the experiment in it.

    Raises:
        RunError: the run cannot be read or lacks set point or throttle.
        ValueError: the set point of that kind is not in it.
    """
    name = f"thruster_{thruster}"
    topics = [each.format(name) for each in _TOPICS]
    try:
        run = read_run(path, topics)
    except MissingTopicError as error:  # what cannot be done without is found missing below
        there = error.found if isinstance(error.found, list) else []
        run = read_run(path, [topic for topic in topics if topic in there])
    loads = [channel for each in _LOADS if (channel := each.format(name)) in run]
    true = f"{name}/truth.thrust"
    return run, experiment_of(
        kind,
        _recorded(run, f"{name}/thrust_setpoint.thrust"),
        _recorded(run, f"{name}/throttle.commanded"),
        _recorded(run, loads[0]) if loads else None,
        _recorded(run, true) if true in run else None,
    )


def _recorded(run: Run, channel: str) -> Recorded:
    values = run[channel].values
    finite = np.isfinite(values)
    return Recorded(time=run.time(channel)[finite], values=values[finite])


def dump_scores(found: Experiment, about: Mapping[str, Any]) -> str:
    """Return the scores as JSON, null where there is none."""
    scores = {name: _plain(each) for name, each in (("load_cell", found.scores), ("truth", found.true_scores))}
    return json.dumps({**about, "begin": found.begin, "period": found.period, "scores": scores}, indent=1) + "\n"


def _plain(scores: Scores) -> dict[str, float | int | None]:
    return {name: value if isfinite(value) else None for name, value in scores._asdict().items()}


def build_report(run: Run, found: Experiment, about: Mapping[str, Any], *, thruster: int = 0) -> Report:
    """Return the report of an experiment."""
    title = f"Thrust tracking: {about['reference']}" + (f", {about['strategy']}" if about.get("strategy") else "")
    report = Report(title, run.name, dict(about))
    for sentence in run.warnings:
        report.warning(sentence)
    if not found.scores.samples:
        report.warning("No load cell was recorded: there is no measured score.")
    report.section("Verdict")
    report.paragraph(verdict(found))
    _signals(report, run, found, thruster)
    report.section("Scores")
    columns: list[Column | str] = [
        "Thrust",
        Column(name="RMSE", unit="N", digits=3),
        Column(name="RMSE of the set point's", unit="%", digits=3),
    ]
    columns += [
        Column(name="Largest error", unit="N", digits=3),
        Column(name="Travel of the throttle", unit="V", digits=3),
    ]
    rows = [
        [name, s.rmse, 100.0 * s.of_reference, s.largest, s.chatter]
        for name, s in (("load cell", found.scores), ("simulator's truth", found.true_scores))
        if s.samples
    ]
    if rows:
        report.table(
            columns, rows, caption="Tracking error over the published windows; thrust as a mean over each period."
        )
    return report


def verdict(found: Experiment) -> str:
    """Return how well the thrust followed its set point, and what to do, in a sentence or two."""
    for scores, judge in ((found.scores, "the load cell"), (found.true_scores, "the simulator's truth")):
        if scores.samples:
            share = f" ({100.0 * scores.of_reference:.0f} % of its size)" if isfinite(scores.of_reference) else ""
            return (
                f"By {judge}, thrust missed its set point by {scores.rmse:.2g} N{share}, "
                f"at most by {scores.largest:.2g} N. "
                "Score another strategy on the same set point to see which follows better."
            )
    return "Nothing can be said about tracking: record a load cell, or the simulator's truth, beside the set point."


def _signals(report: Report, run: Run, found: Experiment, thruster: int) -> None:
    report.section("Signals")
    thrust = [Series(name="set point", x=found.time, y=found.T_d, role="reference")]
    for name, values in (("load cell", found.load), ("truth", found.true)):
        if np.any(np.isfinite(values)):
            thrust.append(Series(name=name, x=found.time, y=values, role="data" if name == "load cell" else "fit"))
    panels = [
        Panel(axis=Axis(name="Thrust", unit="N", symbol="T"), series=thrust),
        Panel(
            axis=Axis(name="Throttle", unit="V", symbol="u"), series=[Series(name="commanded", x=found.time, y=found.u)]
        ),
    ]
    for symbol, words, unit, channels in _SIGNALS:
        series = _series(run, found, f"thruster_{thruster}", channels)
        if series:
            panels.append(Panel(axis=Axis(name=words, unit=unit, symbol=symbol), series=series))
    report.figure(
        time_series(panels),
        caption="The run of 10 s: thrust, throttle, speed, flows. A speed measured without sign has the throttle's.",
        alt="Wanted and measured thrust, throttle, rotor speed, axial and ambient flow over time; scores in the table.",
    )


def _series(run: Run, found: Experiment, name: str, channels: tuple[tuple[str, str], ...]) -> list[Series]:
    series = []
    for label, field in channels:
        channel = f"{name}/{field}"
        if channel not in run or not np.any(np.isfinite(run[channel].values)):
            continue
        time = run.time(channel) - found.begin
        inside = (time >= 0.0) & (time <= found.time[-1])
        role = {"measured": "data", "truth": "reference"}.get(label)
        options: dict[str, Any] = {} if role is None else {"role": role}
        values = run[channel].values[inside]
        if field == "state.n":
            values = _with_sign(time[inside], values, found)
        series.append(Series(name=label, x=time[inside], y=values, **options))
    return series


def _with_sign(time: NDArray[np.float64], speed: NDArray[np.float64], found: Experiment) -> NDArray[np.float64]:
    """Return a speed [rad/s] with the sign that the throttle gives it, where the tachometer knows none."""
    if np.any(speed < 0.0) or not np.any(found.u < 0.0):
        return speed
    return signed_speed(time, speed, (found.time, found.u))
