"""A table of steady states held against a parameter set."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.steady_states import FEWEST, SteadyDiagnosis, diagnose_steady_states
from run_bag.command_line import user_arguments
from thruster_model.errors import ThrusterModelError, UnfitDataError
from thruster_model.identification.experiment import SIGNALS
from thruster_model.parameter_set_io import load_parameter_set

__all__ = ["main"]

_RPM = np.pi / 30.0  # rad/s
_WORDS = {
    "no_gap": "The parameters as stated predict the table to within the deviations.",
    "parameters": "Re-tuning within the stated deviations closes the gap.",
    "effect": "One effect explains the table.",
    "cannot_tell": "Several effects explain the table alike: steady states cannot tell them apart.",
    "unknown": "No single effect explains the table to within the deviations.",
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Print what the table says, as Markdown; return the exit status."""
    parser = argparse.ArgumentParser(prog="steady_states", description=__doc__)
    parser.add_argument("table", type=Path, metavar="TABLE.csv", help="rows of numbers, without a header")
    parser.add_argument(
        "--set", "--model", dest="set", required=True, metavar="SET", help="parameter set: its name or YAML file"
    )
    parser.add_argument(
        "--columns", required=True, help="throttle, speed, rpm, axial, ambient, thrust, torque, or - for others; commas"
    )
    parser.add_argument(
        "--deviation", action="append", default=[], metavar="SIGNAL=STD", help="of its readings, SI units; repeatable"
    )
    given = parser.parse_args(user_arguments(arguments))
    try:
        parameter_set = load_parameter_set(given.set)
        columns = _columns(given.table, given.columns.split(","))
        deviations = dict(map(_deviation, given.deviation))
        throttle = columns.pop("throttle")
        found = diagnose_steady_states(throttle, columns, deviations, parameter_set, _told)
    except (ThrusterModelError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130
    print("\n".join(_lines(found)))
    return 0


def _told(stage: str) -> None:
    print(f"[steady states] {stage}", file=sys.stderr)


def _columns(path: Path, names: Sequence[str]) -> dict[str, NDArray[np.float64]]:
    """Return the named columns in SI units.

    Raises:
        UnfitDataError: rows that are no numbers, another number of columns, names that are unknown or given twice.
    """
    try:
        rows = np.loadtxt(path, delimiter=",", ndmin=2, encoding="utf-8")
    except ValueError as error:
        raise UnfitDataError([f"{path}: expected rows of numbers; {error}"]) from error
    known = ("throttle", "rpm", *SIGNALS, "-")
    problems = [f"--columns: expected one of {', '.join(known)}; found {name!r}" for name in names if name not in known]
    if len(names) != rows.shape[1]:
        problems.append(f"--columns: expected {rows.shape[1]} names, one for each column of {path}; found {len(names)}")
    taken = ["speed" if name == "rpm" else name for name in names if name != "-"]
    problems += [f"--columns: {name} is given more than once" for name in sorted(set(taken)) if taken.count(name) > 1]
    if "throttle" not in taken:
        problems.append("--columns: expected a column throttle; found none")
    if problems:
        raise UnfitDataError(problems)
    used = [(name, rows[:, place]) for place, name in enumerate(names) if name != "-"]
    return {("speed" if name == "rpm" else name): values * (_RPM if name == "rpm" else 1.0) for name, values in used}


def _deviation(word: str) -> tuple[str, float]:
    name, _, value = word.partition("=")
    try:
        return name, float(value)
    except ValueError as error:
        raise UnfitDataError([f"--deviation: expected SIGNAL=STD with a number; found {word!r}"]) from error


def _lines(found: SteadyDiagnosis) -> list[str]:
    signals = list(found.stated)
    heads = [f"{SIGNALS[s].symbol} [{SIGNALS[s].unit}] measured | stated | re-tuned" for s in signals]
    lines = ["| u [V] | " + " | ".join(heads) + " |", "|---" * (1 + 3 * len(signals)) + "|"]
    for k, u in enumerate(found.throttle):
        cells = [_number(each[s][k]) for s in signals for each in (found.measured, found.stated, found.retuned)]
        lines.append(f"| {u:g} | " + " | ".join(cells) + " |")
    few = found.verdict == "cannot_tell" and len(found.equals) == 1
    said = f"Fewer than {FEWEST} readings: no effect is claimed on them." if few else _WORDS[found.verdict]
    lines += ["", f"`{found.verdict}`. {said}"]
    costs = f"{found.costs[0]:.1f} as stated, {found.costs[1]:.1f} re-tuned"
    lines.append(f"Sum of squares over {found.count} readings, in their deviations: {costs}.")
    lines += ["", "| effect | size | evidence (log) | sum of squares |", "|---|---|---|---|"]
    for each in found.explanations:
        sizes = ", ".join(f"{name} {value:.3g} ± {std:.2g}" for name, (value, std) in each.sizes.items())
        lines.append(f"| `{each.effect}` | {sizes} | {each.evidence:.1f} | {each.cost:.1f} |")
    return lines


def _number(value: float) -> str:
    return "0" if abs(value) < 1e-9 else f"{value:.4g}"


if __name__ == "__main__":
    sys.exit(main())
