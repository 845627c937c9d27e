"""Fit thruster models to recorded runs, and report how well each describes the thruster."""

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from run_bag.command_line import described, of_a_vehicle, offer_vehicle, user_arguments
from safe_files.whole_files_io import expect_new_folder, new_folder, write_whole
from thruster_model.errors import ThrusterModelError, UnfitDataError
from thruster_model.identification.experiment import SIGNALS
from thruster_model.identification.experiment_io import PreparationOptions, read_experiments
from thruster_model.identification.fit import FitOptions
from thruster_model.identification.fit_report import build_report
from thruster_model.identification.flow_quality import FlowLimits
from thruster_model.identification.study import FittedModel, Study, run_study
from thruster_model.models import MODELS
from thruster_model.parameter_set import ParameterSet
from thruster_model.parameter_set_io import load_parameter_set, write_parameter_set
from thruster_model.progress_io import progress

EXAMPLES = """
  %(prog)s runs/log --model hl hq --out fit              # two models, from the published sets on
  %(prog)s runs/* --model hq --start mine.yaml --out fit # from a set of yours on"""


def main(arguments: Sequence[str] | None = None, program: str = "fit") -> int:
    """Fit, write the sets, the summary and the report; return the exit status."""
    parser, taken = _parser(program), user_arguments(arguments)
    if of_a_vehicle(taken):
        parser.error("of a vehicle it is thruster fit --vehicle SET ..., or ros2 run gap_diagnosis fit_vehicle")
    given = parser.parse_args(taken)
    try:
        _check_runs(given)
        starts = _starts(given)
        expect_new_folder(given.out)
        study = _study(given, starts)
        _write(study, given)
    except (ThrusterModelError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted: nothing was written", file=sys.stderr)
        return 130
    if any(d.status == "determined" for model in study.models for d in model.result.determinations):
        return 0
    print("fit: expected runs that determine a parameter; these determine none, see the report", file=sys.stderr)
    return 1


def _parser(program: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog=program, **described(__doc__, EXAMPLES))
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="recorded runs (rosbag2 directories)")
    text = f"models to fit: {', '.join(MODELS)} (default hl)"
    parser.add_argument("--model", nargs="+", default=["hl"], choices=tuple(MODELS), metavar="MODEL", help=text)
    parser.add_argument(
        "--start", metavar="SET", help="parameter set to start from, a name or a YAML file (default: the thesis')"
    )
    parser.add_argument(
        "--reference", metavar="SET", help="parameter set to compare with (default: where the fit started)"
    )
    parser.add_argument("--out", type=Path, required=True, help="new or empty folder for the results")
    method = "how the least sum of squares is sought (default %(default)s)"
    parser.add_argument("--method", default="least-squares", choices=("least-squares", "nelder-mead"), help=method)
    stages = "joint: all at once after the stages; thesis: the stages alone"
    parser.add_argument("--stages", default="joint", choices=("joint", "thesis"), help=stages)
    parser.add_argument("--validate", nargs="+", type=Path, default=[], metavar="RUN", help="runs to predict only")
    limit = "largest credible flow [m/s], beyond which a velocimeter wraps (default %(default)s: a Vectrino's range)"
    parser.add_argument("--largest-flow", type=float, default=FlowLimits().velocity, metavar="SPEED", help=limit)
    offer_vehicle(parser, "it is thruster fit --vehicle SET ..., or ros2 run gap_diagnosis fit_vehicle")
    parser.add_argument("--hold-out", action="store_true", help="repeat each fit with each run left out")
    return parser


def _check_runs(given: argparse.Namespace) -> None:
    fitted = [path.resolve() for path in given.runs]
    twice = sorted({str(path) for path in fitted if fitted.count(path) > 1})
    both = sorted({str(path) for path in fitted} & {str(path.resolve()) for path in given.validate})
    problems = [f"{path}: given twice; the same data would count twice" for path in twice]
    problems += [f"{path}: given to be fitted and to be predicted only; expected one of the two" for path in both]
    if problems:
        raise UnfitDataError(problems)


def _starts(given: argparse.Namespace) -> list[tuple[ParameterSet, ParameterSet]]:
    pairs = []
    for name in dict.fromkeys(given.model):
        start = load_parameter_set(given.start or name)
        if start.model_name != name:
            raise UnfitDataError(
                [f"--start {given.start}: expected a set of model '{name}'; found '{start.model_name}'"]
            )
        pairs.append((start, load_parameter_set(given.reference) if given.reference else start))
    return pairs


def _study(given: argparse.Namespace, starts: list[tuple[ParameterSet, ParameterSet]]) -> Study:
    with progress("reading") as tell:
        preparation = PreparationOptions(flow=FlowLimits(velocity=given.largest_flow))
        fitted, predicted = (read_experiments(runs, preparation, tell) for runs in (given.runs, given.validate))
        for experiment in (*fitted, *predicted):
            for warning in experiment.warnings:
                print(f"warning: {experiment.name}: {warning}", file=sys.stderr)
        return run_study(
            starts,
            fitted,
            validation=predicted,
            hold_out=given.hold_out,
            options=FitOptions(method=given.method, stages=given.stages),
            progress=tell,
        )


def _write(study: Study, given: argparse.Namespace) -> None:
    with new_folder(given.out) as partial:
        _write_into(partial, study, given)
    for model in study.models:
        print(_line(model, _reference_name(given)))
    print((given.out / "report.html").resolve())


def _reference_name(given: argparse.Namespace) -> str:
    if given.reference:
        return "reference"
    return "start" if given.start else "published"


def _write_into(folder: Path, study: Study, given: argparse.Namespace) -> None:
    for model in study.models:
        write_parameter_set(model.result.parameter_set, folder / f"{model.name}.yaml")
    provenance = {
        "runs": [e.name for e in study.experiments],
        "runs predicted only": [e.name for e in study.validation],
        "start": {m.name: m.result.start.source for m in study.models},
        "reference": {m.name: m.reference.source for m in study.models},
        "method": given.method,
        "stages": given.stages,
        "version": _version(),
    }
    summary = {"provenance": provenance, "models": [_summary(model) for model in study.models]}
    write_whole(folder / "fit.json", json.dumps(summary, indent=1))
    report = build_report(study, provenance=provenance, reference_name=_reference_name(given))
    report.write(folder / "report.html")


def _version() -> str:
    try:
        return version("thruster_model")
    except PackageNotFoundError:
        return "source"


def _summary(model: FittedModel) -> dict[str, object]:
    return {
        "model": model.name,
        "message": model.result.message,
        "errors": [asdict(c) for c in model.comparison],
        "errors_left_out": [asdict(c) for c in model.held_out[1]] if model.held_out else None,
        "errors_other_runs": [asdict(c) for c in model.validation] or None,
        "units": {s: SIGNALS[s].unit for s in model.fitted.signals},
        "noise": dict(model.fitted.noise),
        "parameters": [asdict(d) for d in model.result.determinations],
    }


def _line(model: FittedModel, reference: str) -> str:
    total = next(c for c in model.comparison if c.signal == "total")
    open_ = [f"{d.name} ({d.status})" for d in model.result.determinations if d.status != "determined"]
    text = f"{model.name}: noise-weighted error {total.error:.2f} fitted, {total.reference:.2f} {reference}"
    if model.held_out:
        text += f", {model.held_out[1][-1].error:.2f} on runs left out"
    return f"{text}; not determined: {', '.join(open_) or 'none'}"


if __name__ == "__main__":
    sys.exit(main())
