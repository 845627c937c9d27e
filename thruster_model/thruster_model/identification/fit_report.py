"""The report of a study: warnings, verdict, data against fits, errors, steady states, parameters, residuals."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from run_bag.report import (
    Axis,
    Cell,
    Column,
    Panel,
    Report,
    Residual,
    Series,
    curves,
    heat_map,
    residuals,
    time_series,
)
from thruster_model.identification.evaluation import Comparison
from thruster_model.identification.experiment import SIGNALS, Experiment
from thruster_model.identification.spectrum import amplitude_density
from thruster_model.identification.steady_state import predicted_steady_states, steady_states
from thruster_model.identification.study import FittedModel, Study
from thruster_model.parameter_set_io import dump_parameter_set

__all__ = ["build_report", "quality", "warnings_of"]

Array = NDArray[np.float64]
_QUALITIES = ((1.5, "to within their noise"), (3.0, "fairly"))
"""Limits of an error over the noise, and what is said of one below."""
_POOR = "poorly"
_NAMES = {"simplified": "simplified", "hl": "HL", "hq": "HQ"}


def build_report(study: Study, *, provenance: Mapping[str, object], reference_name: str = "published") -> Report:
    """Return the report of a study; `reference_name` is what the reference sets are called in it."""
    runs = len(study.experiments)
    report = Report(
        "Thruster identification",
        f"{', '.join(_title(m) for m in study.models)} fitted to {runs} run{'s' if runs > 1 else ''}",
        provenance,
    )
    for text in warnings_of(study):
        report.warning(text)
    _verdict(report, study, reference_name)
    _runs(report, study)
    _errors(report, study, reference_name)
    _steady_states(report, study)
    for model in study.models:
        _parameters(report, model, reference_name)
    _residuals(report, study)
    report.section("What was done to the recordings")
    report.key_values({e.name: list(e.notes) for e in (*study.experiments, *study.validation)})
    return report


def warnings_of(study: Study) -> list[str]:
    """Return what a reader must know first, one sentence each."""
    found = [f"{e.name}: {text}" for e in (*study.experiments, *study.validation) for text in e.warnings]
    measured = {signal for e in study.experiments for signal in e.measurements}
    predicted = {signal for m in study.models for signal in m.result.parameter_set.model.signals}
    for signal in SIGNALS:
        if signal in predicted - measured:
            found.append(f"{SIGNALS[signal].title} was not measured in any run: what depends on it is not determined.")
    throttles = np.concatenate([e.throttle for e in study.experiments])
    for side, seen in (("forward", np.any(throttles > 0)), ("reverse", np.any(throttles < 0))):
        if not seen:
            found.append(f"No run has {side} throttle: the {side} parameters are not determined.")
    if any(e.throttle_shift_std > 0 for e in study.experiments):
        found.append(
            "The throttle was not recorded but reconstructed in some runs; its instants were fitted within limits."
        )
    for model in study.models:
        kinds: dict[str, list[str]] = {}
        for d in model.result.determinations:
            kinds.setdefault(d.status, []).append(d.name)
        for status in ("not excited", "at a bound", "flat", "traded off"):
            if status in kinds:
                found.append(f"{_title(model)}: {status}: {', '.join(kinds[status])} (see its parameters).")
        left_out = model.held_out[1] if model.held_out else ()
        for where, compared in (
            ("", model.comparison),
            (" on runs left out", left_out),
            (" on other runs", model.validation),
        ):
            found += [f"{_title(model)}: {_sentence(c, where)}" for c in compared if c.worse]
    return found


def _verdict(report: Report, study: Study, reference_name: str) -> None:
    """Say how well each model describes the runs, and what to do."""
    report.section("Verdict")
    totals = {model.name: next(c for c in model.comparison if c.signal == "total") for model in study.models}
    told = []
    for model in study.models:
        total = totals[model.name]
        text = (
            f"{_title(model)}, fitted, describes these runs {quality(total.error)}: {total.error:.2g} times their noise"
        )
        text += f" ({reference_name}: {total.reference:.2g})"
        left_out = next((c for c in model.held_out[1] if c.signal == "total"), None) if model.held_out else None
        if left_out is not None:
            text += f", {left_out.error:.2g} on runs left out of the fit"
        told.append(f"{text}.")
    best = min(study.models, key=lambda model: totals[model.name].error)
    open_ = [d.name for d in best.result.determinations if d.status != "determined"]
    todo = f"Take {best.name}.yaml; whether its parameters imitate what a simulator lacks, `diagnose` says"
    if quality(totals[best.name].error) == _POOR:
        todo = f"Let `diagnose` say what is missing before you rely on {best.name}.yaml"
    if open_:
        todo += f"; record what would determine {', '.join(open_)}, which these runs leave open"
    report.key_values({"answer": " ".join(told), "what to do": f"{todo}."})


def quality(error: float) -> str:
    """Return in words how well a model describes runs whose error is that many times the noise [1]."""
    if not np.isfinite(error):
        return "not at all"
    return next((word for limit, word in _QUALITIES if error < limit), _POOR)


def _title(model: FittedModel) -> str:
    return _NAMES.get(model.name, model.name)


def _sentence(comparison: Comparison, where: str) -> str:
    name = "the total error" if comparison.signal == "total" else SIGNALS[comparison.signal].title.lower()
    return (
        f"{name} is described worse than by the reference{where}, {comparison.error:.3g} against "
        f"{comparison.reference:.3g} (standard error of the difference {comparison.difference_error:.2g})."
    )


def _errors(report: Report, study: Study, reference_name: str) -> None:
    report.section("How well each model describes the thruster")
    report.paragraph(
        "Root mean square of measured less predicted cell means, simulated from rest with the recorded throttle alone. "
        "The total weighs each signal by its noise and counts every cell; 1 would be nothing but noise."
    )
    columns: list[Column | str] = ["Model", "Signal", "Unit", Column(name="Noise", digits=3)]
    columns += [Column(name=reference_name.capitalize(), digits=3), Column(name="Fit", digits=3)]
    columns += [Column(name="Error of the difference", digits=2)]
    held_out = any(m.held_out for m in study.models)
    validated = any(m.validation for m in study.models)
    if held_out:
        columns.append(Column(name="Fit, each run left out", digits=3))
    if validated:
        columns.append(Column(name=f"{reference_name.capitalize()}, other runs", digits=3))
        columns.append(Column(name="Fit, other runs", digits=3))
    rows = []
    for model in study.models:
        left_out = {c.signal: c for c in model.held_out[1]} if model.held_out else {}
        others = {c.signal: c for c in model.validation}
        for c in model.comparison:
            total = c.signal == "total"
            row: list[object] = [_title(model), "total, noise-weighted" if total else SIGNALS[c.signal].title]
            row += ["–" if total else SIGNALS[c.signal].unit, 1.0 if total else model.fitted.noise[c.signal]]
            row += [c.reference, _marked(c), c.difference_error]
            if held_out:
                row.append(_marked(left_out[c.signal]) if c.signal in left_out else None)
            if validated:
                row += [others[c.signal].reference, _marked(others[c.signal])] if c.signal in others else [None, None]
            rows.append(row)
    report.table(
        columns,
        rows,
        caption="Errors by model and signal.",
        notes=[
            "✓: smaller than the reference's by more than the error of the difference (standard error of a paired "
            "block bootstrap, blocks of 2 s); ▲: larger by more than that."
        ],
    )


def _marked(comparison: Comparison) -> object:
    if comparison.worse:
        return Cell(comparison.error, "worse")
    better = comparison.reference - comparison.error > comparison.difference_error
    return Cell(comparison.error, "best") if better else comparison.error


def _runs(report: Report, study: Study) -> None:
    report.section("Data against fits")
    for index, experiment in enumerate(study.experiments):
        panels = [_throttle_panel(experiment)]
        for signal in SIGNALS:
            if signal not in experiment.measurements:
                continue
            m = experiment.measurements[signal]
            series = [Series(name="measured", x=m.time, y=m.values, role="data")]
            series += [
                Series(name=_title(model), x=m.time, y=model.predictions[index, signal], color=number)
                for number, model in enumerate(study.models)
                if (index, signal) in model.predictions and signal in model.result.parameter_set.model.signals
            ]
            panels.append(Panel(axis=_axis(signal), series=series))
        report.figure(
            time_series(panels),
            caption=f"{experiment.name}: measured cell means and what each fitted model predicts from the throttle.",
            alt=f"Throttle, and measured and predicted signals over time of the run {experiment.name}.",
        )


def _throttle_panel(experiment: Experiment) -> Panel:
    time = experiment.dt * np.arange(experiment.throttle.size)
    step = max(1, round(0.02 / experiment.dt))
    series = Series(name="commanded", x=time[::step], y=experiment.throttle[::step], role="reference")
    return Panel(axis=Axis(name="Throttle", unit="V", symbol="u"), series=[series])


def _axis(signal: str) -> Axis:
    s = SIGNALS[signal]
    return Axis(name=s.title, unit=s.unit, symbol=s.symbol)


def _steady_states(report: Report, study: Study) -> None:
    report.section("Steady states")
    plateaus = steady_states(study.experiments)
    throttles = np.concatenate([e.throttle for e in study.experiments])
    grid = np.linspace(min(-0.1, float(throttles.min())), max(0.1, float(throttles.max())), 61)
    models = [(m, predicted_steady_states(m.coefficients, grid)) for m in study.models]
    plots = []
    for x, y in ((None, "speed"), ("speed", "thrust"), ("speed", "torque"), (None, "axial"), (None, "ambient")):
        measured = [p for p in plateaus if y in p.signals and (x is None or x in p.signals)]
        if not any(y in m.result.parameter_set.model.signals for m in study.models):
            continue
        series = []
        if measured:
            means = np.array([p.signals[y][0] for p in measured])
            spread = np.array([p.signals[y][1] for p in measured])
            at = np.array([p.throttle if x is None else p.signals[x][0] for p in measured])
            low, high = means - 2 * spread, means + 2 * spread
            series.append(Series(name="measured", x=at, y=means, low=low, high=high, role="data", points=True))
        series += [
            Series(name=_title(m), x=grid if x is None else states[x], y=states[y], color=number)
            for number, (m, states) in enumerate(models)
            if y in m.result.parameter_set.model.signals
        ]
        axis = Axis(name="Throttle", unit="V", symbol="u") if x is None else _axis(x)
        plots.append(curves(series, x=axis, y=_axis(y)))
    report.figure(
        plots,
        caption="Steady states: means of plateaus at least 2 s after the last change of the throttle, with two "
        "standard errors, and the fitted models after 40 s.",
        alt="Rotor speed and flows over throttle, thrust and torque over rotor speed, measured and fitted.",
    )


def _parameters(report: Report, model: FittedModel, reference_name: str) -> None:
    result = model.result
    report.section(f"Parameters: {result.parameter_set.model.title}")
    report.paragraph(
        "Equations: docs/models.md, or `ros2 run thruster_model reference`. Standard deviations account for correlated "
        f"residuals (here they remember about {result.memory:.0f} cells) but not for what the model leaves out."
    )
    judged = {d.name: d for d in result.determinations}
    rows: list[list[object]] = []
    for name, parameter in result.parameter_set.parameters.items():
        d = judged.get(name)
        status = d.status if d else "not fitted"
        known = model.reference.parameters.get(name)
        value: object = _number(parameter.value)
        rows.append(
            [
                name,
                result.parameter_set.model.definition(name).meaning,
                parameter.unit,
                _number(known.value) if known else None,
                value if status == "determined" else Cell(value, "emphasis"),
                _number(parameter.standard_deviation),
                status if not d or status == "determined" else Cell(status, "emphasis"),
            ]
        )
    heads: list[Column | str] = ["Parameter", "Meaning", "Unit"]
    heads += [Column(name=n, align="right") for n in (reference_name.capitalize(), "Fit", "Standard deviation")]
    report.table([*heads, "What the data say"], rows, caption=f"Parameters of the {_title(model)} model.")
    left_open = {d.name: f"{d.status}: {d.sentence}." for d in result.determinations if d.status != "determined"}
    if left_open:
        report.paragraph("What the data do not determine:")
        report.key_values(left_open)
    if len(result.free) > 1:
        report.figure(
            heat_map(result.correlation, columns=list(result.free)),
            caption=f"Correlation of the estimates, {_title(model)}.",
            alt="Matrix of correlation coefficients between fitted parameters.",
        )
    report.download(f"Parameter set ({_title(model)})", f"{model.name}.yaml", dump_parameter_set(result.parameter_set))


def _number(value: float | None) -> str | None:
    return None if value is None else f"{value:.4g}"


def _residuals(report: Report, study: Study) -> None:
    report.section("Residuals")
    for signal in SIGNALS:
        shown = []
        for number, model in enumerate(study.models):
            series = {i: r for (i, s), r in model.fitted.residuals.items() if s == signal}
            if not series:
                continue
            index = max(series, key=lambda i: int(np.isfinite(series[i]).sum()))
            m = study.experiments[index].measurements[signal]
            frequency, density = amplitude_density(list(series.values()), 1.0 / m.width)
            if frequency.size == 0:
                frequency, density = np.array([0.1, 0.5 / m.width]), np.array([np.nan, np.nan])
            shown.append(
                Residual(
                    name=_title(model),
                    time=m.time,
                    value=series[index],
                    frequency=frequency,
                    density=density,
                    color=number,
                )
            )
        if shown:
            noise = study.models[0].fitted.noise[signal] * float(np.sqrt(2.0 * m.width))
            report.figure(
                residuals(shown, quantity=_axis(signal), noise_floor=noise),
                caption=f"{SIGNALS[signal].title}: residuals of the run {study.experiments[index].name} and the "
                "spectrum over all runs. What lies above the noise floor at low frequencies the model leaves out.",
                alt=f"Residuals of {SIGNALS[signal].title.lower()} over time, and their amplitude spectral density.",
            )
