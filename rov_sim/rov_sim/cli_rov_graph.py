"""Write the parameters of a vehicle's graph into a folder, and say which nodes to start.

Prints one line for each node: NAME PACKAGE EXECUTABLE [OLD:=NEW ...]. In the folder: NAME.yaml for each of them as
`--params-file` takes it, and composed.yaml for `ros2 run thruster_runtime compose`.
"""

import argparse
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rov_sim.bench_graph import problem_of_port
from rov_sim.graph_files_io import line_of, write_document, write_parameters
from rov_sim.vehicle.effects.words import effects_of_words
from rov_sim.vehicle.failure_words import parse_failures
from rov_sim.vehicle.graph import EMULATED, FIRMWARE, Experiment, graph_of
from rov_sim.vehicle.live import LiveSettings
from rov_sim.vehicle.sensors.settings_io import load_sensors
from rov_sim.vehicle.settings import vehicle_settings
from run_bag.command_line import user_arguments
from thruster_model.errors import ThrusterModelError
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.vehicle_set_io import load_vehicle_set

__all__ = ["experiment_of", "main"]

_PORTS = "PORT may be 'emulated', or 'firmware': the board's own on an emulated processor"
_DEFAULT = Experiment(thrusters=1, sensors=load_sensors())


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="rov_graph", description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="the folder, which exists")
    for name in ("vehicle", "truth", "strategy", "script", "feedback", "set", "allocation", "given-up"):
        parser.add_argument(f"--{name}", default=getattr(_DEFAULT, name.replace("-", "_")))
    for name, unit in (("rate", "Hz"), ("gain", "1/s"), ("u-max", "V"), ("start-delay", "s")):
        default = getattr(_DEFAULT, name.replace("-", "_"))
        parser.add_argument(f"--{name}", type=float, default=default, help=f"[{unit}]")
    parser.add_argument("--seed", type=int, default=_DEFAULT.seed)
    parser.add_argument("--sensors", default="", help="YAML file of the sensors")
    parser.add_argument("--effects", default="", help="of the plant")
    parser.add_argument("--fail", default="", help="such as 'T2 dead at 12 s'")
    parser.add_argument("--current", default="0 0 0", help="of the water along north, east, down [m/s]")
    parser.add_argument("--random-wrench", default="0 0 0 0 0 0", help="standard deviations [N, N m]")
    parser.add_argument("--no-noise", action="store_true", help="of odometry and sensors")
    parser.add_argument("--no-flow", action="store_true", help="observers are told no ambient flow")
    parser.add_argument("--scene", action="store_true", help="a node draws for viewers")
    parser.add_argument("--watch", default="", metavar="RUN", help="a node watches, taught by a healthy vehicle's run")
    parser.add_argument("--real-time", action="store_true", help="by the wall's clock")
    parser.add_argument("--hardware", action="append", default=[], metavar="T1=PORT", help=_PORTS)
    parser.add_argument("--firmware", default="", help="folder in which the firmware was built, for T1=firmware")
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the files; return the exit status."""
    given = _parser().parse_args(user_arguments(arguments))
    try:
        experiment = _experiment(given)
        _refuse(experiment)
        nodes = graph_of(experiment, link=str(given.out.absolute() / "port"), firmware=given.firmware)
        write_parameters(given.out, nodes)
        entries = [
            {"class": node.kind, "name": node.name, "parameters": dict(node.parameters)}
            for node in nodes
            if not node.renamed
        ]
        write_document(
            given.out / "composed.yaml", {"nodes": entries, "hand_over": not given.hardware}
        )  # else a driver is not heard
    except (ValueError, OSError, ThrusterModelError) as error:
        print(error, file=sys.stderr)
        return 2
    for node in nodes:
        print(line_of(node))
    return 0


def _refuse(experiment: Experiment) -> None:
    """Refuse failures, effects, ports and a run to watch by that the nodes would refuse or wait for, before anything is
    started."""
    vehicle = load_vehicle_set(experiment.vehicle)
    sets = [load_parameter_set(name) for name in experiment.truth.split() or vehicle.models]
    effects = effects_of_words(str(experiment.plant.get("effects", "")).split())
    failures, lost = parse_failures(str(experiment.plant.get("failures", "")))
    plant = vehicle_settings(vehicle, sets, effects=effects)
    LiveSettings(plant=plant, sensors=experiment.sensors, failures=failures, lost=lost)
    if experiment.watched and not Path(experiment.watched).exists():
        raise ValueError(f"watch: expected a run of the healthy vehicle; {experiment.watched} does not exist")
    for i, port in experiment.hardware.items():
        if port not in (EMULATED, FIRMWARE) and (problem := problem_of_port(port)):
            raise ValueError(f"hardware: T{i + 1}: {problem}")


def experiment_of(arguments: Sequence[str]) -> Experiment:
    """Return what the command line (without `--out`) asks for; `ros2 launch` takes the same arguments.

    Raises:
        ValueError, OSError, ThrusterModelError: what is wrong with it.
    """
    return _experiment(_parser().parse_args(["--out", ".", *arguments]))


def _experiment(given: argparse.Namespace) -> Experiment:
    plant: dict[str, Any] = {
        "effects": given.effects, "failures": given.fail, "current": given.current,
        "random_wrench": given.random_wrench,
    }  # fmt: skip
    if given.no_noise:
        plant["noise"] = False
    return Experiment(
        thrusters=load_vehicle_set(given.vehicle).coefficients.thrusters, sensors=load_sensors(given.sensors or None),
        vehicle=given.vehicle, truth=given.truth, strategy=given.strategy, script=given.script,
        start_delay=given.start_delay, feedback=given.feedback, rate=given.rate, gain=given.gain, u_max=given.u_max,
        set=given.set, allocation=given.allocation, given_up=given.given_up,
        flow=not given.no_flow, sensors_file=given.sensors, plant=plant,
        scene=given.scene, watched=str(Path(given.watch).absolute()) if given.watch else "", seed=given.seed,
        lockstep=not given.real_time, hardware=dict(map(_hardware, given.hardware)),
    )  # fmt: skip


def _hardware(word: str) -> tuple[int, str]:
    match = re.fullmatch(r"T([1-9]\d*)=(.+)", word)
    if match is None:
        raise ValueError(f"hardware: expected T1=PORT, T1=emulated or T1=firmware; found {word!r}")
    return int(match[1]) - 1, match[2]


if __name__ == "__main__":
    sys.exit(main())
