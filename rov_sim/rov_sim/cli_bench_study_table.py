"""Finished bench studies as tables and pictures, beside the real runs and how far they are predicted."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rov_sim.bench_study.fitted_map import fitted_map
from rov_sim.bench_study.pictures_io import draw_errors, draw_prediction
from rov_sim.bench_study.plan_io import conditions_of, load_plant, plan_text
from rov_sim.bench_study.prediction import Prediction, predictions
from rov_sim.bench_study.real_runs import RealRun, lookup_lines, measured_disturbances, recovered_map
from rov_sim.bench_study.real_runs_io import add_controller_argument, controllers_told, read_real_runs
from rov_sim.bench_study.results_io import read_study
from rov_sim.bench_study.tables import (
    claim_tables,
    disturbance_lines,
    error_table,
    prediction_table,
    real_table,
    run_table,
)
from rov_sim.closed_loop import Timing
from rov_sim.rig_sensors import Rig
from run_bag import RunError
from run_bag.command_line import user_arguments
from safe_files.whole_files_io import expect_new_folder, write_whole
from thruster_control.errors import ThrusterControlError
from thruster_model.errors import ThrusterModelError
from thruster_model.parameter_set_io import load_parameter_set

_DEVIATIONS = (0.0, 0.05)
_BEST = "and flow as read"
_PLAIN = "as published"


def main(arguments: Sequence[str] | None = None) -> int:
    """Write tables.md and pictures; return the exit status."""
    given = _parser().parse_args(user_arguments(arguments))
    try:
        studies = dict(_named(text, "--study") for text in given.study)
        quiet = dict(_named(text, "--without-spikes") for text in given.without_spikes)
        unknown = sorted(set(quiet) - set(studies))
        if unknown:
            raise ValueError(f"--without-spikes: expected names of --study; found {', '.join(unknown)}")
        expect_new_folder(given.out)
        read = {name: read_study(folder)[1] for name, folder in studies.items()}
        silent = {name: read_study(folder)[1] for name, folder in quiet.items()}
        main_study = next(iter(read.values()))
        texts = ["## Errors", error_table(main_study), "## Statements", claim_tables(read, silent)]
        given.out.mkdir(parents=True, exist_ok=True)
        draw_errors(main_study, given.out / "bench_study_errors.svg")
        if given.real is not None:
            texts += _real(given, read_real_runs(given.real, controllers_told(given.controller)))
        write_whole(given.out / "tables.md", "\n\n".join(texts) + "\n", replace=True)
    except (RunError, ThrusterModelError, ThrusterControlError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    print(given.out / "tables.md")
    return 0


def _parser() -> argparse.ArgumentParser:
    p = argparse.ArgumentParser(prog="bench_study_table", description=__doc__)
    p.add_argument(
        "--study", action="append", required=True, metavar="NAME=DIR", help="of bench_study; the first leads"
    )
    text = "the same study as NAME without spikes"
    p.add_argument("--without-spikes", action="append", default=[], metavar="NAME=DIR", help=text)
    p.add_argument("--real", type=Path, metavar="PATH", help="recordings of the bench")
    add_controller_argument(p)
    text = "to predict the real runs with: a set, a YAML file, a diagnosis.json; NAME= before it names it"
    p.add_argument("--plant", action="append", default=[], metavar="[NAME=]SET", help=text)
    p.add_argument("--seeds", type=int, default=50, help="of each prediction (default 50)")
    p.add_argument("--seed", type=int, default=1, help="of the predictions (default 1)")
    p.add_argument("--out", type=Path, required=True, metavar="DIR", help="new or empty folder")
    return p


def _named(text: str, option: str) -> tuple[str, Path]:
    name, equals, folder = text.partition("=")
    if not (name and equals and folder):
        raise ValueError(f"{option}: expected NAME=DIR; found {text!r}")
    return name, Path(folder)


def _real(given: argparse.Namespace, runs: list[RealRun]) -> list[str]:
    """Return the sections about the real runs; draw their picture."""
    if given.seeds < 1:
        raise ValueError(f"--seeds: expected 1 or more; found {given.seeds}")
    bench = load_parameter_set("hl_bench").coefficients
    logged, table = recovered_map(runs, bench), lookup_lines(runs)
    texts = ["## Real runs", real_table(runs), "## Measured", disturbance_lines(measured_disturbances(runs), logged)]
    found: dict[tuple[str, float, str], Prediction] = {}
    maps = ["| plant | c_u1 | delta_u1 | c_u2 | delta_u2 | τ [ms] | n left [rad/s] | before |", "|" + "---|" * 8]
    rng = np.random.default_rng(given.seed)
    last, foreseeing = None, list[tuple[str, str]]()
    for plant in given.plant or ["hl_bench"]:
        name, equals, path = plant.partition("=")
        chosen = load_plant(path if equals else name)
        fitted = None
        if chosen.without:
            foreseeing.append((name, _PLAIN))
        else:  # that of the others was fitted already, and without the run in question
            fitted = fitted_map(runs, chosen.truth.coefficients, chosen.truth.effects)
            gamma = fitted.input_map
            maps.append(
                f"| {name} | {gamma.c_u1:.1f} | {gamma.delta_u1:.3f} | {gamma.c_u2:.1f} | {gamma.delta_u2:.3f} | "
                f"{1e3 * fitted.tau:.1f} | {fitted.left:.2f} | {fitted.before:.2f} |"
            )
        for deviation in _DEVIATIONS if not chosen.without else (0.0,):
            plan = plan_text(
                chosen, deviation=deviation, form="bench", beliefs="bench", rig=Rig(), timing=Timing(), seed=given.seed
            )
            last = conditions_of(plan)
            told = predictions(runs, last, logged, table, fitted, given.seeds, rng, chosen.without)
            found |= {(name, deviation, title): p for title, p in told.items()}
    names = list(dict.fromkeys(name for name, _, _ in found))
    ends = [(names[0], _PLAIN), *(foreseeing or [(names[0], _BEST)]), (names[-1], _BEST)]
    widest = {name: deviation for name, deviation, _ in found}
    shown = {f"{name}, {chosen}": found[name, widest[name], chosen] for name, chosen in dict.fromkeys(ends)}
    assert last is not None
    draw_prediction(runs, shown, last, given.out / "bench_study_real.svg")
    texts += ["## Plant's input map, fitted to the rotor", "\n".join(maps)]
    return [*texts, "## Prediction", prediction_table(found), run_table(runs, shown)]


if __name__ == "__main__":
    sys.exit(main())
