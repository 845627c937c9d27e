"""A recorded dive played to observers and allocator: they answer what they answered then."""

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from rclpy.context import Context
from rclpy.node import Node
from vehicle_graph import experiment_of, made, recorder_of

from rov_sim.vehicle.graph import graph_of
from run_bag import read_run
from run_bag.cli_play import options
from run_bag.comparison import compared
from run_bag.live.player_node import PlayerNode
from thruster_runtime.executors import make_executor, spin_until
from thruster_runtime.simulated_time import share_clock

PERIODS = 50


def answers(thrusters: int, observed: bool) -> list[str]:
    """Return OUTPUT:INPUT of all that allocator and observers publish."""
    found = ["rov/wrench:rov/odometry"]
    for i in range(thrusters):
        found += [f"thruster_{i}/{name}:rov/odometry" for name in ("thrust_setpoint", "flow")]
        found += [f"thruster_{i}/estimate:thruster_{i}/state"] if observed else []
    return found


def replayed(context: Context, dive: Path, out: Path, script: Path, **given: Any) -> None:
    """Play a dive to observers and allocator and record what is on the topics."""
    experiment = experiment_of(script, **given)
    nodes: list[Node] = [
        made(node, context) for node in graph_of(experiment) if node.executable in ("observer", "allocator")
    ]
    share_clock(nodes)
    outputs = answers(6, experiment.observer != "none")
    recorder = recorder_of(context, out, acknowledge=["/" + each.partition(":")[0] for each in outputs])
    stop = threading.Event()
    command = [str(dive), "--step", "--timeout", "600", "--wait-for", *outputs, "recorder/recorded:rov/odometry"]
    player = PlayerNode(options(command), stop, context=context)
    executor = make_executor("events", context=context)
    nodes += [recorder, player]
    for node in nodes:
        executor.add_node(node)
    try:
        assert spin_until(executor, stop.is_set, 900.0)
    finally:
        player.on_stop()  # says why it ended before its time
        recorder.on_stop()
        for node in nodes:
            executor.remove_node(node)
        executor.shutdown()
        for node in nodes:
            node.destroy_node()


@pytest.mark.parametrize(("strategy", "feedback"), [("hq-ekf", "truth"), ("hl-nlo", "estimator"), ("lookup", "truth")])
def test_observers_and_allocator_answer_a_played_dive_as_they_answered_the_vehicle(
    make: Callable[..., Any], fresh_context: Callable[[], Context], tmp_path: Path, strategy: str, feedback: str
) -> None:
    graph = make(record=tmp_path / "dive", handing_over=True, strategy=strategy, feedback=feedback, seed=5)
    graph.run(PERIODS)
    graph.close()
    given = {"strategy": strategy, "feedback": feedback, "seed": 5}
    replayed(fresh_context(), tmp_path / "dive", tmp_path / "again", tmp_path / "script.yaml", **given)
    names = [each.partition(":")[0] for each in answers(6, strategy != "lookup")]
    found = compared(read_run(tmp_path / "dive"), read_run(tmp_path / "again"), names)
    assert {each.topic for each in found} == set(names)
    assert min(each.both for each in found) >= PERIODS - 1
    assert [each for each in found if each.differ or each.one_alone > 1 or each.other_alone] == []
