"""The report of a replay: scores of every observer on every run, and the estimates over time."""

from collections.abc import Mapping, Sequence

import numpy as np

from run_bag.report import Axis, Column, Panel, Report, Series, time_series
from thruster_estimation.replay import UNITS, Outcome, Signals
from thruster_model.identification.speed_sign import signed_speed

__all__ = ["build_report", "label", "verdict"]

_WORDS = {"n": "Rotor speed", "v": "Axial flow", "U": "Ambient flow"}


def label(outcome: Outcome) -> str:
    """Return the name of an observer with its model."""
    return f"{outcome.job.estimator}, {outcome.job.model}"


def build_report(outcomes: Sequence[Outcome], provenance: Mapping[str, object]) -> Report:
    """Return the report of a replay."""
    runs = list(dict.fromkeys(o.signals.name for o in outcomes))
    report = Report("Observers on recorded runs", ", ".join(runs), provenance)
    for sentence in _warnings(outcomes):
        report.warning(sentence)
    report.section("Verdict")
    report.paragraph(verdict(outcomes))
    for name in runs:
        of_run = [o for o in outcomes if o.signals.name == name]
        report.subsection(name)
        _figure(report, of_run[0].signals, of_run)
    report.section("Scores")
    report.paragraph(
        "One step ahead: measured less predicted, before the measurement was taken in. NIS: squared innovation over "
        "its variance, per degree of freedom; 1 for a consistent filter, with the interval in which 95 % of them lie."
    )
    kinds = list(dict.fromkeys((s.against, s.state, s.unit) for o in outcomes for s in o.scores))
    columns: list[Column | str] = ["Run", "Observer"]
    columns += [Column(name=f"{state}, {against.split(',')[0]}", unit=unit, digits=3) for against, state, unit in kinds]
    rows: list[list[object]] = []
    for o in outcomes:
        found = {(s.against, s.state, s.unit): s.rmse for s in o.scores}
        rows.append([o.signals.name, label(o), *(found.get(kind) for kind in kinds)])
    report.table(columns, rows, caption="Root mean square errors of the observers; the largest are in replay.json.")
    consistency: list[Column | str] = ["Run", "Observer", Column(name="NIS", digits=3)]
    consistency += [Column(name="from", digits=3), Column(name="to", digits=3)]
    consistency += [Column(name="Speeds refused", unit="%", digits=3), Column(name="Flows refused", unit="%", digits=3)]
    consistency.append(Column(name="Usable", unit="%", digits=4))
    rows = []
    for o in outcomes:
        low, high = o.nis_interval or (None, None)
        rows.append(
            [o.signals.name, label(o), o.nis, low, high, _percent(o.gated_n), _percent(o.gated_U), 100 * o.valid]
        )
    report.table(consistency, rows, caption="Consistency: NIS, measurements refused, usable estimates.")
    report.section("What was done to the recordings")
    report.key_values({o.signals.name: list(o.signals.notes) for o in outcomes})
    return report


_AGAINST = ("truth", "measured, one step ahead", "logged")
"""What observers are judged by, the best judge first."""


def verdict(outcomes: Sequence[Outcome]) -> str:
    """Return which observer comes closest, by root mean squares over the runs, and what to do, in a sentence or two."""
    for against in _AGAINST:
        found: dict[tuple[str, str], dict[str, list[float]]] = {}
        for o in outcomes:
            for s in o.scores:
                if s.against == against and np.isfinite(s.rmse):
                    found.setdefault((s.state, s.unit), {}).setdefault(label(o), []).append(s.rmse)
        if not found:
            continue
        told = []
        for (state, unit), errors in found.items():
            means = {name: float(np.sqrt(np.mean(np.square(values)))) for name, values in errors.items()}
            best = min(means, key=means.__getitem__)
            beside = f" of {len(means)}" if len(means) > 1 else ""
            told.append(f"{_WORDS[state].lower()} by {best}{beside}, {means[best]:.2g} {unit}")
        usable = min(o.valid for o in outcomes)
        todo = "Take the one that is best in what you control" if len(outcomes) > 1 else "Compare it with another one"
        kind = {"truth": "to the truth", "logged": "to the estimates in the run"}.get(
            against, "to measurements, one step ahead"
        )
        return f"Closest {kind}: {'; '.join(told)}. At least {100 * usable:.0f} % of the estimates are usable. {todo}."
    return "Nothing can be said: the runs hold nothing to judge an estimate by."


def _warnings(outcomes: Sequence[Outcome]) -> list[str]:
    """Return one sentence for each way to be inconsistent, and one for each outcome with useless estimates."""
    sentences = []
    for side in ("smaller", "larger"):
        found = [
            o.nis
            for o in outcomes
            if o.nis is not None
            and o.nis_interval is not None
            and (o.nis < o.nis_interval[0] if side == "smaller" else o.nis > o.nis_interval[1])
        ]
        if found:
            sentences.append(
                f"Innovations are {side} than the filter says in {len(found)} of {len(outcomes)} replays: NIS "
                f"{min(found):.2g} to {max(found):.2g} per degree of freedom. Fit the noise densities, or take the "
                "deviations as a ranking only."
            )
    for o in outcomes:
        if o.valid < 0.99:
            useless = f"{100 * (1 - o.valid):.1f} % of the estimates are not to be used (status INVALID)"
            sentences.append(f"{o.signals.name}, {label(o)}: {useless}.")
    return sentences


def _percent(share: float | None) -> float | None:
    return None if share is None else 100.0 * share


def _figure(report: Report, signals: Signals, outcomes: Sequence[Outcome]) -> None:
    panels = []
    for state in ("n", "v", "U"):
        measured = getattr(signals, f"y_{state}")
        series = []
        if state == "n" and signals.unsigned:
            measured = signed_speed(signals.time, np.abs(measured), (signals.time, signals.u_after))
        if np.any(np.isfinite(measured)):
            series.append(Series(name="measured", x=signals.time, y=measured, role="data", points=state != "n"))
        if state in signals.logged:
            when, values = signals.logged[state]
            series.append(Series(name="logged", x=when, y=values, role="reference"))
        if state in signals.truth:
            series.append(Series(name="truth", x=signals.time, y=signals.truth[state], role="reference"))
        for o in outcomes:
            if state in o.states:
                series.append(Series(name=label(o), x=o.instants, y=getattr(o.history, state)))
        if series:
            axis = Axis(name=_WORDS[state], unit=UNITS[state], symbol=state)
            panels.append(Panel(axis=axis, series=series))
    names = ", ".join(label(o) for o in outcomes)
    report.figure(
        time_series(panels),
        caption=f"Estimates by {names}; measurements beneath. A speed measured without sign has the throttle's.",
        alt=f"Estimated rotor speed, axial and ambient flow over time by {names}; the scores are in the first table.",
    )
