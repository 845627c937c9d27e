"""The size of one effect over dives of a vehicle, with intervals, a line through it and a plot."""

import argparse
import json
import sys
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import plotly.graph_objects as go

from gap_diagnosis.vehicle.arguments_io import add_sets
from gap_diagnosis.vehicle.conventions import conventions_of
from gap_diagnosis.vehicle.diagnosis_io import load_model, names_of, provenance_of
from gap_diagnosis.vehicle.hypotheses import Hypothesis
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.log_io import read_logs
from gap_diagnosis.vehicle.trend import Line, Size, followed, line_of, size_in
from run_bag import RunError
from run_bag.command_line import user_arguments
from run_bag.report import Report
from safe_files.whole_files_io import expect_new_folder, new_folder, write_whole
from thruster_model.errors import ThrusterModelError

__all__ = ["main"]

_DAY = 86400e9
_DATED = 946684800e9
"""[ns] The year 2000: stamps before it are no dates."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Follow an effect over dives; return the exit status."""
    parser = argparse.ArgumentParser(prog="trend", description=__doc__)
    parser.add_argument("dives", nargs="+", type=Path, metavar="DIVE", help="a run each, in order; three or more")
    add_sets(parser)
    parser.add_argument("--effect", default="thrust_loss", help="that is followed (default %(default)s)")
    place = parser.add_mutually_exclusive_group()
    place.add_argument("--thruster", metavar="NUMBER", help='that it acts on, counted from 0; "all": all at once')
    place.add_argument("--axis", help="that it acts on")
    parser.add_argument("--limit", type=float, help="size for which the line's time is told")
    parser.add_argument("--out", type=Path, default=Path("trend"), help="new or empty folder")
    given = parser.parse_args(user_arguments(arguments))
    try:
        expect_new_folder(given.out)
        if len(given.dives) < 3:
            raise ValueError(f"trend: expected three dives or more; found {len(given.dives)}")
        model = load_model(given.vehicle, given.set, given.sensors)
        logs, model = read_logs(given.dives, model)
        thruster, every = _thruster(given.thruster)
        h = followed(model, logs, given.effect, thruster, given.axis, every=every)
        words, names = f"{h.words} of all thrusters" if every else h.words, names_of(given.dives)
        times, unit = _times(logs)
        sizes = []
        for name, log, time in zip(names, logs, times, strict=True):
            conventions = conventions_of(model, [log])
            for sentence in conventions.turned:
                print(f"{name}: {sentence}", file=sys.stderr)
            size, deviation = size_in(model, conventions.read(log), h)
            sizes.append(Size(time=time, size=size, deviation=deviation))
            print(f"{name}: {size:.3g} ± {deviation:.2g}", file=sys.stderr, flush=True)
        line = line_of(sizes)
        provenance = provenance_of(given.dives, model)
        said = _said(words, line, unit, sizes, given.limit)
        content = {
            "summary": said, "effect": h.effect, "thruster": h.thruster, "axis": h.axis, "time_unit": unit,
            "dives": [{"name": n, **vars(s)} for n, s in zip(names, sizes, strict=True)],
            "line": vars(line), "rises": line.rises, "provenance": provenance,
        }  # fmt: skip
        report = _report(h, words, sizes, line, unit, said, provenance)
        with new_folder(given.out) as folder:
            report.write(folder / "report.html")
            write_whole(folder / "trend.json", json.dumps(content, indent=1))
    except (RunError, ThrusterModelError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted: nothing was written", file=sys.stderr)
        return 130
    print(said)
    print(given.out / "report.html")
    print(given.out / "trend.json")
    return 0


def _thruster(given: str | None) -> tuple[int | None, bool]:
    """Return the thruster, None: none, and whether all were named.

    Raises:
        ValueError: neither a number nor "all".
    """
    if given in (None, "all"):
        return None, given == "all"
    try:
        return int(str(given)), False
    except ValueError:
        raise ValueError(f"--thruster: expected a number from 0 on, or all; found {given}") from None


def _times(logs: Sequence[VehicleLog]) -> tuple[list[float], str]:
    """Return when the dives were: days since the first, or their number where stamps are no dates or go back."""
    starts = [log.start for log in logs]
    if all(s > _DATED for s in starts) and all(b > a for a, b in pairwise(starts)):
        return [(s - starts[0]) / _DAY for s in starts], "day"
    return [float(k) for k in range(len(logs))], "dive"


def _said(words: str, line: Line, unit: str, sizes: Sequence[Size], limit: float | None) -> str:
    last, deviation = line.at(sizes[-1].time)
    name = f"{words[0].upper()}{words[1:]}"
    if not line.rises:
        return (
            f"{name} shows no trend over {len(sizes)} dives: {line.slope:+.2g} ± {line.slope_deviation:.2g} a {unit}, "
            f"{line.level:.3g} ± {line.level_deviation:.2g} on average."
        )
    says = (
        f"{name} changes by {line.slope:+.2g} ± {line.slope_deviation:.2g} a {unit}, to {last:.3g} ± {deviation:.2g}."
    )
    when = None if limit is None else line.reaches(limit)
    if limit is not None:
        says += f" The line does not come to {limit:g}." if when is None else ""
    if when is not None:
        says += f" At this rate it is {limit:g} at {unit} {when:.3g}, counted from the first."
    return says


def _report(
    h: Hypothesis, words: str, sizes: Sequence[Size], line: Line, unit: str, said: str, provenance: dict[str, Any]
) -> Report:  # fmt: skip
    report = Report(f"Trend of {words}", f"{len(sizes)} dives", provenance)
    report.section("Answer")
    report.paragraph(said)
    if line.scatter > 2.0:
        report.warning(
            f"Sizes scatter {line.scatter:.1f} times as much as their deviations say: something else changes from dive "
            "to dive; the line's deviations are that much larger."
        )
    t = [s.time for s in sizes]
    figure = go.Figure()
    figure.add_trace(
        go.Scatter(
            x=t, y=[s.size for s in sizes], error_y={"type": "data", "array": [1.645 * s.deviation for s in sizes]},
            mode="markers", name="size, 90 %",
        )
    )  # fmt: skip
    ends = [t[0], t[-1]]
    figure.add_trace(go.Scatter(x=ends, y=[line.at(x)[0] for x in ends], mode="lines", name="line"))
    symbol = h.parameters[0]
    figure.update_layout(xaxis_title=f"time [{unit}]", yaxis_title=symbol)
    report.figure(figure, caption="The size in each dive with its 90 % interval, and the line.", alt=said)
    report.table(
        [f"time [{unit}]", symbol, "±"], [[s.time, s.size, s.deviation] for s in sizes], caption="Sizes by dive."
    )
    return report


if __name__ == "__main__":
    sys.exit(main())
