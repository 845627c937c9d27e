"""Recorded runs through observers; a table, and on request a report and JSON."""

import argparse
import sys
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from math import isfinite
from pathlib import Path
from typing import Any

from run_bag.command_line import user_arguments
from safe_files.whole_files_io import expect_new_folder, new_folder, write_whole
from thruster_estimation.errors import EstimationError
from thruster_estimation.reference import REFERENCES
from thruster_estimation.replay import Job, Outcome, problem_with, replay
from thruster_estimation.replay_io import PERIOD, dump_outcomes, read_signals
from thruster_estimation.replay_report_io import build_report, label
from thruster_estimation.settings import BENCH, OBSERVERS, PROPER, bench_settings, checked
from thruster_model.errors import ThrusterModelError
from thruster_model.parameter_set_io import load_parameter_set

_MAP = ("c_u1", "delta_u1", "c_u2", "delta_u2")


def main(arguments: Sequence[str] | None = None) -> int:
    """Replay, print the table, write the results; return the exit status."""
    given = _parser().parse_args(user_arguments(arguments))
    try:
        _check(given)
        jobs, left_out = _jobs(given)
        signals = read_signals(given.runs, given.thruster, given.period)
        outcomes = [replay(s, job) for s in signals for job in jobs]
        if given.out is not None:
            _write(outcomes, given)
    except (EstimationError, ThrusterModelError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    for sentence in left_out:
        print(f"left out: {sentence}", file=sys.stderr)
    _print(outcomes)
    if given.out is not None:
        print((given.out / "report.html").resolve())
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="replay", description=__doc__)
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="recorded runs (rosbag2 directories)")
    names = "observers (default ekf); ukf and rts are references: an unscented filter, a smoother that knows the future"
    known = (*OBSERVERS, *REFERENCES)
    parser.add_argument("--estimator", "--observer", nargs="+", default=["ekf"], choices=known, help=names)
    sets = "parameter sets of the simplified, HL or HQ form, by name or YAML file (default hl)"
    parser.add_argument("--set", "--model", dest="sets", nargs="+", metavar="SET", default=["hl"], help=sets)
    form = "bench: Euler, as the bench ran it (default proper)"
    parser.add_argument("--form", default="proper", choices=("proper", "bench"), help=form)
    parser.add_argument("--input-map", metavar=",".join(_MAP), help="input map in the place of the sets' own")
    gate = "largest NIS of a measurement that is used, e.g. 16 (default: all are used)"
    parser.add_argument("--gate", type=float, metavar="NIS", help=gate)
    noise = "standard deviation of a measured {} (default: the bench's)"
    parser.add_argument("--speed-noise", type=float, metavar="RAD/S", help=noise.format("speed"))
    parser.add_argument("--flow-noise", type=float, metavar="M/S", help=noise.format("ambient flow"))
    parser.add_argument("--period", type=float, metavar="S", help=f"least period of the replay (default {PERIOD} s)")
    parser.add_argument("--thruster", type=int, default=0, help="index of the thruster (default 0)")
    parser.add_argument("--out", type=Path, help="new or empty folder for report.html and replay.json")
    return parser


def _check(given: argparse.Namespace) -> None:
    problems = []
    paths = [path.resolve() for path in given.runs]
    problems += [f"{path}: given twice" for path in sorted({str(p) for p in paths if paths.count(p) > 1})]
    for name in ("gate", "speed_noise", "flow_noise", "period"):
        value = getattr(given, name)
        if value is not None and not value > 0:
            problems.append(f"--{name.replace('_', '-')}: expected a number > 0; found {value:g}")
    if given.out is not None:
        try:
            expect_new_folder(given.out)
        except OSError as error:
            problems.append(str(error))
    if problems:
        raise EstimationError(problems)


def _input_map(text: str | None) -> dict[str, float]:
    if text is None:
        return {}
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    c_u1, delta_u1, c_u2, delta_u2 = values if len(values) == 4 else (0.0,) * 4
    if not (c_u1 > 0 and c_u2 > 0 and delta_u1 <= 0 <= delta_u2 and all(map(isfinite, values))):
        expected = "four numbers c_u1 > 0, delta_u1 <= 0, c_u2 > 0, delta_u2 >= 0 in 1/(V s^2) and V"
        raise EstimationError([f"--input-map: expected {expected}, separated by commas; found {text!r}"])
    return dict(zip(_MAP, values, strict=True))


def _jobs(given: argparse.Namespace) -> tuple[list[Job], list[str]]:
    changed, jobs = _input_map(given.input_map), []
    for model in dict.fromkeys(given.sets):
        coefficients = load_parameter_set(model).coefficients
        if changed:
            coefficients = coefficients._replace(**changed)
        for estimator in dict.fromkeys(given.estimator):
            jobs.append(Job(estimator, Path(model).stem, _settings(given, estimator, coefficients), coefficients))
    problems = {job: problem_with(job) for job in jobs}
    usable = [job for job in jobs if not problems[job]]
    left_out = [sentence for sentence in problems.values() if sentence]
    if not usable:
        raise EstimationError(left_out)
    return usable, left_out


def _settings(given: argparse.Namespace, estimator: str, coefficients: Any) -> Any:
    form = BENCH if given.form == "bench" else PROPER
    settings = bench_settings("ekf" if estimator in REFERENCES else estimator, form=form, k_U=coefficients.k_U)
    changed: dict[str, float] = {}
    if given.gate is not None:
        changed["gate"] = given.gate
    if given.speed_noise is not None:
        changed["r_n"] = given.speed_noise**2
    if given.flow_noise is not None and "r_U" in settings._fields:
        changed["r_U"] = given.flow_noise**2
    return checked(settings._replace(**changed))


def _print(outcomes: Sequence[Outcome]) -> None:
    width = max(len(o.signals.name) for o in outcomes) + 2
    wide = max(len(label(o)) for o in outcomes) + 2
    heads = (
        ("n ahead", "rad/s", 10), ("U ahead", "m/s", 10), ("v", "m/s", 10), ("NIS", "1", 8), ("95 %", "1", 14),
        ("refused", "%", 9),
    )  # fmt: skip
    print(f"{'run':<{width}}{'observer':<{wide}}" + "".join(f"{name:>{size}}" for name, _, size in heads))
    print(" " * (width + wide) + "".join(f"{unit:>{size}}" for _, unit, size in heads))
    for o in outcomes:
        measured = {s.state: f"{s.rmse:.4g}" for s in o.scores if s.against.startswith("measured")}
        cells = "".join(f"{measured.get(state, '-'):>10}" for state in ("n", "U", "v"))
        nis = "-" if o.nis is None else f"{o.nis:.3g}"
        interval = "-" if o.nis_interval is None else f"{o.nis_interval[0]:.2f} to {o.nis_interval[1]:.2f}"
        gated = max(x for x in (o.gated_n, o.gated_U, 0.0) if x is not None)
        print(f"{o.signals.name:<{width}}{label(o):<{wide}}{cells}{nis:>8}{interval:>14}{100 * gated:>9.1f}")
    for o in outcomes:
        for kind in ("logged", "truth"):
            of_kind = [s for s in o.scores if s.against == kind]
            found = [f"{s.state} {s.rmse:.3g} {s.unit} (largest {s.largest:.3g})" for s in of_kind]
            if found:
                by = f" by {o.signals.logged_by}" if kind == "logged" and o.signals.logged_by else ""
                print(f"{o.signals.name}, {label(o)}: RMS difference to {kind}{by}: {', '.join(found)}")


def _write(outcomes: Sequence[Outcome], given: argparse.Namespace) -> None:
    provenance = {
        "runs": [path.resolve().name for path in given.runs],
        "models": given.sets,
        "form": given.form,
        "input map": given.input_map,
        "gate": given.gate,
        "version": _version(),
    }
    report = build_report(outcomes, {k: v for k, v in provenance.items() if v is not None})
    with new_folder(given.out) as partial:
        write_whole(partial / "replay.json", dump_outcomes(outcomes, provenance))
        report.write(partial / "report.html")


def _version() -> str:
    try:
        return version("thruster_estimation")
    except PackageNotFoundError:
        return "source"


if __name__ == "__main__":
    sys.exit(main())
