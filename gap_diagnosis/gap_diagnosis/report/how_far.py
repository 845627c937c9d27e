"""How far simulator and recordings are apart: four numbers in total and by channel, and what the effect takes off."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.report.wording import (
    COLOURS,
    KINDS,
    NOISE,
    key_of,
    number,
    percent,
    signal_of,
    title_of,
)
from run_bag.report import Axis, Bars, Cell, Column, Report, bars
from thruster_model.identification.experiment import SIGNALS

__all__ = ["add_how_far"]

_NEAR, _FAR = 1.05, 1.2  # times the noise floor
_LEAST = 1.03  # times the floor: below, there is no excess of which a share could be said
_LINEAR_UP_TO = 12.0
_RAISED = 1.5  # times the scatter of neighbouring samples


def add_how_far(report: Report, found: Diagnosis, content: Mapping[str, Any]) -> None:
    """Add the four numbers, as table and picture, and the shrink."""
    gap = content["gap"]
    if not gap["total"]:
        return
    report.section("How far")
    report.paragraph(
        "Root mean square of measured less simulated, in a free run driven by the recorded throttle. Re-tuned and "
        "with effect are judged on quarters of the runs that their fits have not seen. The total weighs each channel "
        "by its noise; 1 would be noise alone. Re-tuning alone can close most of a gap with wrong parameters: what "
        "tells is the step from re-tuned to with effect."
    )
    kinds = [kind for kind in KINDS if gap["total"][kind] is not None]
    samples = _noise_of_samples(found)
    raised: list[str] = []
    rows = [["Total, noise-weighted", "–", *_cells(gap["total"], kinds), None, _shrunk(gap["total"])]]
    for channel, errors in gap["channels"].items():
        name = SIGNALS[signal_of(channel)].title if signal_of(channel) in SIGNALS else channel
        rows.append([name, errors["unit"], *_cells(errors, kinds), number(samples.get(channel), 3), _shrunk(errors)])
        if samples.get(channel, np.inf) * _RAISED < errors["noise_floor"]:
            raised.append(f"{name.lower()} ({errors['noise_floor'] / samples[channel]:.1f} times)")
    heads: list[Column | str] = ["Channel", "Unit"]
    heads += [Column(name=KINDS[kind].capitalize(), align="right") for kind in kinds]
    heads.append(Column(name=NOISE.capitalize(), align="right"))
    heads.append(Column(name="Scatter of samples", align="right"))
    heads.append(Column(name="Shrink", align="right"))
    shrunk = any(effect["shrink"] is not None for effect in content["effects"])
    if not shrunk:
        heads, rows = heads[:-1], [row[:-1] for row in rows]
    notes = [f"✓: within {100 * (_NEAR - 1):.0f} % of the noise floor; ▲: more than {100 * (_FAR - 1):.0f} % above it."]
    if shrunk:
        notes.append(
            "Shrink: 1 − (with effect² − floor²)/(re-tuned² − floor²); – where re-tuned is at the noise floor already."
        )
    if raised:
        notes.append(
            "Beware: neighbouring samples scatter much less than the noise floor says for "
            f"{', '.join(raised)}. What no effect explains was counted as slow noise there; the floor hides it."
        )
    report.table(heads, rows, caption="Errors on held-out data.", notes=notes)
    _picture(report, gap, kinds)
    _shrinks(report, content)


def _noise_of_samples(found: Diagnosis) -> dict[str, float]:
    """Return by channel how much neighbouring samples scatter, judged by the data alone."""
    levels: dict[str, list[float]] = {}
    for recording in found.problem.recordings if found.problem else ():
        for signal, measurement in recording.experiment.measurements.items():
            levels.setdefault(recording.channel(signal), []).append(measurement.noise)
    return {channel: float(np.median(each)) for channel, each in levels.items()}


def _cells(errors: Mapping[str, Any], kinds: list[str]) -> list[object]:
    floor = errors["noise_floor"]
    return [*(_marked(errors[kind], floor) for kind in kinds), number(floor, 3)]


def _marked(value: float, floor: float) -> object:
    if value > _FAR * floor:
        return Cell(number(value, 3), "worse")
    return Cell(number(value, 3), "best") if value < _NEAR * floor else number(value, 3)


def _shrunk(errors: Mapping[str, Any]) -> object:
    floor, before, after = errors["noise_floor"], errors["retuned"], errors["with_effect"]
    if after is None or before < _LEAST * floor:
        return None
    return percent(1.0 - (after**2 - floor**2) / (before**2 - floor**2))


def _picture(report: Report, gap: Mapping[str, Any], kinds: list[str]) -> None:
    labels = ["Total"]
    table = [gap["total"]]
    for channel, errors in gap["channels"].items():
        signal = signal_of(channel)
        labels.append(f"{SIGNALS[signal].title} {SIGNALS[signal].symbol}" if signal in SIGNALS else channel)
        table.append(errors)
    values = {kind: np.array([each[kind] / each["noise_floor"] for each in table]) for kind in kinds}
    log = max(float(np.max(v)) for v in values.values()) > _LINEAR_UP_TO
    groups = [Bars(name=KINDS[kind], value=v, color=COLOURS[KINDS[kind]]) for kind, v in values.items()]
    report.figure(
        bars(labels, groups, quantity=Axis(name="error over noise", unit="–", log=log), reference=1.0),
        caption="Errors on held-out data over the noise floor of each channel (dashed line)"
        + (", on a logarithmic scale." if log else "."),
        alt=f"Bars of the errors of each channel over its noise: {', '.join(KINDS[kind] for kind in kinds)}.",
    )


def _shrinks(report: Report, content: Mapping[str, Any]) -> None:
    if not content["effects"]:
        return
    rows = []
    for effect in content["effects"]:
        interval = effect["shrink_interval"]
        between = f"{percent(interval[0])} to {percent(interval[1])}" if interval else None
        rows.append([title_of(key_of(effect)), effect["class"], percent(effect["shrink"]), between])
    right = [Column(name=name, align="right") for name in ("Shrink of the total", "90 % interval")]
    report.table(
        ["Effect", "Class", *right],
        rows,
        caption="How far each effect shrinks the gap that re-tuning leaves.",
        notes=[
            "Interval by a bootstrap over blocks of 2 s. – where re-tuning leaves no gap beyond two standard errors, "
            "where the effect is parametric (far re-tuning would do the same) or only scatters samples."
        ],
    )
