"""The report of a load cell: matrix, mode, recovered thrust, and how sure each is."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from run_bag.report import Axis, Cell, Column, Panel, Report, Series, Span, curves, time_series
from thruster_model.load_cell.calibration import ROWS
from thruster_model.load_cell.preparation import Recording, jumps
from thruster_model.load_cell.study import CalibrationStudy, RecoveryStudy
from thruster_model.load_cell.yaml_io import MODE_MEANING, MODE_UNITS, dump_load_cell

__all__ = ["build_report", "window_rows"]

Array = NDArray[np.float64]
_FORCE = Axis(name="Thrust", unit="N", symbol="T")
_UNITS = ("1", "1", "1", "m", "m", "m")


def build_report(
    recordings: Mapping[str, Recording],
    calibrated: CalibrationStudy | None,
    recovered: RecoveryStudy | None,
    why_not: str,
    provenance: Mapping[str, object],
) -> Report:
    """Return the report; `why_not` says why no thrust was recovered, where that is so."""
    report = Report("Load cell", f"{len(recordings)} recordings", provenance)
    if calibrated is None:
        report.warning("No recording holds gauges: the matrix was not calibrated.")
    else:
        for name in calibrated.other:
            report.warning(f"{name} was recorded with another matrix: it was left out of the calibration.")
        for text in calibrated.calibration.missing:
            report.warning(f"Calibration: {text}.")
    if recovered is None:
        report.warning(f"No thrust was recovered. {why_not}")
    else:
        report.warning(
            "Thrust within 0.1 s of a jump includes the motor's reaction and what accelerates water, as far as the "
            "structure feels them; no independent measurement of thrust exists to check it."
        )
    if calibrated is not None:
        _calibration(report, calibrated)
    if recovered is not None:
        _mode(report, recovered)
        _windows(report, recovered)
        _thrust(report, recordings, recovered)
    report.section("Files")
    report.download("Matrix and mode", "load_cell.yaml", dump_load_cell(calibrated, recovered))
    return report


def _calibration(report: Report, study: CalibrationStudy) -> None:
    c = study.calibration
    report.section("Matrix")
    report.paragraph(
        f"H_A (3.4) in the thruster's frame by linear least squares over {c.samples} samples; the gauges' forces have "
        f"the condition number {c.condition:.1f}, rank {c.rank} of 6. A population search on the same cost differs by "
        f"at most {np.max(np.abs(study.searched - c.matrix)):.1g}."
    )
    columns: list[Column | str] = ["Row", "Unit", *(Column(name=f"f_{i + 1}", format=".5f") for i in range(6))]
    columns.append(Column(name="largest deviation", format=".1e"))
    rows: list[list[object]] = [
        [row, _UNITS[i], *c.matrix[i], float(np.max(c.deviation[i]))] for i, row in enumerate(ROWS)
    ]
    report.table(columns, rows, caption="H_A; forces per newton of a gauge, moments in metres.")
    columns = ["Recording", Column(name="force", format=".1e"), Column(name="moment", format=".1e")]
    columns.append(Column(name="over rounding", digits=2))
    columns += [Column(name=f"rms {row}", unit="N" if i < 3 else "N m") for i, row in enumerate(ROWS)]
    columns.append("Matrix")
    rows = []
    own = "of the others" if len(study.reproduced) > 1 else "its own"
    for found, text in ((study.reproduced, own), (study.other, "another one")):
        for name, r in found.items():
            marks = [Cell(v, "best" if v < 1e-3 else "worse") for v in (r.force, r.moment)]
            rows.append([name, *marks, float(np.max(r.residual / r.rounding)), *r.residual, text])
    report.table(
        columns,
        rows,
        caption="Each recording's wrench from its gauges by the matrix of all others (its own where there is none): "
        "error relative to the root-mean-square force and moment, and by component.",
        notes=[
            "Best: below 1e-3. Over rounding: the largest component's error in units of what the rounding of the "
            "recorded numbers alone gives: 1 is perfect, and where loads are small it exceeds 1e-3 of them."
        ],
    )


def _mode(report: Report, study: RecoveryStudy) -> None:
    ring, resonance = study.ring, study.resonance
    report.section("Structural mode")
    used = [s for s in ring.segments if s.usable]
    report.paragraph(
        f"Free ringing in {len(used)} of {len(ring.segments)} quarter seconds after jumps. Around the law, frequencies "
        f"scatter by {ring.frequency_scatter:.2f} Hz, around one frequency by {ring.rigid_scatter:.2f} Hz; recordings "
        f"left out depart from the law of the others by {ring.left_out_scatter:.2f} Hz"
        + (": no better than one frequency for all." if ring.left_out_scatter >= ring.rigid_scatter else ".")
    )
    rows: list[list[object]] = [
        [name, MODE_MEANING[name], unit, f"{getattr(resonance.mode, name):.3g}", f"{resonance.deviation[name]:.2g}"]
        for name, unit in MODE_UNITS.items()
    ]
    right = [Column(name=n, align="right") for n in ("Value", "Standard deviation")]
    report.table(["Parameter", "Meaning", "Unit", *right], rows, caption="The mode that thrust excites.")
    amplitudes = np.geomspace(0.8, max(8.0, max(s.amplitude for s in used)), 50)
    points = [
        Series(name="law", x=amplitudes, y=resonance.mode.at(amplitudes), color=0),
        Series(
            name="segments",
            x=[s.amplitude for s in used],
            y=[s.frequency for s in used],
            role="data",
            points=True,
        ),
    ]
    damping = Series(
        name="segments", x=[s.amplitude for s in used], y=[s.damping for s in used], role="data", points=True
    )
    x = Axis(name="Amplitude of ringing", unit="N", symbol="A", log=True)
    report.figure(
        [
            curves(points, x=x, y=Axis(name="Frequency", unit="Hz", symbol="f")),
            curves([damping], x=x, y=Axis(name="Damping ratio", unit="1", symbol="ζ")),
        ],
        caption="Frequency and damping of free ringing against its amplitude, and the law that is used.",
        alt="Points of frequency and damping over amplitude, with the fitted law of the frequency.",
    )
    rows = [
        [name, count, departure, damping, resonance.single[name].leak, resonance.single[name].arm_gain]
        for name, (departure, damping, count) in ring.by_recording.items()
        if name in resonance.single
    ]
    heads: list[Column | str] = ["Recording", "Segments", Column(name="Departure from the law", unit="Hz", digits=2)]
    heads += [Column(name=n, digits=2) for n in ("Damping", "Leak", "Arm's correction")]
    report.table(heads, rows, caption="The mode, recording by recording.")


def window_rows(study: RecoveryStudy, names: tuple[str, ...]) -> list[list[object]]:
    """Return, for each recording, what is recovered of the windows that are otherwise cut."""
    rows = []
    for name in names:
        saved, r = study.saved[name], study.recovered[name]
        inside = np.zeros(r.cell_time.size, dtype=bool)
        for start, end in study.windows[name]:
            inside |= (r.cell_time >= start) & (r.cell_time < end)
        if not saved.cells:
            continue
        wild = float(np.sqrt(np.mean((r.cell_reading - r.cell_thrust)[inside] ** 2)))
        calm = float(np.sqrt(np.mean((r.cell_reading - r.cell_thrust)[~inside] ** 2)))
        rows.append(
            [name, saved.cells, 100 * saved.below_half, 100 * saved.below_one, saved.median_deviation, wild, calm,
             float(np.sqrt(np.mean(r.cell_difference[inside] ** 2)))]
        )  # fmt: skip
    return rows


def _windows(report: Report, study: RecoveryStudy) -> None:
    report.section("What is saved")
    report.paragraph(
        "Means over 40 ms in the windows that ringing costs: the windows that the thesis' scores leave out (step "
        "0–1.2 s and 5–6.2 s, ramp 0–0.6 s and 4.8–6 s), for other recordings 1.2 s after each jump of the throttle."
    )
    columns: list[Column | str] = ["Recording", "Cells", Column(name="Below 0.5 N", unit="%", format=".0f")]
    columns += [Column(name="Below 1 N", unit="%", format=".0f"), Column(name="Median deviation", unit="N", digits=2)]
    columns += [Column(name=n, unit="N", digits=2) for n in ("Ringing taken off", "the same outside")]
    columns.append(Column(name="Force against moment", unit="N", digits=2))
    others = tuple(n for n in study.saved if n not in study.of_thesis)
    for names, what in ((study.of_thesis, "The thesis' windows"), (others, "After jumps, other recordings")):
        if rows := window_rows(study, names):
            notes = ["Force against moment: rms of the thrust from the force alone less that from the moment alone."]
            report.table(
                columns, rows, caption=f"{what}: cells with a standard deviation below the limit.", notes=notes
            )


def _thrust(report: Report, recordings: Mapping[str, Recording], study: RecoveryStudy) -> None:
    report.section("Thrust")
    for name in study.recovered:
        spans = [Span(start, end, "otherwise cut") for start, end in study.windows[name]]
        if not spans:
            continue
        stretch = study.stretches[name]
        panels = [Panel(axis=_FORCE, series=_thrust_series(study, name))]
        speed = recordings[name].speed
        if speed is not None:
            at = np.searchsorted(recordings[name].time, stretch.time)
            panels.append(
                Panel(
                    axis=Axis(name="Rotor speed", unit="rad/s", symbol="n"),
                    series=[
                        Series(name="tachometer", x=stretch.time, y=speed[np.minimum(at, speed.size - 1)], role="data")
                    ],
                )
            )
        plots = [time_series(panels, spans=spans, panel_height=220)]
        start = max(jumps(stretch), key=lambda t: float(np.max(stretch.part(t, t + 0.5).amplitude)), default=None)
        if start is not None:
            near = [_cut(s, start - 0.2, start + 0.8) for s in panels[0].series]
            plots.append(time_series([Panel(axis=_FORCE, series=near)], panel_height=440))
        report.figure(
            plots,
            caption=f"{name}: the load cell's reading, and the thrust recovered from it with two standard deviations; "
            "beside it one second around the hardest jump.",
            alt=f"Reading and recovered thrust of {name} over time: the ringing is gone, the transient stays.",
        )


def _thrust_series(study: RecoveryStudy, name: str) -> list[Series]:
    stretch, r = study.stretches[name], study.recovered[name]
    two = 2 * r.cell_deviation
    return [
        Series(name="reading", x=stretch.time, y=stretch.reading[:, 0], role="data"),
        Series(
            name="recovered, 40 ms means",
            x=r.cell_time,
            y=r.cell_thrust,
            low=r.cell_thrust - two,
            high=r.cell_thrust + two,
            color=0,
        ),
    ]


def _cut(series: Series, start: float, end: float) -> Series:
    x = np.asarray(series.x)
    k = (x >= start) & (x <= end)
    low, high = (None if v is None else np.asarray(v)[k] for v in (series.low, series.high))
    y = np.asarray(series.y)[k]
    return Series(name=series.name, x=x[k], y=y, low=low, high=high, role=series.role, color=series.color)
