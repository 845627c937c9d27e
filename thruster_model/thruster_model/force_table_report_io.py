"""The report of a table of forces: its curves, zero bands and largest forces, and how far interpolation misses."""

from collections.abc import Mapping

from run_bag.report import Axis, Column, Report, Series, curves
from thruster_model.force_table import QUANTITIES, ForceTable
from thruster_model.force_table_io import dump_force_table
from thruster_model.force_table_quality import drops, left_out

__all__ = ["build_report"]

_TITLES = {"force": ("Force", "T"), "speed": ("Rotor speed", "n"), "current": ("Current", "I"), "power": ("Power", "P")}


def build_report(table: ForceTable, provenance: Mapping[str, object]) -> Report:
    """Return the report of a table."""
    report = Report("Table of forces", table.name, provenance)
    report.warning("Measured at a standstill: the table knows neither flow nor time.")
    falls = drops(table)
    if falls:
        worst = max(d.force - d.next_force for d in falls)
        report.warning(
            f"The force is not monotone: it falls {len(falls)} times between neighbouring commands, by at most "
            f"{worst:.3g} N. The inverse takes the command nearest the stop."
        )
    report.section("Curves")
    x = Axis(name="Command", unit=table.command_unit, symbol="c")
    for quantity in table.quantities:
        word, symbol = _TITLES[quantity]
        series = [
            Series(name=f"{v:g} V", x=table.command, y=row, color=m)
            for m, (v, row) in enumerate(zip(table.supply, getattr(table, quantity), strict=True))
        ]
        report.figure(
            curves(series, x=x, y=Axis(name=word, unit=QUANTITIES[quantity], symbol=symbol), height=420),
            caption=f"{word} over the command at each measured supply voltage.",
            alt=f"{word} over the command, one curve for each of {table.supply.size} supply voltages.",
        )
    report.section("Zero band and largest forces")
    unit = table.command_unit
    low, high = table.zero_band(table.supply)
    reverse, forward = table.largest_forces(table.supply)
    heads: list[Column | str] = [Column(name="Supply", unit="V"), Column(name="Zero from", unit=unit)]
    heads += [Column(name="Zero to", unit=unit), Column(name="Largest in reverse", unit="N")]
    heads.append(Column(name="Largest forward", unit="N"))
    numbers = zip(table.supply, low, high, reverse, forward, strict=True)
    rows: list[list[object]] = [list(map(float, row)) for row in numbers]
    notes = ["First and last measured command without force: the thruster's own edge is up to one node further out."]
    report.table(heads, rows, caption="The band without force, and the largest forces.", notes=notes)
    missed = left_out(table)
    if missed:
        report.section("Between the measured voltages")
        heads = [Column(name="Supply left out", unit="V"), Column(name="RMSE", unit="N", digits=3)]
        heads += [Column(name="Largest error", unit="N", digits=3), Column(name="at the command", unit=unit)]
        rows = [[m.supply, m.rmse, m.largest, m.command] for m in missed]
        report.table(
            heads,
            rows,
            caption="Force at a measured voltage, predicted by linear interpolation between its two neighbours.",
            notes=["Positive: predicted too high. In the full table the neighbours are half as far apart."],
        )
    if falls:
        report.section("Where the force falls")
        heads = [Column(name="Supply", unit="V"), Column(name="From", unit=unit), Column(name="To", unit=unit)]
        heads += [Column(name="Force", unit="N"), Column(name="Force after", unit="N")]
        report.table(heads, [list(d) for d in falls], caption="Neighbouring commands of which the larger gives less.")
    report.section("Files")
    report.download("Table", "force_table.yaml", dump_force_table(table))
    return report
