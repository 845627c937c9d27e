"""A graph for `ros2 launch`: the nodes and parameter files of the shell scripts, with the scripts' arguments.

    ros2 launch rov_sim bench.launch.py reference:=step strategy:=hl-ekf out:=runs/step
    ros2 launch rov_sim vehicle.launch.py out:=runs/dive

The run lies in the folder `out`; when it is over, or a node has ended, everything ends. Nothing is scored here: what
does is printed at the end.
"""

import os
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from ament_index_python.packages import get_package_prefix
from launch import LaunchDescription  # type: ignore[attr-defined]  # not on PyPI; mypy takes our folder launch for it
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    ExecuteProcess,
    LogInfo,
    OpaqueFunction,
    RegisterEventHandler,
    SetEnvironmentVariable,
)
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown

from rov_sim.bench_graph import BenchExperiment, bench_graph, recorder, watch
from rov_sim.cli_rov_graph import experiment_of
from rov_sim.graph_files_io import write_parameters
from rov_sim.vehicle.graph import GraphNode, graph_of

__all__ = ["bench", "vehicle"]

_RANGES = {"machine": "LOCALHOST", "network": "SUBNET"}
_FLAGS = {"real_time": "by the wall's clock instead of in lockstep", "no_noise": "without noise"}
_BENCH = {
    "reference": ("step", "step, triangle, sine"), "strategy": ("hl-ekf", "of the inner loop"),
    "port": ("", "a real device; empty: the emulated bench"), "protocol": ("text", "text, frames"),
    "truth": ("hl_bench", "parameter set of the emulated thruster"), "effects": ("", "its unmodelled effects"),
    "set": ("", "parameter set that observer and law believe in; empty: the strategy's own"),
    "form": ("proper", "proper, bench: how the observer is discretised"), "seed": ("0", "of the emulated noise"),
}  # fmt: skip
_VEHICLE = {
    "vehicle": ("ngs", "vehicle set"), "truth": ("", "parameter set of the true thrusters; empty: the vehicle's own"),
    "strategy": ("hq-ekf", "of the inner loops"), "script": ("surge_and_pitch", "set points of the vehicle"),
    "feedback": ("truth", "truth, estimator"), "rate": ("25", "of all loops [Hz]"),
    "gain": ("2", "of the outer loop [1/s]"),
    "u_max": ("5", "largest throttle [V]"), "allocation": ("least-squares", "pseudo-inverse, direction, least-squares"),
    "set": ("", "parameter set that observers and laws believe in; empty: the strategy's own"),
    "seed": ("0", "of all noise"),
    "effects": ("", "unmodelled effects"), "fail": ("", "such as 'T2 dead at 12 s'"),
    "current": ("0 0 0", "of the water along north, east, down [m/s]"), "sensors": ("", "YAML file of the sensors"),
}  # fmt: skip

_SCORED = "the scores: "

Built = tuple[list[GraphNode], str]


def bench() -> LaunchDescription:
    """Return one experiment on the bench, real or emulated."""

    def build(given: Mapping[str, str], out: Path) -> Built:
        texts = {name: given[name] for name in _BENCH if name != "seed"}
        wanted = BenchExperiment(
            **texts,
            seed=_whole(given, "seed"),
            real_time=_is_on(given, "real_time"),
            noise=not _is_on(given, "no_noise"),
        )
        score = f"score_experiment {out / 'run'} --reference {wanted.reference} --strategy {wanted.strategy}"
        return bench_graph(wanted, out), score

    return _description(_BENCH, build)


def vehicle() -> LaunchDescription:
    """Return one experiment with a vehicle in simulated water."""

    def build(given: Mapping[str, str], out: Path) -> Built:
        arguments = [f"--{name.replace('_', '-')}={given[name]}" for name in _VEHICLE]
        wanted = experiment_of([*arguments, *(f"--{name.replace('_', '-')}" for name in _FLAGS if _is_on(given, name))])
        acknowledge = [f"/thruster_{i}/throttle" for i in range(wanted.thrusters)]
        about = {
            "experiment": "vehicle",
            **{name: getattr(wanted, name) for name in ("strategy", "truth", "seed", "rate")},
        }
        run = recorder(
            out / "run", about, acknowledge=acknowledge, wait_for=[*acknowledge, "/rov/setpoint", "/rov/truth"]
        )
        if wanted.lockstep:
            run = run._replace(parameters={"use_sim_time": True, **run.parameters})
        longest = {"begin": 240.0, "stall": 40.0, "deadline": 3600.0}
        return [run, watch(vehicle=True, **longest), *graph_of(wanted)], f"score_vehicle {out / 'run'}"

    return _description(_VEHICLE, build)


def _description(
    arguments: Mapping[str, tuple[str, str]], build: Callable[[Mapping[str, str], Path], Built]
) -> LaunchDescription:
    declared = {
        **arguments, **{name: ("false", words) for name, words in _FLAGS.items()},
        "out": ("", "new folder for run and parameter files"),
        "network": (os.environ.get("THRUSTER_NETWORK", "machine"), "machine: this one alone; network: who is there"),
    }  # fmt: skip

    def set_up(context: Any) -> list[Any]:
        given = {name: context.launch_configurations[name] for name in declared}
        if given["network"] not in _RANGES:
            raise ValueError(f"network: expected one of {', '.join(_RANGES)}; found {given['network']!r}")
        if not given["out"]:
            raise ValueError("out: expected a new folder, such as out:=runs/first; found none")
        out = Path(given["out"]).absolute()
        if out.exists():
            raise ValueError(f"out: expected a new folder; found {out}, which is there already")
        nodes, score = build(given, out)
        (out / "nodes").mkdir(parents=True)
        write_parameters(out / "nodes", nodes)
        who = "this machine alone" if given["network"] == "machine" else "everybody on this network may take part"
        environment = {
            "ROS_AUTOMATIC_DISCOVERY_RANGE": _RANGES[given["network"]], "THRUSTER_ENDS_WITH": str(os.getpid()),
            "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1",
        }  # fmt: skip
        settings = [SetEnvironmentVariable(name, value) for name, value in environment.items()]
        told = [LogInfo(msg=text) for text in (*_unknown(context.launch_configurations, declared), f"discovery: {who}")]
        return [*settings, *told, *_actions(nodes, out, f"ros2 run rov_sim {score}")]

    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=value, description=words)
                for name, (value, words) in declared.items()
            ),
            OpaqueFunction(function=set_up),
        ]
    )


def _actions(nodes: Sequence[GraphNode], out: Path, score: str) -> list[Any]:
    found = []
    for node in nodes:
        program = Path(get_package_prefix(node.package)) / "lib" / node.package / node.executable
        told = ["-r", f"__node:={node.name}", "--params-file", str(out / "nodes" / f"{node.name}.yaml")]
        for old, new in node.renamed.items():
            told += ["-r", f"{old}:={new}"]
        action = ExecuteProcess(
            cmd=[str(program), "--ros-args", *told], name=node.name, output="screen", sigterm_timeout="10"
        )
        ending: list[Any] = [EmitEvent(event=Shutdown(reason=f"{node.name} has ended"))]
        if node.executable == "experiment_watch":
            ending.insert(0, LogInfo(msg=f"{_SCORED}{score}"))
        found += [RegisterEventHandler(OnProcessExit(target_action=action, on_exit=ending)), action]
    return found


def _unknown(given: Iterable[str], declared: Collection[str]) -> list[str]:
    """Return a sentence for each argument that none of ours is; a launch file that includes this one may know it."""
    found = []
    for name in given:
        if name not in declared:
            (nearest,) = get_close_matches(name, declared, n=1, cutoff=0.0)
            found.append(f"argument {name}: not one of this launch file's, passed over; the nearest is {nearest}")
    return found


def _is_on(given: Mapping[str, str], name: str) -> bool:
    word = given[name].lower()
    if word not in ("true", "false"):
        raise ValueError(f"{name}: expected true or false; found {given[name]!r}")
    return word == "true"


def _whole(given: Mapping[str, str], name: str) -> int:
    if not given[name].isdecimal():
        raise ValueError(f"{name}: expected a whole number from 0; found {given[name]!r}")
    return int(given[name])
