"""A maker's table of forces over command and supply voltage becomes one of ours, checked and reported.

With --set it becomes a parameter set of the model `force_table` too, which plant, fit and inner loop take.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from run_bag.command_line import user_arguments
from run_bag.importers.decisions import source
from thruster_model.errors import ThrusterModelError
from thruster_model.force_table import ForceTable
from thruster_model.force_table_io import load_force_table, write_force_table
from thruster_model.force_table_map_io import read_column_map
from thruster_model.force_table_quality import drops, left_out, monotone
from thruster_model.force_table_report_io import build_report
from thruster_model.force_table_set import ASSUMED_LAG, parameter_set_of
from thruster_model.force_table_sheets_io import read_force_table
from thruster_model.parameter_set_io import write_parameter_set


def main(arguments: Sequence[str] | None = None) -> int:
    """Read, print, write table and report; return the exit status."""
    given = _parser().parse_args(user_arguments(arguments))
    page = given.out.with_suffix(".html")
    made = [given.out, *([page] if given.report else []), *([given.set] if given.set else [])]
    try:
        if len(set(made)) < len(made):
            raise ValueError(f"--out {given.out}: expected another name than that of the set or the report, {page}")
        for path in made:
            if path.exists():
                raise FileExistsError(f"{path}: exists and is not overwritten")
        if given.set is None and (given.nominal_supply or given.lag):
            raise ValueError("--nominal-supply and --lag: expected with --set, of which they are numbers")
        sources = [given.file, *([given.map] if given.map else [])]
        table = read_force_table(given.file, read_column_map(given.map)) if given.map else load_force_table(given.file)
        lines = summary(table)
        if given.monotone:
            table = monotone(table)
        if given.report:
            provenance = {"sources": [source(each) for each in sources], "monotone": given.monotone}
            build_report(table, provenance).write(page)
        write_force_table(table, given.out)
        if given.set:
            parameters = parameter_set_of(table, nominal_supply=given.nominal_supply, lag=given.lag)
            write_parameter_set(parameters, given.set)
            command = parameters.command
            lines.append(
                f"throttle u [V] = (command - {command.stop:g} {command.unit}) / {command.per_volt:g}; "
                f"in a map of import_recording: unit: {command.unit}, stop: {command.stop!r}, "
                f"per_volt: {command.per_volt!r}"
            )
    except (ThrusterModelError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    print("\n".join(lines))
    for path in made:
        print(path.resolve())
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="force_table", description=__doc__)
    parser.add_argument(
        "file", type=Path, metavar="FILE", help="the maker's csv or xlsx; without --map a table of ours"
    )
    columns = "what its columns are; an example is config/t200_columns.yaml of this package"
    parser.add_argument("--map", type=Path, metavar="MAP.yaml", help=columns)
    parser.add_argument(
        "--out", type=Path, required=True, metavar="TABLE.yaml", help="the table to write; must not exist"
    )
    parser.add_argument(
        "--set", type=Path, metavar="SET.yaml", help="write a parameter set of the model `force_table` too"
    )
    parser.add_argument(
        "--nominal-supply",
        type=_positive,
        metavar="V",
        help="supply that counts as nominal in the set (default: middle)",
    )
    said = f"time constant of the rotor in the set (default {ASSUMED_LAG:g} s, assumed: the table has no time)"
    parser.add_argument("--lag", type=_positive, metavar="S", help=said)
    parser.add_argument("--report", action="store_true", help="write an HTML report beside the table")
    parser.add_argument(
        "--monotone", action="store_true", help="remove dips of the measured force (isotonic regression)"
    )
    return parser


def _positive(text: str) -> float:
    value = float(text)
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"expected a finite number above 0; found {text}")
    return value


def summary(table: ForceTable) -> list[str]:
    """Return what the terminal says of a table as it was read."""
    unit = table.command_unit
    kinds = ", ".join(table.quantities)
    count = "one supply voltage" if table.supply.size == 1 else f"{table.supply.size} supply voltages"
    lines = [f"{table.name}: {count}, {table.command.size} commands, {kinds}"]
    bands, forces = table.zero_band(table.supply), table.largest_forces(table.supply)
    for v, low, high, reverse, forward in zip(table.supply, *bands, *forces, strict=True):
        lines.append(f"{v:g} V: no force from {low:g} to {high:g} {unit}; largest {forward:+.1f} / {reverse:+.1f} N")
    for m in left_out(table):
        lines.append(
            f"{m.supply:g} V left out and interpolated: RMSE {m.rmse:.2f} N, largest error {m.largest:+.2f} N at "
            f"{m.command:g} {unit}"
        )
    falls = drops(table)
    if falls:
        worst = max(falls, key=lambda d: d.force - d.next_force)
        lines.append(
            f"the force falls {len(falls)} times though the command rises, by at most "
            f"{worst.force - worst.next_force:.2f} N (at {worst.supply:g} V, {worst.next_command:g} {unit})"
        )
    return lines


if __name__ == "__main__":
    sys.exit(main())
