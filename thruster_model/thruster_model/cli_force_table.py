"""Command line: a maker's table of forces over command and supply voltage becomes one of ours, checked and reported."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from run_bag.command_line import user_arguments
from run_bag.importers.decisions import source
from thruster_model.errors import ThrusterModelError
from thruster_model.force_table import ForceTable
from thruster_model.force_table_io import write_force_table
from thruster_model.force_table_map_io import read_column_map
from thruster_model.force_table_quality import drops, left_out, monotone
from thruster_model.force_table_report_io import build_report
from thruster_model.force_table_sheets_io import read_force_table


def main(arguments: Sequence[str] | None = None) -> int:
    """Read, print, write table and report; return the exit status."""
    given = _parser().parse_args(user_arguments(arguments))
    page = given.out.with_suffix(".html")
    try:
        if given.report and page == given.out:
            raise ValueError(f"--out {given.out}: expected another ending than the report's .html")
        for path in (given.out, page) if given.report else (given.out,):
            if path.exists():
                raise FileExistsError(f"{path}: exists and is not overwritten")
        table = read_force_table(given.file, read_column_map(given.map))
        lines = summary(table)
        if given.monotone:
            table = monotone(table)
        if given.report:
            provenance = {"sources": [source(given.file), source(given.map)], "monotone": given.monotone}
            build_report(table, provenance).write(page)
        write_force_table(table, given.out)
    except (ThrusterModelError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    print("\n".join(lines))
    for path in (given.out, page) if given.report else (given.out,):
        print(path.resolve())
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="force_table", description=__doc__)
    parser.add_argument("file", type=Path, metavar="FILE", help="the maker's csv or xlsx")
    columns = "what its columns are; an example is config/t200_columns.yaml of this package"
    parser.add_argument("--map", type=Path, required=True, metavar="MAP.yaml", help=columns)
    parser.add_argument(
        "--out", type=Path, required=True, metavar="TABLE.yaml", help="the table to write; must not exist"
    )
    parser.add_argument("--report", action="store_true", help="write an HTML report beside the table")
    parser.add_argument(
        "--monotone", action="store_true", help="remove dips of the measured force (isotonic regression)"
    )
    return parser


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
