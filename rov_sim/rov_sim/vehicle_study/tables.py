"""Tables of a study in Markdown: what is assumed, errors by strategy and case, the verdicts."""

from collections.abc import Mapping

from rov_sim.study.results import BASELINE, Results
from rov_sim.vehicle_study.assumptions import unit_of
from rov_sim.vehicle_study.claims import CONFIRMED, IN_PART
from rov_sim.vehicle_study.judgement import Judgement
from rov_sim.vehicle_study.plan import Case, Group, Plan

__all__ = ["assumption_table", "case_table", "claim_table", "error_table", "finding_lines"]

_SHOWN = {"surge": "surge", "pitch_rate": "pitch rate", "pitch": "pitch", "v_hat": "v̂"}


def assumption_table(plan: Plan) -> str:
    """Return what is assumed, and why."""
    lines = ["| assumed | value | why |", "|---|---|---|"]
    for name, (value, reason) in plan.assumed.items():
        unit = unit_of(name)
        told = f"{value:g} {'' if unit == '1' else unit}".strip() if isinstance(value, int | float) else value or "–"
        lines.append(f"| {name.replace('_', ' ')} | {told} | {reason} |")
    return "\n".join(lines)


def error_table(study: Results, case: str) -> str:
    """Return the normalised errors of all strategies in one case, with 90 % intervals, in %."""
    here = [s for s in study.strategies if (s, case) in study.scores]
    heads = [f"{title} [%]" for title in _SHOWN.values()]
    lines = [f"| strategy | {' | '.join(heads)} | pitch over the table's |", "|" + "---|" * (2 + len(heads))]
    for s in here:
        cells = []
        for name in _SHOWN:
            x = study.mean(s, case, name)
            cells.append(
                "–" if x.value != x.value else f"{_percent(x.value)} ({_percent(x.low)} to {_percent(x.high)})"
            )
        ratio = study.normalised(s, case, "pitch") if BASELINE in here else None
        cells.append("–" if ratio is None else f"{ratio.value:.2f} ({ratio.low:.2f} to {ratio.high:.2f})")
        lines.append(f"| `{s}` | {' | '.join(cells)} |")
    return "\n".join(lines)


def case_table(study: Results, plan: Plan, group: Group, name: str = "pitch") -> str:
    """Return the mean of one score [%], a row for each case of a group, a column for each strategy."""
    cases = [case for case in plan.cases(group) if (group.strategies[0], case.name) in study.scores]
    varied = [key.replace("_", " ") for key in group.vary]
    heads = [*varied, *(f"`{s}`" for s in group.strategies)]
    lines = [f"| {' | '.join(heads)} |", "|" + "---|" * len(heads)]
    for case in cases:
        values = [_told(getattr(case.assumptions, key)) for key in group.vary]
        means = [_percent(study.mean(s, case.name, name).value) for s in group.strategies]
        lines.append(f"| {' | '.join([*values, *means])} |")
    return "\n".join(lines)


def claim_table(judgements: list[Judgement], plan: Plan, cases: Mapping[str, Case]) -> str:
    """Return each claim's verdict, what it depends on, and in how many cases of each group it was confirmed."""
    groups = [group.name for group in plan.groups]
    lines = [f"| # | claim | verdict | {' | '.join(groups)} |", "|" + "---|" * (3 + len(groups))]
    for j in judgements:
        verdict = f"depends on {', '.join(j.depends)}" if j.verdict == "depends" else j.verdict
        shares = []
        for group in groups:
            good, count = j.share(cases, group)
            shares.append(f"{good} of {count}" if count else "–")
        lines.append(f"| {j.claim.key} | {j.claim.statement} | {verdict} | {' | '.join(shares)} |")
    return "\n".join(lines)


def finding_lines(judgements: list[Judgement], case: str) -> str:
    """Return the numbers of each claim in one case, as a list."""
    marks = {CONFIRMED: "confirmed", IN_PART: "in part"}
    lines = []
    for j in judgements:
        if case in j.findings:
            f = j.findings[case]
            lines.append(f"- **{j.claim.key}** {marks.get(f.verdict, f.verdict)}. {f.numbers}.")
    return "\n".join(lines)


def _told(value: object) -> str:
    return f"{value:g}" if isinstance(value, int | float) else str(value) or "–"


def _percent(x: float) -> str:
    return "–" if x != x else (f"{100 * x:.0f}" if x >= 0.0995 else f"{100 * x:.2g}")
