"""The graph's closed loop against the offline one: two ways to the same experiment."""

import numpy as np
import pytest
from bench_graph import Graph, parameters
from rclpy.context import Context

from rov_sim.bench_study.controllers import controller
from rov_sim.closed_loop import Plant, Timing, simulate_loop
from rov_sim.emulated_bench import QUIET
from rov_sim.experiment_scores import Recorded, experiment_of
from thruster_control.inner_loop_node import InnerLoopNode
from thruster_control.reference_node import ReferenceNode
from thruster_control.references import REFERENCES
from thruster_control.scores import tracking_scores
from thruster_estimation.observer_node import ObserverNode
from thruster_model.parameter_set_io import load_parameter_set

IDLE = 0.4  # s of 0 N before the run


def live(context: Context, kind: str, throttle: str) -> Graph:
    """Return the graph after an experiment with hl-ekf on a bench without noise; text at 25 Hz, HL on HL."""
    wires = " ".join(f"thruster_0/{name}" for name in ("state", "flow", "estimate", "thrust_setpoint", "throttle"))
    graph = Graph(context, driver={"use_sim_time": True}, wires=wires, parameter_set="hl")
    own = {"use_sim_time": True}
    graph.add(
        ObserverNode(
            context=context,
            parameter_overrides=parameters(estimator="ekf", parameter_set="hl", throttle=throttle, **own),
        ),
        InnerLoopNode(context=context, parameter_overrides=parameters(strategy="hl-ekf", **own)),
        ReferenceNode(context=context, parameter_overrides=parameters(kind=kind, start_delay=IDLE, **own)),
    )
    assert graph.until(11.5, 120.0), graph.bench.waiting_for()
    return graph


def recorded(graph: Graph, topic: str, value: str) -> Recorded:
    values = np.array([getattr(message, value) for message in graph.heard[topic]])
    return Recorded(time=1e-9 * np.array(graph.stamps(topic)), values=values)


def offline(kind: str) -> tuple[float, np.ndarray, np.ndarray]:
    """Return (RMSE [N], throttle [V], thrust [N]) of the same experiment without ROS."""
    p = load_parameter_set("hl").coefficients
    time = 0.04 * np.arange(250)
    idle = round(IDLE / 0.04)
    wanted = np.concatenate([np.zeros(idle), REFERENCES[kind].thrust(time)])
    run = simulate_loop(
        wanted, Plant(coefficients=p), controller("hl-ekf", p, form="proper", beliefs="published"), rig=QUIET,
        timing=Timing(sample=0.0, computation=0.04),
    )  # fmt: skip
    u, force = run.of("u")[idle:], run.force[idle:]
    return tracking_scores(time, force, u, REFERENCES[kind]).rmse, u, force


@pytest.mark.parametrize(("throttle", "apart_u", "apart_T"), [("commanded", 1e-3, 0.05), ("sent", 0.03, 0.2)])
def test_the_graphs_experiment_is_the_offline_loops(
    context: Context, throttle: str, apart_u: float, apart_T: float
) -> None:
    """The observer told of commands as the offline one computes the same throttles; told what really acted, nearly.

    The thrust is apart by what happens in the 4 ms that a count takes on the line, which the offline loop leaves out.
    """
    graph = live(context, "sine", throttle)
    load = np.array([message.wrench.force.x for message in graph.heard["daq/thruster_0/load"]])
    found = experiment_of(
        "sine",
        recorded(graph, "thruster_0/thrust_setpoint", "thrust"),
        recorded(graph, "thruster_0/throttle", "commanded"),
        Recorded(time=1e-9 * np.array(graph.stamps("daq/thruster_0/load")), values=load),
        recorded(graph, "thruster_0/truth", "thrust"),
    )
    graph.close()
    rmse, u, force = offline("sine")
    assert rms(found.u - u) < apart_u
    assert rms(found.load - force) < apart_T
    assert found.scores.rmse == pytest.approx(rmse, abs=0.04)
    assert found.true_scores.rmse == pytest.approx(found.scores.rmse, rel=0.05)


def rms(x: np.ndarray) -> float:
    return float(np.sqrt(np.mean(x**2)))
