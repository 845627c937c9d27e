"""The report of a study: the thesis' Figs. 5.2 to 5.7 for one seed, normalised errors with intervals, real scores."""

from collections.abc import Mapping, Sequence

import numpy as np

from rov_sim.bench_study.claims import judged
from rov_sim.bench_study.experiment import Conditions, Experiment, run_experiment
from rov_sim.bench_study.real_runs import RealRun, real_score
from rov_sim.closed_loop import LoopRun
from rov_sim.study.results import BASELINE, Results
from run_bag.report import Axis, Bars, Cell, Column, Panel, Report, Series, bars, time_series
from thruster_control.strategies import STRATEGIES

__all__ = ["build_report", "verdict"]

_THRUST = Axis(name="thrust", unit="N", symbol="T")
_SPEED = Axis(name="rotor speed", unit="rad/s", symbol="n")
_FIGURES = {"step": "5.2", "triangle": "5.3", "sine": "5.4"}


def build_report(
    study: Results, given: Conditions, provenance: Mapping[str, object], real: Sequence[RealRun] = ()
) -> Report:
    """Return the report; seed 0 is simulated again for the figures."""
    subtitle = f"{len(study.strategies)} strategies, {len(study.references)} set points, {study.seeds} thrusters drawn"
    report = Report("Thrust control on the bench, simulated", subtitle, provenance)
    if study.seeds < 20:
        report.warning(f"Intervals rest on {study.seeds} seeds; at least 20 are needed for them to mean much.")
    report.section("Verdict")
    report.paragraph(verdict(study))
    report.section("What was simulated")
    report.paragraph(
        f"Plant: {given.truth.name}, each value times a factor of {100 * given.deviation:g} % deviation unless the set "
        f"states its own. Controllers: form '{given.form}', beliefs '{given.beliefs}'. Flow: "
        f"{100 * given.rig.spike_share:.2g} % spikes of {given.rig.spike_size:g} m/s. With one seed all strategies "
        "meet the same thruster and the same noise."
    )
    _scores(report, study)
    if real:
        _real(report, study, real)
    _claims(report, study)
    report.section("One run of each strategy, seed 0")
    runs = {
        (s, r): run_experiment(Experiment(s, r, 0), given) for s in study.strategies for r in study.references
    }  # fmt: skip
    for r in study.references:
        _thrusts(report, study, runs, r)
    shown = "sine" if "sine" in study.references else study.references[0]
    _speeds(report, study, runs, shown)
    _flows(report, study, runs, shown)
    return report


def verdict(study: Results) -> str:
    """Return which strategy follows each set point best, and how many of the thesis' statements hold."""
    told = []
    for r in study.references:
        means = {s: study.mean(s, r, "rmse") for s in study.strategies}
        best = min(means, key=lambda s: means[s].value)
        found = means[best]
        told.append(f"{r}: {STRATEGIES[best].title}, {found.value:.2f} N ({found.low:.2f} to {found.high:.2f} N)")
    claims = [c.verdict for c in judged(study)]
    held = (
        f"{claims.count('confirmed')} of the {len(claims) - claims.count('not tested')} statements that could be tested"
    )
    return f"Smallest error by set point: {'; '.join(told)}. Of section 5.1, {held} are confirmed."


def _scores(report: Report, study: Results) -> None:
    report.section("Tracking errors")
    if BASELINE in study.strategies:
        groups = []
        for k, r in enumerate(study.references):
            found = [study.normalised(s, r) for s in study.strategies]
            value, low, high = (np.array([getattr(x, name) for x in found]) for name in ("value", "low", "high"))
            groups.append(Bars(name=r, value=value, low=low, high=high, color=k))
        report.figure(
            bars(study.strategies, groups, quantity=Axis(name="RMSE over the lookup table's", unit="–"), reference=1.0),
            caption="Thrust tracking error normalised by the lookup table's (as Fig. 5.5), 90 % intervals.",
            alt="Bars of the normalised error by strategy, one colour for each set point; 1 is the lookup table.",
        )
    heads: list[Column | str] = ["Strategy"]
    for r in study.references:
        heads += [Column(name=f"{r}: RMSE", unit="N", digits=3), Column(name="90 %"), Column(name="normalised")]
    rows: list[list[object]] = []
    best = {}
    for r in study.references:
        means = {s: float(np.mean(study.of(s, r, "rmse"))) for s in study.strategies}
        best[r] = min(means, key=means.__getitem__)
    for s in study.strategies:
        row: list[object] = [STRATEGIES[s].title]
        for r in study.references:
            mean = study.mean(s, r, "rmse")
            row += [Cell(mean.value, "best" if best[r] == s else None), f"{mean.low:.2f} to {mean.high:.2f}"]
            if BASELINE in study.strategies:
                ratio = study.normalised(s, r)
                row.append(f"{ratio.value:.2f} ({ratio.low:.2f} to {ratio.high:.2f})")
            else:
                row.append(None)
        rows.append(row)
    notes = ["As the load cell tells it, means over a period, the published windows left out."]
    report.table(heads, rows, caption="Root mean square error of thrust, mean over the seeds.", notes=notes)
    names = {
        "rmse_true": "of the true thrust, N", "largest": "largest, N", "chatter": "travel of u, V", "speed": "n, rad/s",
        "n_hat": "n̂, rad/s", "v_hat": "v̂, m/s", "U_hat": "Û, m/s",
    }  # fmt: skip
    rows = [
        [f"{s}, {r}", *(study.mean(s, r, name).value for name in names)]
        for r in study.references
        for s in study.strategies
    ]
    heads = ["Strategy, set point", *(Column(name=word, digits=3) for word in names.values())]
    report.table(heads, rows, caption="Further scores, means over the seeds: errors against the truth, travel of u.")


def _real(report: Report, study: Results, real: Sequence[RealRun]) -> None:
    report.section("Beside the real runs")
    heads: list[Column | str] = ["Recording", "Strategy", "Set point", Column(name="RMSE", unit="N", digits=3)]
    heads += [Column(name="window as matched", unit="N", digits=3), Column(name="simulated", unit="N", digits=3)]
    heads += ["5 to 95 % of the seeds", "inside"]
    rows: list[list[object]] = []
    for run in real:
        row: list[object] = [run.name, run.strategy, run.reference, real_score(run).rmse]
        row.append(real_score(run, matched=True).rmse)
        if (run.strategy, run.reference) in study.scores:
            drawn = study.of(run.strategy, run.reference, "rmse")
            low, high = np.percentile(drawn, (5.0, 95.0))
            row += [float(np.mean(drawn)), f"{low:.2f} to {high:.2f}", "yes" if low <= row[3] <= high else "no"]  # type: ignore[operator]
        else:
            row += [None, None, None]
        rows.append(row)
    notes = ["Published windows; 'as matched': begun where tachometers of controller and load cell match."]
    report.table(
        heads, rows, caption="Real scores and the simulated ones of the same strategy and set point.", notes=notes
    )


def _claims(report: Report, study: Results) -> None:
    report.section("The statements of section 5.1")
    rows = [[c.statement, c.verdict, c.numbers] for c in judged(study)]
    report.table(
        ["Statement", "In this study", "Numbers"], rows, caption="Statements of the thesis against this study."
    )


def _thrusts(report: Report, study: Results, runs: Mapping[tuple[str, str], LoopRun], r: str) -> None:
    panels = []
    for names in (study.strategies[:4], study.strategies[4:8], study.strategies[8:]):
        if names:
            first = runs[names[0], r]
            wanted = Series(name="T_d", x=first.time, y=first.T_d, role="reference")
            each = [Series(name=s, x=runs[s, r].time, y=runs[s, r].force, color=k) for k, s in enumerate(names)]
            panels.append(time_series([Panel(axis=_THRUST, series=[wanted, *each])], panel_height=220))
    report.figure(
        panels,
        caption=f"Thrust and its set point, {r} (as Fig. {_FIGURES[r]}).",
        alt=f"True thrust of each strategy over 10 s with the {r} set point.",
    )


def _speeds(report: Report, study: Results, runs: Mapping[tuple[str, str], LoopRun], r: str) -> None:
    panels = []
    for s in study.strategies:
        run = runs[s, r]
        series = [
            Series(name="n_d", x=run.time, y=run.of("n_d"), role="reference"),
            Series(name="n", x=run.time, y=run.true("speed"), role="data"),
            Series(name="n̂", x=run.time, y=run.of("n"), color=0),
        ]
        axis = Axis(name=f"{s}: rotor speed", unit=_SPEED.unit, symbol="n")
        panels.append(Panel(axis=axis, series=series))
    report.figure(
        time_series(panels, panel_height=110),
        caption=f"Rotor speed wanted, true and estimated, {r} (as Fig. 5.6).",
        alt="One panel for each strategy: n_d, n and its estimate.",
    )


def _flows(report: Report, study: Results, runs: Mapping[tuple[str, str], LoopRun], r: str) -> None:
    seeing = [s for s in study.strategies if STRATEGIES[s].observer in ("ekf", "nlo", "kfnlo")]
    if not seeing:
        return
    panels = []
    for s in seeing:
        run = runs[s, r]
        pairs = (("axial", "v", "v", "v̂"), ("ambient", "U", "U", "Û"))
        for output, column, true, estimate in pairs:
            series = [
                Series(name="truth", x=run.time, y=run.true(output), role="reference"),
                Series(name="estimate", x=run.time, y=run.of(column), color=0),
            ]
            if column == "U":
                series.insert(0, Series(name="velocimeter", x=run.time, y=run.of("y_U"), role="data"))
            panels.append(Panel(axis=Axis(name=f"{s}: {true} and {estimate}", unit="m/s", symbol=true), series=series))
    report.figure(
        time_series(panels, panel_height=90),
        caption=f"Axial and ambient flow, estimates against the truth, {r} (as Fig. 5.7).",
        alt="Two panels for each observer with flow: v with its estimate, U with its estimate and the velocimeter.",
    )
