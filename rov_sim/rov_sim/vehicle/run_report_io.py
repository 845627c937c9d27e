"""The report of recorded runs of a vehicle: scores, trajectories against set points, thrusters, the path in space."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from rov_sim.vehicle.path_plot_io import path_plot
from rov_sim.vehicle.recording_io import VehicleRecording
from rov_sim.vehicle.run_failures_io import add_failures, failures_in_words
from rov_sim.vehicle.run_panels_io import (
    attitude_panels,
    battery_panels,
    rate_panels,
    thruster_panels,
    velocity_panels,
    wrench_panels,
)  # fmt: skip
from rov_sim.vehicle.run_scores_io import RunScores
from rov_sim.vehicle.scores import DEGREES_OF_FREEDOM, Score
from run_bag.report import Axis, Bars, Column, Report, bars, time_series

__all__ = ["Scored", "build_report", "verdict"]

Scored = tuple[str, VehicleRecording, RunScores]
"""Name, recording, scores."""


def build_report(runs: Sequence[Scored], about: Mapping[str, Any]) -> Report:
    """Return the report of one run, or of several side by side."""
    names = ", ".join(name for name, _, _ in runs)
    report = Report("Run of the vehicle" if len(runs) == 1 else "Runs of the vehicle", names, dict(about))
    for name, recording, scores in runs:
        for sentence in recording.run.warnings:
            report.warning(sentence if len(runs) == 1 else f"{name}: {sentence}")
        if not scores.tracking:
            report.warning(f"{name}: no set point was recorded, so nothing can be said about tracking.")
        if recording.truth is None:
            report.warning(f"{name}: no truth was recorded; what the vehicle did is what its odometry says.")
    report.section("Verdict")
    for name, recording, scores in runs:
        report.paragraph(" ".join([verdict(name, scores), *failures_in_words(recording)]))
    if len(runs) > 1:
        report.section("Scores")
        _comparison(report, runs)
    for name, recording, scores in runs:
        report.section("Scores" if len(runs) == 1 else f"Run {name}")
        _tracking_table(report, scores)
        add_failures(report, recording)
        _motion(report, recording, scores)
        if recording.thrusters:
            _thrusters(report, recording, scores)
    return report


def verdict(name: str, scores: RunScores) -> str:
    """Return how well a vehicle followed what was to move, and where to look first, in a sentence or two."""
    found = {
        each.words: scores.tracking[each.id]
        for each in DEGREES_OF_FREEDOM
        if each.id in scores.tracking and np.isfinite(scores.tracking[each.id].normalised)
    }
    if not found:
        return f"{name}: nothing can be said about tracking: record set points that move beside the odometry."
    shares = {words: 100.0 * one.normalised for words, one in found.items()}
    best, worst = min(shares, key=shares.__getitem__), max(shares, key=shares.__getitem__)
    percent = {words: f"{share:.0f} %" if share >= 10.0 else f"{share:.2g} %" for words, share in shares.items()}
    told = f"{name}: {best} follows best, RMSE {percent[best]} of the mean set point"
    return f"{told}; {worst} worst, {percent[worst]}: look there first." if worst != best else f"{told}."


def _tracking_table(report: Report, scores: RunScores) -> None:
    rows = [
        [each.words, each.unit, *_cells(scores.tracking[each.id])]
        for each in DEGREES_OF_FREEDOM
        if each.id in scores.tracking and scores.tracking[each.id].samples
    ]
    if not rows:
        return
    columns: list[Column | str] = ["Degree of freedom", "Unit", "RMSE", "Mean |set point|"]
    columns += [Column(name="RMSE over it", unit="%", digits=3), "Largest error", Column(name="Samples", format=".0f")]
    report.table(
        columns,
        rows,
        caption=f"Tracking, from {scores.begin:.2f} s to {scores.end:.2f} s, judged by {scores.judged_by}.",
        notes=[
            "A degree of freedom of which nothing but 0 was wanted has no relative error. Wanted body rates are those "
            "that turn the actual attitude at the wanted rates of roll, pitch and yaw."
        ],
    )


def _cells(one: Score) -> list[float | int | None]:
    return [one.rmse, one.set_point, 100.0 * one.normalised, one.largest, one.samples]


def _comparison(report: Report, runs: Sequence[Scored]) -> None:
    shown = [
        each
        for each in DEGREES_OF_FREEDOM
        if any(np.isfinite(scores.tracking[each.id].normalised) for _, _, scores in runs if scores.tracking)
    ]
    if not shown:
        return
    errors = {
        name: [100.0 * s.tracking[each.id].normalised if s.tracking else np.nan for each in shown]
        for name, _, s in runs
    }
    report.table(
        ["Degree of freedom", *(Column(name=name, unit="%", digits=3) for name in errors)],
        [[each.words, *(values[k] for values in errors.values())] for k, each in enumerate(shown)],
        caption="RMSE over the mean |set point|, of the degrees of freedom that were to move.",
    )
    groups = [Bars(name=name, value=values, color=k) for k, (name, values) in enumerate(errors.items())]
    report.figure(
        bars([each.words for each in shown], groups, quantity=Axis(name="RMSE over the mean |set point|", unit="%")),
        caption="The same as bars.",
        alt="The bars show the relative errors of the table, one bar for each run.",
    )


def _motion(report: Report, recording: VehicleRecording, scores: RunScores) -> None:
    report.subsection("Path")
    report.figure(
        path_plot(recording),
        caption="Path and attitude: needles point forward and to the vehicle's upper side. Drag to turn.",
        alt=_path_words(recording),
    )
    report.subsection("Against the set points")
    report.figure(
        [time_series(velocity_panels(recording)), time_series(rate_panels(recording))],
        caption="Velocities of the body and rates about its axes.",
        alt="Actual and wanted velocities and rates over time; errors in the table of scores.",
    )
    report.figure(
        [time_series(part) for part in attitude_panels(recording)],
        caption="Attitude against its set point, and position.",
        alt="Actual and wanted roll, pitch and yaw, and position over time; errors in the table of scores.",
    )
    wrench = wrench_panels(recording)
    if wrench:
        report.figure(
            [time_series(part) for part in wrench], caption="Wrench that the outer loop wanted, in body axes.",
            alt="Forces and moments over time.",
        )  # fmt: skip
    if scores.odometry:
        report.table(
            ["Quantity", "Unit", "RMSE", "Mean |true|", "Largest error"],
            [
                [each.words, each.unit, one.rmse, one.set_point, one.largest]
                for each in DEGREES_OF_FREEDOM
                if (one := scores.odometry[each.id]).samples
            ],
            caption="What rov/odometry says against the truth.",
        )


def _path_words(recording: VehicleRecording) -> str:
    place = recording.motion.position
    extent = np.nanmax(place, axis=0) - np.nanmin(place, axis=0)
    end = place[-1] - place[0]
    return (
        f"The path spans {extent[0]:.2f} m north, {extent[1]:.2f} m east and {extent[2]:.2f} m in depth, and ends "
        f"{end[0]:+.2f} m north, {end[1]:+.2f} m east and {end[2]:+.2f} m down of where it began."
    )


def _thrusters(report: Report, recording: VehicleRecording, scores: RunScores) -> None:
    report.subsection("Thrusters")
    columns: list[Column | str] = [
        "Thruster", Column(name="T: RMSE", unit="N"), Column(name="Mean |T_d|", unit="N"),
        Column(name="n̂: RMSE", unit="rad/s"), Column(name="v̂: RMSE", unit="m/s"), Column(name="Mean |v|", unit="m/s"),
        Column(name="Throttle: travel", unit="V"),
    ]  # fmt: skip
    rows: list[list[object]] = [
        [f"{k}", s.thrust.rmse, s.thrust.set_point, s.n.rmse, s.v.rmse, s.v.set_point, s.travel]
        for k, s in scores.thrusters.items()
    ]
    notes = []
    if scores.v.samples:
        notes = [
            f"v̂ over all thrusters: RMSE {scores.v.rmse:.4g} m/s, {100.0 * scores.v.normalised:.3g} % of the mean |v|."
        ]
    report.table(columns, rows, caption="Wanted thrust and estimates against the truth.", notes=notes)
    indices = list(recording.thrusters)
    for pair in (indices[k : k + 2] for k in range(0, len(indices), 2)):
        plots = [time_series(panels) for each in pair if (panels := thruster_panels(recording, each))]
        if plots:
            which = " and ".join(str(each) for each in pair)
            report.figure(
                plots, caption=f"Thruster{'s' if len(pair) > 1 else ''} {which}, from left to right.",
                alt="Thrust, throttle, rotor speed and flow over time; errors in the table of thrusters.",
            )  # fmt: skip
    battery = battery_panels(recording)
    if battery:
        report.figure(time_series(battery), caption="Battery.", alt="Voltage and current of the battery over time.")
