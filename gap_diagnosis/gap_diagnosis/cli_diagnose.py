"""Why recordings of a thruster and the simulator's parameter set disagree."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from gap_diagnosis.diagnose_io import package_version, write_diagnosis
from gap_diagnosis.diagnosis import Diagnosis, Unfit, diagnose
from gap_diagnosis.diagnosis_json import as_json
from gap_diagnosis.experiment_design import NextExperiment
from gap_diagnosis.experiment_inputs import Limits
from gap_diagnosis.experiment_io import LARGEST, experiment_content, propose, write_experiment
from gap_diagnosis.recording import Recording
from gap_diagnosis.recording_io import read_recordings
from gap_diagnosis.report import diagnosis_report
from gap_diagnosis.stretches import LENGTH, LONGEST, THINNED
from run_bag import RunError
from run_bag.command_line import described, of_a_vehicle, offer_vehicle, user_arguments
from safe_files.whole_files_io import expect_new_folder, new_folder
from thruster_model.effects.stages import LIBRARY
from thruster_model.errors import ThrusterModelError
from thruster_model.parameter_set_io import available_sets, load_parameter_set

EXAMPLES = """
  %(prog)s runs/log --set mine.yaml --out diagnosis
  %(prog)s runs/* --set hl --out diagnosis --experiment      # and what to record next"""


def main(arguments: Sequence[str] | None = None, program: str = "diagnose") -> int:
    """Diagnose runs, of a vehicle with `--vehicle`; return the exit status."""
    taken = user_arguments(arguments)
    if of_a_vehicle(taken):
        from gap_diagnosis.vehicle.cli_diagnose_vehicle import main as of_vehicle  # loads the vehicle's model

        return of_vehicle(taken, program)
    parser = _parser(program)
    given = parser.parse_args(taken)
    out = given.out
    try:
        unknown = sorted(set(given.without) - set(LIBRARY))
        if unknown:
            raise ValueError(f"--without {' '.join(unknown)}: expected effects of {', '.join(LIBRARY)}")
        expect_new_folder(out)
        if given.longest is not None and not given.longest >= LENGTH:
            raise ValueError(f"--longest: expected {LENGTH:g} s or more; found {given.longest:g}")
        if given.experiment:  # wrong limits are refused before anything is computed
            largest = LARGEST if given.largest_throttle is None else given.largest_throttle
            Limits(largest=largest, rate=1.0, duration=given.experiment_duration)
        parameter_set = load_parameter_set(given.set)
        recordings = read_recordings(given.runs, given.thruster, progress=_say)
        found = diagnose(
            recordings, parameter_set, excluded=tuple(given.without), seed=given.seed, longest=given.longest,
            progress=_say,
        )  # fmt: skip
        proposed = _proposed(given, found, recordings)
        content = as_json(
            found,
            runs=[path.resolve().name for path in given.runs],
            parameter_set=parameter_set.name,
            version=package_version(),
            seed=given.seed,
            next_experiment=experiment_content(proposed),
        )
        report = diagnosis_report(found, content)
        with new_folder(out) as folder:
            page = report.write(folder / "report.html")
            programme = write_experiment(proposed, folder, given.thruster)
            paths = [page, *programme, *write_diagnosis(found, content, folder)]
            written = [out / path.relative_to(folder) for path in paths]
    except Unfit as error:
        print("\n".join(error.problems), file=sys.stderr)
        return 1
    except (RunError, ThrusterModelError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted: nothing was written", file=sys.stderr)
        return 130
    for sentence in content["warnings"]:
        print(f"note: {sentence}", file=sys.stderr)
    print(content["summary"])
    if proposed is not None and proposed.sentence not in content["summary"]:
        print(proposed.sentence)
    for path in written:
        print(path)
    return 0


def _parser(program: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog=program, **described(__doc__, EXAMPLES))
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="recorded runs of one thruster")
    sets = ", ".join(available_sets())
    text = f"parameter set of the simulator: {sets} or a YAML file"
    parser.add_argument("--set", "--model", dest="set", metavar="SET", required=True, help=text)
    parser.add_argument("--out", type=Path, default=Path("diagnosis"), help="new or empty folder (default diagnosis)")
    parser.add_argument("--thruster", type=int, default=0, help="index of the thruster (default 0)")
    offer_vehicle(parser)
    parser.add_argument("--without", nargs="*", default=[], metavar="EFFECT", help="effects that are not considered")
    parser.add_argument("--seed", type=int, default=0, help="of the bootstrap (default 0)")
    text = f"of recordings that are longer together, use so much, in stretches (default {THINNED:g} beyond {LONGEST:g})"
    parser.add_argument("--longest", type=float, metavar="SECONDS", help=text)
    group = parser.add_argument_group("the next experiment")
    text = "write the throttle programme that best tells apart what these runs cannot"
    group.add_argument("--experiment", action="store_true", help=text)
    text = "that the rig may be given [V] (default: as much as in the runs)"
    group.add_argument("--largest-throttle", type=float, metavar="VOLT", help=text)
    group.add_argument("--experiment-duration", type=float, default=30.0, metavar="SECONDS", help="(default 30)")
    return parser


def _proposed(given: argparse.Namespace, found: Diagnosis, recordings: list[Recording]) -> NextExperiment | None:
    if not given.experiment:
        return None
    _say("next experiment")
    proposed = propose(
        found, recordings, largest=given.largest_throttle, duration=given.experiment_duration, seed=given.seed
    )
    if proposed is None:
        print(
            "note: no next experiment: no two hypotheses are left that these recordings do not tell apart",
            file=sys.stderr,
        )
    return proposed


def _say(stage: str) -> None:
    print(f"  {stage}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
