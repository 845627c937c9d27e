"""The thesis' closed-loop experiments (section 5.1) in simulation, on many thrusters.

Resumes where DIR holds the same study; finished parts are kept.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rov_sim.bench_study.controllers import BELIEFS, EXTRA, FORMS, THESIS
from rov_sim.bench_study.experiment import KINDS, SCORES
from rov_sim.bench_study.plan_io import conditions_of, load_plant, plan_text
from rov_sim.bench_study.real_runs_io import add_controller_argument, controllers_told, read_real_runs
from rov_sim.bench_study.report_io import build_report
from rov_sim.bench_study.results_io import UNITS, run_shard
from rov_sim.closed_loop import Timing
from rov_sim.rig_sensors import Rig
from rov_sim.study.cli_running import FAILURES, add_running_arguments, failed, problems, run_with_progress, version_here
from rov_sim.study.results import Results
from rov_sim.study.results_io import read_results, write_table
from rov_sim.study.store_io import Store, shards_of
from run_bag import RunError
from run_bag.command_line import user_arguments
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
        real = read_real_runs(given.real, controllers_told(given.controller)) if given.real is not None else []
        store = Store(given.out, plan, SCORES)
        shards = shards_of(strategies, references, given.seeds)
        run_with_progress(store, shards, run_shard, given)
        study = read_results(store, shards)
        write_table(study, given.out / "scores.csv", UNITS)
        provenance = {"plan": f"{given.out.resolve().name}/plan.json", "seeds": given.seeds, "version": version_here()}
        report = build_report(study, conditions_of(plan), provenance, real)
        page = report.write(given.out / "report.html", replace=True)
    except (*FAILURES, RunError) as error:
        return failed(error)
    _print(study)
    kept = {path.name.split(".")[0] for path in (given.out / "shards").glob("*.json")} - set(strategies)
    if kept:
        told = f"scores.csv and report.html tell of {', '.join(strategies)}; what {', '.join(sorted(kept))} scored"
        print(f"note: {told} before is kept in {given.out / 'shards'}", file=sys.stderr)
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
    add_controller_argument(p)
    add_running_arguments(p)
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
    wrong += problems(given, (("seeds", 1), ("seed", 0)))
    if not 0.0 <= given.deviation <= 1.0:
        wrong.append(f"--deviation: expected a share from 0 to 1; found {given.deviation:g}")
    if wrong:
        raise ValueError("\n".join(wrong))
    return strategies, references


def _rig(given: argparse.Namespace) -> Rig:
    changed = {"spike_share": given.spikes, "resonance": given.resonance}
    return Rig(**{name: value for name, value in changed.items() if value is not None})


def _print(study: Results) -> None:
    print(f"{'RMSE of thrust [N] (over lookup)':<34}" + "".join(f"{r:>22}" for r in study.references))
    for s in study.strategies:
        cells = []
        for r in study.references:
            mean = study.mean(s, r, "rmse")
            ratio = f" ({study.normalised(s, r).value:.2f})" if "lookup" in study.strategies else ""
            cells.append(f"{mean.value:.2f} ± {0.5 * (mean.high - mean.low):.2f}{ratio}")
        print(f"{s:<34}" + "".join(f"{cell:>22}" for cell in cells))


if __name__ == "__main__":
    sys.exit(main())
