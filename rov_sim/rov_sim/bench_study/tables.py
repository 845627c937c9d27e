"""Tables in Markdown: normalised errors, statements by study, and how far real scores are predicted."""

from collections.abc import Mapping, Sequence

import numpy as np

from rov_sim.bench_study.claims import judged
from rov_sim.bench_study.prediction import Prediction
from rov_sim.bench_study.real_runs import MeasuredDisturbances, RealRun, RecoveredMap, real_score
from rov_sim.study.results import BASELINE, Results

__all__ = ["claim_tables", "disturbance_lines", "error_table", "prediction_table", "real_table", "run_table"]


def error_table(study: Results) -> str:
    """Return RMSE and normalised RMSE of each strategy and set point, with 90 % intervals."""
    heads = [f"{r}: RMSE [N] | over lookup" for r in study.references]
    lines = [f"| strategy | {' | '.join(heads)} |", "|" + "---|" * (1 + 2 * len(heads))]
    for s in study.strategies:
        cells = []
        for r in study.references:
            mean = study.mean(s, r, "rmse")
            cells.append(f"{mean.value:.2f} ({mean.low:.2f} to {mean.high:.2f})")
            ratio = study.normalised(s, r) if BASELINE in study.strategies else None
            cells.append("–" if ratio is None else f"{ratio.value:.2f} ({ratio.low:.2f} to {ratio.high:.2f})")
        lines.append(f"| `{s}` | {' | '.join(cells)} |")
    return "\n".join(lines)


def claim_tables(studies: Mapping[str, Results], without_spikes: Mapping[str, Results]) -> str:
    """Return the verdict of each statement in each study, and the numbers of the first."""
    found = {name: judged(study, without_spikes.get(name)) for name, study in studies.items()}
    lines = [f"| statement | {' | '.join(found)} |", "|" + "---|" * (1 + len(found))]
    first = next(iter(found.values()))
    for k, claim in enumerate(first):
        lines.append(f"| {claim.statement} | {' | '.join(each[k].verdict for each in found.values())} |")
    lines += ["", *(f"- **{c.statement}**: {c.verdict}. {c.numbers}." for c in first)]
    return "\n".join(lines)


def disturbance_lines(measured: MeasuredDisturbances, logged: RecoveredMap) -> str:
    """Return what was measured on the recordings and the controllers' input map, as lines of a list."""
    m, gamma = measured, logged.input_map
    return "\n".join(
        [
            f"- tachometer {m.speed_noise:.2f} rad/s; flow {1e3 * m.flow_noise:.1f} mm/s; load cell, mean over a "
            f"period, {m.load_noise:.2f} N",
            f"- spikes: {100 * m.spike_share:.1f} % of {m.flow_samples} samples, {m.spike_size:.2f} m/s rms",
            f"- controllers' input map: c_u1 {gamma.c_u1:.2f}, c_u2 {gamma.c_u2:.2f} 1/(V s^2), delta_u1 "
            f"{gamma.delta_u1:.4f}, delta_u2 {gamma.delta_u2:.4f} V; the law with it leaves at most "
            f"{1e6 * logged.largest_remainder:.0f} µV of u unexplained over {logged.samples} samples",
        ]
    )


def real_table(runs: Sequence[RealRun]) -> str:
    """Return the real scores."""
    lines = ["| recording | strategy | set point | RMSE [N] | window as matched [N] | largest [N] |", "|" + "---|" * 6]
    for run in runs:
        score, matched = real_score(run), real_score(run, matched=True)
        cells = [f"{score.rmse:.2f}", f"{matched.rmse:.2f}", f"{score.largest:.1f}"]
        lines.append(f"| {run.name} | `{run.strategy}` | {run.reference} | {' | '.join(cells)} |")
    return "\n".join(lines)


def prediction_table(found: Mapping[tuple[str, float, str], Prediction]) -> str:
    """Return how far real scores are predicted, by (plant, deviation, variant)."""
    heads = "| plant | deviation | variant | Spearman ρ (90 %) | p | RMSE [N] | within 5 to 95 % |"
    lines = [heads, "|" + "---|" * 7]
    for (plant, deviation, name), p in found.items():
        c = p.correlation
        cells = [f"{c.rho:+.2f} ({c.low:+.2f} to {c.high:+.2f})", f"{c.p_value:.2f}", f"{p.rmse:.2f}"]
        lines.append(f"| {plant} | {100 * deviation:g} % | {name} | {' | '.join(cells)} | {p.inside} of {c.pairs} |")
    all_others, alike = next(iter(found.values())).constants
    words = (
        f"The mean of the other recordings misses a real score by {all_others:.2f} N, that of those with the same set"
    )
    return "\n".join([*lines, "", f"{words} point by {alike:.2f} N (root mean squares)."])


def run_table(runs: Sequence[RealRun], found: Mapping[str, Prediction]) -> str:
    """Return real and simulated score of each run, one column for each prediction by its title."""
    lines = [f"| recording | real [N] | {' | '.join(found)} |", "|" + "---|" * (2 + len(found))]
    for i, run in enumerate(runs):
        cells = []
        for p in found.values():
            low, high = np.percentile(p.simulated[i], (5.0, 95.0))
            cells.append(f"{np.mean(p.simulated[i]):.2f} ({low:.2f} to {high:.2f})")
        lines.append(f"| {run.name} | {real_score(run).rmse:.2f} | {' | '.join(cells)} |")
    return "\n".join(lines)
