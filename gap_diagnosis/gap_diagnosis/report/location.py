"""Where the gap lies: blocks, regimes and channels, and single equations fed with measurements."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.report.wording import BLOCKS, RETUNED, WITH_EFFECT, number, roomy, signal_of
from gap_diagnosis.where import BlockCheck, excess_by_regime
from run_bag.report import Axis, Bars, Cell, Column, Plot, Report, bars, heat_map
from thruster_model.identification.experiment import SIGNALS

__all__ = ["add_where"]

_EXCESS = Axis(name="RMS over noise − 1", unit="–")
_RIGHT = 1.1  # times the noise, up to which a free run has no gap
_EASED, _KEPT = 0.5, 0.9  # of the excess: below, the gap comes in with the input; above, it does not
_INPUT, _EQUATION = "the gap comes in with its input", "the equation or the sensor of its output"


def add_where(report: Report, found: Diagnosis, content: Mapping[str, Any]) -> None:
    """Add shares of the blocks, excess by regime and channel, checks of single blocks."""
    report.section("Where")
    if content["where"]:
        shares = {each["block"]: each["share"] for each in content["where"]}
        order = sorted(BLOCKS, key=lambda block: -shares.get(block, 0.0))
        labels = [BLOCKS[block] for block in order]
        report.figure(
            roomy(
                bars(
                    labels,
                    [Bars(name="share", value=[shares.get(block, 0.0) for block in order])],
                    quantity=Axis(name="share of the gap", unit="–"),
                ),
                labels,
            ),
            caption="Shares of the blocks: hypotheses weighed by their probability, each in its own block; what is "
            "unknown by the blocks in which a nameless disturbance would explain most.",
            alt="; ".join(f"{block} {share:.2f}" for block, share in shares.items()),
        )
    else:
        report.paragraph("No block has a share: there is no gap beyond what re-tuned parameters explain.")
    _regimes(report, found)
    _checks(report, found, content)


def _regimes(report: Report, found: Diagnosis) -> None:
    if not found.by_regime or found.problem is None or found.investigation is None:
        report.paragraph("No regime of operation holds enough samples to be judged by itself.")
        return
    tables = {RETUNED: found.by_regime}
    chosen = found.verdict.chosen
    if found.verdict.verdict == "effect" and chosen is not None:
        fitted = chosen.fitted
        tables[WITH_EFFECT] = excess_by_regime(fitted.problem, found.investigation.noise, fitted)
    signals = [s for s in SIGNALS if any(s in row for row in found.by_regime.values())]
    regimes = list(found.by_regime)
    grids = {name: _grid(table, regimes, signals) for name, table in tables.items()}
    limit = max(0.5, *(float(np.nanmax(np.abs(grid))) for grid in grids.values()))
    columns = [SIGNALS[s].title for s in signals]
    report.figure(
        [_map(grid, columns, regimes, limit) for grid in grids.values()],
        caption=f"Excess of the error over the noise by regime and channel, {' (left) and '.join(grids)}"
        f"{' (right)' if len(grids) > 1 else ''}: 0 is noise alone, 1 is an error twice the noise. Regimes overlap. "
        + (f"Largest in: {found.regime}." if found.regime not in ("", "all alike") else "No regime stands out."),
        alt=f"Matrix of the excess over the noise, one row for each regime. Largest in: {found.regime or 'none'}.",
    )


def _grid(table: Mapping[str, Mapping[str, float]], regimes: list[str], signals: list[str]) -> NDArray[np.float64]:
    mean_squares = [[1.0 + table.get(regime, {}).get(s, np.nan) for s in signals] for regime in regimes]
    return np.asarray(np.round(np.sqrt(np.maximum(mean_squares, 0.0)) - 1.0, 2) + 0.0)


def _map(grid: NDArray[np.float64], columns: list[str], regimes: list[str], limit: float) -> Plot:
    plot = heat_map(grid, columns=columns, rows=regimes, quantity=_EXCESS, limit=limit)
    ends = [-limit, 0.0, limit]  # few ticks: more would run into the title of the scale
    plot.figure.update_traces(colorbar={"tickvals": ends, "ticktext": [number(end, 2) for end in ends]})
    return plot


def _checks(report: Report, found: Diagnosis, content: Mapping[str, Any]) -> None:
    if not found.checks:
        return
    free = {signal_of(channel): errors for channel, errors in content["gap"]["channels"].items()}
    rows: list[list[object]] = []
    for check in found.checks:
        run = free.get(check.output)
        alone = run["retuned"] / run["noise_floor"] if run else None
        reading = _reading(check, alone)
        wrong = reading == _EQUATION
        rows.append(
            [
                SIGNALS[check.output].title if check.output in SIGNALS else check.output,
                check.block,
                check.inputs,
                alone,
                Cell(check.error, "worse") if wrong else check.error,
                Cell(reading, "emphasis") if wrong else reading,
            ]
        )
    report.table(
        [
            "Output",
            "Block",
            "Fed with",
            Column(name=f"Free run, {RETUNED}", format=".2f"),
            Column(name="So fed", format=".2f"),
            "Which says",
        ],
        rows,
        caption="Single equations (re-tuned), fed with measured in place of simulated inputs: errors over the noise.",
        notes=[
            "So fed, the noise of the measured input adds to the error: a right equation may stand a little above 1."
        ],
    )


def _reading(check: BlockCheck, alone: float | None) -> str:
    if alone is None or alone < _RIGHT:
        return "no gap to place"
    if check.inputs == "throttle":
        return "nothing upstream is measured"
    kept = (check.error**2 - 1.0) / (alone**2 - 1.0)
    if check.error < _RIGHT or kept < _EASED:
        return _INPUT
    return _EQUATION if kept > _KEPT else "undecided"
