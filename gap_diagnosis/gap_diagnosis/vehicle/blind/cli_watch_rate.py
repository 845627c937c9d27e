"""False alarms of the watch per hour, counted by its own code on healthy vehicles; delays of failures.

Each dive is appended to DIVES.jsonl as it is done: an interrupted count goes on where it stopped.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gap_diagnosis.kept_lines_io import keep_line, kept_lines
from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.blind.watch_hours_io import EFFECTS, Watched, watched_draw
from gap_diagnosis.vehicle.blind.watch_plot_io import draw_delays
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.false_alarms import most_alarms, rate_at, threshold_for
from run_bag.command_line import user_arguments

__all__ = ["main", "said"]

_DIVES, _LOSSES = 12, 3
"""Healthy dives of a vehicle before the next one is drawn; beside each third of them a thruster fails in one, and
something else in another one."""
_MINUTES = 10.0
_LEVELS = ((0.0, 0.5), (0.5, 1.5), (1.5, 3.0), (3.0, 6.0), (6.0, np.inf))


def main(arguments: Sequence[str] | None = None) -> int:
    """Count, or go on with counting; return the exit status."""
    parser = argparse.ArgumentParser(prog="watch_rate", description=__doc__)
    parser.add_argument("dives", type=Path, metavar="DIVES.jsonl", help="what was counted; made or gone on with")
    parser.add_argument("--hours", type=float, default=0.0, help="in all (default: only print what there is)")
    parser.add_argument("--first", type=int, default=2000, help="seed of the first vehicle (default %(default)s)")
    parser.add_argument("--rate", type=float, default=0.1, help="false alarms per hour that are accepted")
    parser.add_argument("--plot", type=Path, metavar="FILE.svg", help="picture of delays against mean thrust")
    given = parser.parse_args(user_arguments(arguments))
    if not given.rate > 0.0:
        print(f"--rate: expected a number above 0; found {given.rate:g}", file=sys.stderr)
        return 1
    try:
        done = kept_lines(given.dives)
    except (OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    place, watched = len([d for d in done if "minutes" in d]), None
    while sum(d.get("hours", 0.0) for d in done) < given.hours:
        seed, run = given.first + place // _DIVES, place % _DIVES
        if watched is None or watched.draw.seed != seed:
            draw = watched_draw(seed)
            watched = Watched(draw, load_model(draw.vehicle))
        of = {"seed": seed, "run": run, "vehicle": watched.draw.vehicle}
        failing = place // _LOSSES
        dives = [watched.loss(failing), watched.failure(failing)] if run % _LOSSES == 0 else []
        for each in (*dives, watched.healthy(run, _MINUTES)):  # the healthy one last: it tells that all is done
            dive = {**of, **each}
            keep_line(given.dives, dive)
            done.append(dive)
        place += 1
        print(
            f"{sum(d.get('hours', 0.0) for d in done):.2f} h, vehicle {seed}, dive {run}", file=sys.stderr, flush=True
        )
    print(said(done, given.rate))
    if given.plot is not None:
        threshold = _threshold(done, given.rate)
        lost = [(d["kind"], d["thrust"], _delay(d["ratios"], threshold)) for d in _once(done, "thrust")]
        draw_delays(given.plot, lost, threshold)
        print(given.plot)
    return 0


def _threshold(done: Sequence[dict[str, Any]], rate: float) -> float:
    """Return the threshold for a rate where the count tells one, else the one that stands in the rules."""
    healthy = [d for d in done if "minutes" in d]
    try:
        return threshold_for(rate, [p for d in healthy for p in d["minutes"]], sum(d["hours"] for d in healthy))
    except ValueError:
        return rules.WATCH_THRESHOLD


def said(done: Sequence[dict[str, Any]], rate: float) -> str:
    """Return the tables of what was counted."""
    healthy = [d for d in done if "minutes" in d]
    hours, peaks = sum(d["hours"] for d in healthy), [p for d in healthy for p in d["minutes"]]
    if not healthy:
        return "nothing was counted yet"
    vehicles = len({d["seed"] for d in healthy})
    lines = [f"{hours:.1f} h of {vehicles} healthy vehicles.", ""]
    lines += [
        "| threshold | minutes with an alarm | per hour (tail beyond the count) | excluded at 95 %: more than |",
        "|---|---|---|---|",
    ]
    try:
        wanted = threshold_for(rate, peaks, hours)
        levels = sorted({14.0, rules.WATCH_THRESHOLD, round(wanted, 1)})
        lines.insert(1, f"For {rate:g} false alarms per hour: threshold {wanted:.1f}.")
    except ValueError as error:
        wanted, levels = rules.WATCH_THRESHOLD, [14.0, rules.WATCH_THRESHOLD]
        lines.insert(1, f"No threshold for {rate:g} per hour: {error}.")
    for level in levels:
        counted = sum(p >= level for p in peaks)
        lines.append(
            f"| {level:g} | {counted} | {rate_at(level, peaks, hours):.2g} | {most_alarms(counted, hours):.2g} |"
        )
    lines += ["", f"Loss of 30 %, at the threshold {wanted:.1f}:", "", *_table("mean thrust of it [N]")]
    for low, high in _LEVELS:
        name = f"{low:g} to {high:g}" if np.isfinite(high) else f"above {low:g}"
        lines += _row(name, [d for d in _once(done, "thrust") if low <= d["thrust"] < high], wanted)
    lines += ["", f"What else fails, at the threshold {wanted:.1f}:", "", *_table("what")]
    for name in EFFECTS:
        lines += _row(name, [d for d in _once(done, "failure") if d["failure"] == name], wanted)
    return "\n".join(lines)


def _once(done: Sequence[dict[str, Any]], key: str) -> list[dict[str, Any]]:
    """Return the dives that have this key, each once: an interrupted count may have begun with them anew."""
    return list({(d["seed"], d["run"]): d for d in done if key in d}.values())


def _table(first: str) -> list[str]:
    return [
        f"| {first} | dives | found in 10 s | found in 60 s | median delay [s] | another one ahead when found |",
        "|---|---|---|---|---|---|",
    ]


def _row(name: str, dives: Sequence[dict[str, Any]], threshold: float) -> list[str]:
    """Return the row of these dives, none where there are none."""
    if not dives:
        return []
    delays = [_delay(d["ratios"], threshold) for d in dives]
    middle = float(np.median(delays))
    told = f"{middle:.0f}" if np.isfinite(middle) else "not found"
    soon, found = sum(x <= 10.0 for x in delays), sum(np.isfinite(x) for x in delays)
    ahead = sum(_misled(d["ratios"], d["others"], threshold) for d in dives)
    return [f"| {name} | {len(dives)} | {soon} | {found} | {told} | {ahead} |"]


def _misled(own: Sequence[float], others: Sequence[float], threshold: float) -> bool:
    """Return whether something else is ahead when the first of them reaches the threshold."""
    first = next(((a, b) for a, b in zip(own, others, strict=True) if max(a, b) >= threshold), None)
    return first is not None and first[1] > first[0]


def _delay(ratios: Sequence[float], threshold: float) -> float:
    """Return the seconds until the threshold is reached, infinity where it is not."""
    return next((float(k + 1) for k, r in enumerate(ratios) if r >= threshold), np.inf)


if __name__ == "__main__":
    sys.exit(main())
