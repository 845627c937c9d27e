"""Hide effects in recordings of vehicles from a generator of its own, diagnose them, open the seals.

Cases are appended to CASES.jsonl one by one: an interrupted check goes on where it stopped.
"""

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gap_diagnosis.kept_lines_io import keep_line, kept_lines
from gap_diagnosis.vehicle.blind.draws import drawn
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.blind.scoring import differences, scored, table
from gap_diagnosis.vehicle.diagnosis_io import diagnosed, load_model
from gap_diagnosis.vehicle.log_io import read_logs
from run_bag import write_run
from run_bag.command_line import user_arguments

__all__ = ["FROZEN", "TUNING", "main"]

TUNING = 2000
"""Seeds below it were looked at while rules were set; those from it on are reported."""
FROZEN = {
    1500: "one", 1501: "none", 1502: "one", 1503: "outside", 1504: "one", 1505: "pair", 1506: "one", 1507: "none",
    1508: "one", 1509: "outside", 1510: "one", 1511: "one",
}  # fmt: skip
"""Seeds and kinds of the cases that each change is tried on."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run or go on with a check; return the exit status."""
    parser = argparse.ArgumentParser(prog="blind_vehicle", description=__doc__)
    parser.add_argument("cases", type=Path, metavar="CASES.jsonl", help="opened cases; made or gone on with")
    parser.add_argument("--first", type=int, default=TUNING, help="seed (default %(default)s; below: for tuning)")
    parser.add_argument("--count", type=int, default=0, help="cases in all (default: only print the table)")
    parser.add_argument("--kind", choices=("none", "one", "pair", "outside", "failing"), help="only this kind")
    parser.add_argument(
        "--frozen",
        action="store_true",
        help=f"the {len(FROZEN)} cases that each change is tried on; or the first --count",
    )
    parser.add_argument("--compare", type=Path, metavar="BEFORE.jsonl", help="what other cases were answered otherwise")
    given = parser.parse_args(user_arguments(arguments))
    wanted: dict[int, str | None] = dict.fromkeys(range(given.first, given.first + given.count), given.kind)
    if given.frozen:
        wanted = dict(list(FROZEN.items())[: given.count or None])
    try:
        return _checked(given, wanted)
    except (OSError, ValueError) as error:
        print(f"blind_vehicle: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted: cases that were finished are kept, the same command goes on", file=sys.stderr)
        return 130


def _checked(given: argparse.Namespace, wanted: dict[int, str | None]) -> int:
    done = kept_lines(given.cases)
    if not wanted and not done:
        raise ValueError(f"{given.cases}: expected cases to tell of, or --count; found none")
    given.cases.parent.mkdir(parents=True, exist_ok=True)
    for seed in [each for each in wanted if each not in {c["seed"] for c in done}]:
        begun = time.monotonic(), time.process_time()
        try:
            case = _case(seed, wanted[seed])
        except ArithmeticError as error:
            case = {"seed": seed, "diverged": str(error)}
        case |= {"seconds": round(time.monotonic() - begun[0], 1), "cpu": round(time.process_time() - begun[1], 1)}
        keep_line(given.cases, case)
        done.append(case)
        print(json.dumps(case), file=sys.stderr, flush=True)
    if given.compare is not None:
        print("| seed | hidden | before | after | |\n|---|---|---|---|---|")
        for row in differences(kept_lines(given.compare), done):
            print(f"| {' | '.join(row)} |")
        print()
    rows = table([c for c in done if "marks" in c])
    print("| figure | value |\n|---|---|")
    for name, value in rows:
        print(f"| {name} | {value} |")
    return 0


def _case(seed: int, kind: str | None) -> dict[str, Any]:
    draw = drawn(seed, only=kind)
    model = load_model(draw.vehicle)
    with tempfile.TemporaryDirectory() as folder:
        runs = [
            write_run(Path(folder) / f"run_{k}", topics)
            for k, topics in enumerate(recorded(draw, model.vehicle, model.sets, model.sensors))
        ]
        logs, model = read_logs(runs, model)
    found = diagnosed(model, logs, {}, how_far=False)
    content, least = found.content, {(h.effect, h.thruster, h.other, h.axis): s for h, s in found.verdict.hidden}
    since = None
    if draw.begins is not None:
        run, at, last = draw.begins
        since = {"recording": f"run_{run}", "time_s": at, "lasts": last > run}
    hidden = [{"id": e, **place, "sizes": dict(sizes), "since": since} for e, place, sizes in draw.effects]
    shown = []
    for e, place, sizes in draw.effects:
        size = abs(next(iter(sizes.values()), np.inf))
        shown.append(bool(size > least.get((e, place.get("thruster"), place.get("other"), place.get("axis")), 0.0)))
    return {
        "seed": seed, "vehicle": draw.vehicle, "hidden": hidden, "outside": draw.outside, "missing": draw.missing,
        "wrench": draw.wrench, "noise": draw.noise, "kinds": draw.kinds, "shown": shown,
        "wiring": content["wiring"]["verdict"], "marks": scored(hidden, draw.outside, content),
        "summary": content["summary"],
    }  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
