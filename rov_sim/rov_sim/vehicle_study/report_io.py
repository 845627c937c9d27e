"""The report of a study in the manner of Figs. 5.9 to 5.14, and its tables in Markdown."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from rov_sim.study.results import Results
from rov_sim.vehicle.loop import VehicleLoopRun
from rov_sim.vehicle_study.assumptions import unit_of
from rov_sim.vehicle_study.judgement import Judgement, judged
from rov_sim.vehicle_study.plan import Group, Plan
from rov_sim.vehicle_study.runs_io import first_runs
from rov_sim.vehicle_study.tables import assumption_table, case_table, claim_table, error_table, finding_lines
from run_bag.report import Axis, Bars, Column, Panel, Report, Series, bars, time_series
from safe_files.whole_files_io import write_whole
from thruster_control.strategies import STRATEGIES

__all__ = ["build_report", "write_tables"]

_MOTIONS = (
    Axis(name="surge", unit="m/s", symbol="u"), Axis(name="pitch rate", unit="rad/s", symbol="q"),
    Axis(name="pitch", unit="rad", symbol="θ"),
)  # fmt: skip
_ERRORS = {"surge": "surge", "pitch_rate": "pitch rate", "pitch": "pitch"}
_FIGURES = {"speed_loop": ("5.9", "5.10"), "flow": ("5.11", "5.12")}
_IN_A_FIGURE = 5


def write_tables(study: Results, plan: Plan, file: Path) -> None:
    """Write all tables of a study as Markdown."""
    cases = plan.all_cases
    judgements = judged(study, cases)
    texts = ["## Assumed", assumption_table(plan), "## Claims", claim_table(judgements, plan, cases)]
    for group in plan.groups:
        case = plan.typical(group).name
        texts += [f"## {group.name}: {group.title}", f"In the case `{case}`:", error_table(study, case)]
        texts += [finding_lines(judgements, case), "Error of pitch [%]:", case_table(study, plan, group)]
    write_whole(file, "\n\n".join(texts) + "\n", replace=True)


def build_report(study: Results, plan: Plan, contents: Mapping[str, str], provenance: Mapping[str, object]) -> Report:
    """Return the report; seed 0 of each group's typical case is simulated again for the figures."""
    cases = plan.all_cases
    report = Report(plan.title, f"{len(cases)} cases, {study.seeds} vehicles drawn", provenance)
    if study.seeds < 20:
        report.warning(f"Intervals rest on {study.seeds} seeds; at least 20 are needed for them to mean much.")
    judgements = judged(study, cases)
    report.section("Verdict")
    report.paragraph(verdict(judgements))
    _claims(report, judgements, plan)
    report.section("What was assumed")
    rows: list[list[object]] = [[k.replace("_", " "), a.value, unit_of(k), a.reason] for k, a in plan.assumed.items()]
    report.table(["Assumed", "Value", "Unit", "Why"], rows, caption="What the thesis leaves open, and what it states.")
    for group in plan.groups:
        report.section(f"{group.name}: {group.title}")
        _errors(report, study, plan, group)
        if group in plan.groups[:2]:
            runs = first_runs(plan, group, contents)
            _motions(report, group, runs)
            _flows(report, group, runs)
    return report


def verdict(judgements: list[Judgement]) -> str:
    """Return how many of the thesis' claims hold, and which depend on what the thesis leaves open."""
    named = {kind: [j.claim.key for j in judgements if j.verdict == kind] for kind in ("confirmed", "not confirmed")}
    parts = [
        f"{len(keys)} of {len(judgements)} claims are {kind} ({', '.join(keys)})"
        for kind, keys in named.items()
        if keys
    ]
    rest = [j.claim.key for j in judgements if j.verdict not in named]
    if rest:
        parts.append(f"{len(rest)} hold in part or depend on what is assumed ({', '.join(rest)})")
    return f"{'; '.join(parts)}. Fix what they depend on before you rely on one."


def _claims(report: Report, judgements: list[Judgement], plan: Plan) -> None:
    report.section("The claims of section 5.2")
    cases = plan.all_cases
    rows: list[list[object]] = []
    for j in judgements:
        shares = [f"{good}/{of}" if of else "–" for good, of in (j.share(cases, group.name) for group in plan.groups)]
        verdict = f"depends on {', '.join(j.depends)}" if j.verdict == "depends" else j.verdict
        rows.append([j.claim.key, j.claim.statement, verdict, *shares])
    heads = ["#", "Claim", "Verdict", *(group.name for group in plan.groups)]
    notes = ["Numbers: cases of the group in which the claim is confirmed, of those in which it was tested."]
    report.table(heads, rows, caption="Claims of the thesis against this study.", notes=notes)


def _errors(report: Report, study: Results, plan: Plan, group: Group) -> None:
    case = plan.typical(group).name
    groups = []
    for k, (name, title) in enumerate(_ERRORS.items()):
        found = [study.mean(s, case, name) for s in group.strategies]
        value, low, high = (100.0 * np.array([getattr(x, part) for x in found]) for part in ("value", "low", "high"))
        groups.append(Bars(name=title, value=value, low=low, high=high, color=k))
    like = f" (as Fig. {_FIGURES[group.name][1]})" if group.name in _FIGURES else ""
    report.figure(
        bars(group.strategies, groups, quantity=Axis(name="RMSE over the mean absolute set point", unit="%")),
        caption=f"Tracking errors{like} in the case {case}, 90 % intervals.",
        alt="Bars of the normalised error by strategy, one colour for each degree of freedom.",
    )
    names = {
        "sway": "m/s", "heave": "m/s", "roll": "rad", "yaw": "rad", "thrust": "N", "n_hat": "rad/s", "v_hat": "1",
        "v_largest": "m/s", "U_hat": "m/s", "limited": "1", "lost": "1",
    }  # fmt: skip
    rows: list[list[object]] = [
        [STRATEGIES[s].title, *(study.mean(s, case, name).value for name in names)] for s in group.strategies
    ]
    heads: list[Column | str] = ["Strategy"]
    heads += [Column(name=name.replace("_", " "), unit=unit, digits=3) for name, unit in names.items()]
    report.table(heads, rows, caption=f"Further scores in the case {case}, means over the seeds.")
    rows = [
        [c.name, *(100.0 * study.mean(s, c.name, "pitch").value for s in group.strategies)] for c in plan.cases(group)
    ]
    heads = ["Case", *[Column(name=s, unit="%", digits=2) for s in group.strategies]]
    report.table(heads, rows, caption="Error of pitch in all cases of the group, means over the seeds.")


def _motions(report: Report, group: Group, runs: Mapping[str, VehicleLoopRun]) -> None:
    plots = []
    for names in (group.strategies[:_IN_A_FIGURE], group.strategies[_IN_A_FIGURE:]):
        if not names:
            continue
        panels = []
        for k, axis in enumerate(_MOTIONS):
            series = [_wanted(runs[names[0]], k)]
            series += [Series(name=s, x=runs[s].time, y=_moved(runs[s], k), color=i) for i, s in enumerate(names)]
            panels.append(Panel(axis=axis, series=series))
        plots.append(time_series(panels, panel_height=150))
    like = f" (as Fig. {_FIGURES[group.name][0]})" if group.name in _FIGURES else ""
    report.figure(
        plots,
        caption=f"Set point and true motion{like}, seed 0.",
        alt="Surge, pitch rate and pitch of each strategy with their set points over 42 s.",
    )


def _moved(run: VehicleLoopRun, k: int) -> np.ndarray:
    return np.asarray((run.record.velocity[:, 0], run.record.velocity[:, 4], run.angles()[:, 1])[k])


def _wanted(run: VehicleLoopRun, k: int) -> Series:
    w = run.wanted()
    wanted = (w.velocity[:, 0], w.attitude_rate[:, 1], w.attitude[:, 1])[k]  # type: ignore[call-overload]
    return Series(name="set point", x=run.time, y=wanted, role="reference")


def _flows(report: Report, group: Group, runs: Mapping[str, VehicleLoopRun]) -> None:
    seeing = [s for s in group.strategies if STRATEGIES[s].observer in ("ekf", "nlo", "kfnlo")]
    if not seeing:
        return
    errors = [
        Series(name=s, x=runs[s].time, y=runs[s].of("v")[:, 0] - runs[s].record.axial[:, 0], color=k)
        for k, s in enumerate(seeing)
    ]
    report.figure(
        time_series([Panel(axis=Axis(name="error of v̂, thruster 0", unit="m/s"), series=errors)], panel_height=220),
        caption="Estimate of the axial flow less the truth (as Fig. 5.13), seed 0.",
        alt="Error of the estimated axial flow of one thruster for each observer.",
    )
