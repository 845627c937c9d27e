"""Command line: the thesis' closed-loop experiments (section 5.1) in simulation, on many thrusters.

Resumes where DIR holds the same study; finished parts are kept.
"""

import argparse
import sys
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from rov_sim.bench_study.controllers import BELIEFS, EXTRA, FORMS, THESIS
from rov_sim.bench_study.experiment import KINDS
from rov_sim.bench_study.plan_io import conditions_of, load_plant, plan_text
from rov_sim.bench_study.real_runs_io import read_real_runs
from rov_sim.bench_study.report_io import build_report
from rov_sim.bench_study.results import Results
from rov_sim.bench_study.results_io import read_results, write_table
from rov_sim.bench_study.running_io import StudyInterrupted, checked_address, run_shards
from rov_sim.bench_study.store_io import Store, shards_of
from rov_sim.closed_loop import Timing
from rov_sim.rig_sensors import Rig
from run_bag import RunError
from run_bag.command_line import user_arguments
from thruster_control.errors import ThrusterControlError
from thruster_model.errors import ThrusterModelError
from thruster_model.parameter_set_io import available_sets


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what is missing, write table and report; return the exit status."""
    given = _parser().parse_args(user_arguments(arguments))
    try:
        strategies, references = _chosen(given)
        plan = plan_text(
            load_plant(given.plant),
            deviation=given.deviation,
            form=given.form,
            beliefs=given.beliefs,
            rig=_rig(given),
            timing=Timing(sample=given.sample, computation=given.computation),
            seed=given.seed,
        )
        real = read_real_runs(given.real) if given.real is not None else []
        store = Store(given.out, plan)
        shards = shards_of(strategies, references, given.seeds)
        _run(store, shards, given)
        study = read_results(store, shards)
        write_table(study, given.out / "scores.csv")
        provenance = {"plan": str(given.out / "plan.json"), "seeds": given.seeds, "version": _version()}
        report = build_report(study, conditions_of(plan), provenance, real)
        page = report.write(given.out / "report.html", replace=True)
    except StudyInterrupted as error:
        print(error, file=sys.stderr)
        return 1
    except ModuleNotFoundError as error:
        print(f"--scheduler: expected dask.distributed to be installed; found {error}", file=sys.stderr)
        return 1
    except (RunError, ThrusterModelError, ThrusterControlError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted: what was finished is kept, the same command resumes", file=sys.stderr)
        return 130
    _print(study)
    print(given.out / "scores.csv")
    print(page)
    return 0


def _parser() -> argparse.ArgumentParser:
    p = argparse.ArgumentParser(prog="bench_study", description=__doc__)
    known = ", ".join((*THESIS, *EXTRA))
    p.add_argument("--strategies", default="thesis", help=f"thesis, all, or some of {known} (default thesis: eight)")
    p.add_argument("--references", default="step,triangle,sine", help="set points (default step,triangle,sine)")
    p.add_argument("--seeds", type=int, default=50, help="number of thrusters drawn (default 50)")
    p.add_argument("--seed", type=int, default=1, help="of the study (default 1)")
    sets = ", ".join(available_sets())
    p.add_argument("--plant", default="hl_bench", help=f"{sets}, a YAML file, or a diagnosis.json (default hl_bench)")
    text = "deviation of the plant's values where its set states none (default 0.05)"
    p.add_argument("--deviation", type=float, default=0.05, metavar="SHARE", help=text)
    p.add_argument("--form", default="bench", choices=FORMS, help="of observers and law (default bench: as it ran)")
    p.add_argument("--beliefs", default="bench", choices=BELIEFS, help="controllers' parameters (default bench)")
    p.add_argument("--spikes", type=float, metavar="SHARE", help="of the velocimeter (default: as measured)")
    p.add_argument("--resonance", type=float, metavar="HZ", help="of the load cell's structure (default: stiff)")
    p.add_argument("--sample", type=float, default=0.0, metavar="S", help="from u_k's sending to y_k (default 0)")
    p.add_argument("--computation", type=float, default=0.0, metavar="S", help="until u_k acts (default 0)")
    p.add_argument("--real", type=Path, metavar="PATH", help="recordings of the bench, to be scored beside")
    p.add_argument("--processes", type=int, default=1, help="on this machine (default 1)")
    p.add_argument("--scheduler", metavar="tcp://…", help="address of a dask scheduler on this machine")
    p.add_argument("--out", type=Path, required=True, metavar="DIR", help="new folder, or one to resume")
    return p


def _chosen(given: argparse.Namespace) -> tuple[list[str], list[str]]:
    """Return strategies and set points; ValueError with all that is wrong."""
    groups = {"thesis": THESIS, "all": (*THESIS, *EXTRA)}
    strategies = list(groups.get(given.strategies, dict.fromkeys(given.strategies.split(","))))
    references = list(dict.fromkeys(given.references.split(",")))
    wrong = []
    for option, words, known in (
        ("strategies", strategies, (*THESIS, *EXTRA)),
        ("references", references, tuple(KINDS)),
    ):
        unknown = [word for word in words if word not in known]
        if unknown:
            wrong.append(f"--{option}: expected some of {', '.join(known)}; found {', '.join(map(repr, unknown))}")
    for option, least in (("seeds", 1), ("processes", 1), ("seed", 0)):
        if getattr(given, option) < least:
            wrong.append(f"--{option}: expected {least} or more; found {getattr(given, option)}")
    if not 0.0 <= given.deviation <= 1.0:
        wrong.append(f"--deviation: expected a share from 0 to 1; found {given.deviation:g}")
    if given.scheduler is not None:
        try:
            checked_address(given.scheduler)
        except ValueError as error:
            wrong.append(str(error))
    if wrong:
        raise ValueError("\n".join(wrong))
    return strategies, references


def _rig(given: argparse.Namespace) -> Rig:
    changed = {"spike_share": given.spikes, "resonance": given.resonance}
    return Rig(**{name: value for name, value in changed.items() if value is not None})


def _run(store: Store, shards: Sequence, given: argparse.Namespace) -> None:  # type: ignore[type-arg]
    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("experiments")

        def progress(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total)
            if not console.is_terminal and (done == total or done % max(1, total // 10) == 0):
                print(f"  {done} of {total} parts", file=sys.stderr, flush=True)

        run_shards(store, shards, processes=given.processes, scheduler=given.scheduler, progress=progress)


def _print(study: Results) -> None:
    print(f"{'RMSE of thrust [N] (over lookup)':<34}" + "".join(f"{r:>22}" for r in study.references))
    for s in study.strategies:
        cells = []
        for r in study.references:
            mean = study.mean(s, r, "rmse")
            ratio = f" ({study.normalised(s, r).value:.2f})" if "lookup" in study.strategies else ""
            cells.append(f"{mean.value:.2f} ± {0.5 * (mean.high - mean.low):.2f}{ratio}")
        print(f"{s:<34}" + "".join(f"{cell:>22}" for cell in cells))


def _version() -> str:
    try:
        return version("rov_sim")
    except PackageNotFoundError:
        return "source"


if __name__ == "__main__":
    sys.exit(main())
