"""The thesis' closed-loop simulations of a whole vehicle (section 5.2), on many vehicles, in many cases.

Resumes where DIR holds the same study; finished parts are kept.
"""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rov_sim.study.cli_running import FAILURES, add_running_arguments, failed, problems, run_with_progress, version_here
from rov_sim.study.results import BASELINE, Results
from rov_sim.study.results_io import write_table
from rov_sim.study.store_io import Store
from rov_sim.vehicle_study.pictures_io import draw_errors, draw_runs
from rov_sim.vehicle_study.plan import Plan
from rov_sim.vehicle_study.plan_io import available_plans, load_plan, plan_of, plan_text
from rov_sim.vehicle_study.report_io import build_report, write_tables
from rov_sim.vehicle_study.results_io import contents_of, results_of, run_shard, shards
from rov_sim.vehicle_study.scoring import SCORES, UNITS
from run_bag import RunError
from run_bag.command_line import user_arguments


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what is missing, write scores, tables, pictures and report; return the exit status."""
    given = _parser().parse_args(user_arguments(arguments))
    try:
        wrong = problems(given, (("seeds", 1), ("seed", 0)))
        if wrong:
            raise ValueError("\n".join(wrong))
        plan = _chosen(load_plan(given.plan, given.seed), given.groups)
        text = plan_text(plan, contents_of(plan))
        store = Store(given.out, text, SCORES)
        parts = shards(plan, given.seeds)
        run_with_progress(store, parts, run_shard, given)
        study = results_of(plan, store, given.seeds)
        write_table(study, given.out / "scores.csv", UNITS)
        contents = plan_of(text)[1]
        draw_errors(study, plan, given.out / "rov_study_errors.svg")
        draw_runs(plan, contents, given.out / "rov_study_runs.svg")
        write_tables(study, plan, given.out / "tables.md")
        provenance = {"plan": f"{given.out.resolve().name}/plan.json", "seeds": given.seeds, "version": version_here()}
        page = build_report(study, plan, contents, provenance).write(given.out / "report.html", replace=True)
    except (*FAILURES, RunError) as error:
        return failed(error)
    _print(study, plan)
    for file in ("scores.csv", "tables.md", "rov_study_errors.svg", "rov_study_runs.svg"):
        print(given.out / file)
    print(page)
    return 0


def _parser() -> argparse.ArgumentParser:
    p = argparse.ArgumentParser(prog="rov_study", description=__doc__)
    known = ", ".join(available_plans())
    p.add_argument("--plan", default="thesis", help=f"{known}, or a YAML file (default thesis)")
    p.add_argument("--groups", metavar="NAME,…", help="of the plan's groups of cases (default all)")
    p.add_argument("--seeds", type=int, default=50, help="number of vehicles drawn (default 50)")
    p.add_argument("--seed", type=int, default=1, help="of the study (default 1)")
    add_running_arguments(p)
    p.add_argument("--out", type=Path, required=True, metavar="DIR", help="new folder, or one to resume")
    return p


def _chosen(plan: Plan, groups: str | None) -> Plan:
    """Return the plan with some of its groups; ValueError for groups that it has not."""
    if groups is None:
        return plan
    known = {group.name: group for group in plan.groups}
    unknown = [name for name in groups.split(",") if name not in known]
    if unknown:
        raise ValueError(f"--groups: expected some of {', '.join(known)}; found {', '.join(map(repr, unknown))}")
    return replace(plan, groups=tuple(known[name] for name in dict.fromkeys(groups.split(","))))


def _print(study: Results, plan: Plan) -> None:
    """Print the normalised errors of the first case of each group."""
    for group in plan.groups:
        case = plan.cases(group)[0].name
        print(f"{group.title}: {case}")
        for s in group.strategies:
            cells = [f"{100 * study.mean(s, case, name).value:8.2f} %" for name in ("surge", "pitch_rate", "pitch")]
            ratio = f"{study.normalised(s, case, 'pitch').value:8.2f}" if BASELINE in group.strategies else ""
            print(f"  {s:<12}{''.join(cells)}{ratio}")


if __name__ == "__main__":
    sys.exit(main())
