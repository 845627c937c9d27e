"""A vehicle's whole graph in one process: one content of one seed, who is missing is named, what is lost is zero."""

import importlib
import os
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter

from rov_sim.vehicle.graph import Experiment, graph_of
from rov_sim.vehicle.plant_node import PlantNode
from rov_sim.vehicle.sensors.settings_io import load_sensors
from run_bag.known_topics import KNOWN, KNOWN_VEHICLE
from thruster_runtime.executors import make_executor, spin_until
from thruster_runtime.hand_over import hand_over
from thruster_runtime.qos import RECORDER
from thruster_runtime.simulated_time import share_clock
from thruster_runtime.stamps import nanoseconds

PERIODS = 60
SCRIPT = "moves:\n  - {time: 0.2, shape: quintic, duration: 1.5, size: {surge: 0.2, pitch: 0.2}}\nend: 30.0\n"


@pytest.fixture
def fresh_context() -> Iterator[Callable[[], Context]]:
    """Make graphs of their own."""
    made: list[Context] = []

    def fresh() -> Context:
        made.append(Context())
        rclpy.init(args=[], context=made[-1], domain_id=int(os.environ.get("ROS_DOMAIN_ID", os.getpid() % 101 + 1)))
        return made[-1]

    yield fresh
    for context in made:
        rclpy.try_shutdown(context=context)


def kind_of(name: str) -> type:
    package, _, kind = name.replace("/msg/", ".msg:").partition(":")
    return getattr(importlib.import_module(package), kind)  # type: ignore[no-any-return]


class Recorder(Node):
    """Keeps the payload of every message by stamp and topic."""

    def __init__(self, context: Context, thrusters: int) -> None:
        super().__init__("listener", context=context)
        self.content: list[tuple[int, str, str]] = []
        topics = {name: kind for name, kind in KNOWN_VEHICLE.items() if name != "rov/operator"}
        names = ("state", "flow", "thrust_setpoint", "estimate", "throttle", "truth")
        topics |= {f"thruster_{i}/{name}": KNOWN[name] for i in range(thrusters) for name in names}
        for topic, kind in topics.items():
            self.create_subscription(kind_of(kind), topic, self._keeping(topic), RECORDER)

    def _keeping(self, topic: str) -> Callable[[Any], None]:
        def keep(message: Any) -> None:
            self.content.append((nanoseconds(message.header.stamp), topic, repr(message)))

        return keep

    def until(self, stamp: int) -> list[tuple[int, str, str]]:
        return sorted(entry for entry in self.content if entry[0] < stamp)


class Graph:
    """To be closed. `leave_out`: nodes that are not there; `change`: parameters by node."""

    def __init__(
        self,
        context: Context,
        script: Path,
        *,
        handing_over: bool = False,
        leave_out: tuple[str, ...] = (),
        change: Mapping[str, Mapping[str, Any]] | None = None,
        **given: Any,
    ) -> None:
        experiment = Experiment(
            thrusters=6, sensors=load_sensors(), recorded=False, script=str(script), start_delay=0.2, **given
        )
        self.nodes: dict[str, Node] = {}
        for node in graph_of(experiment):
            if node.name in leave_out:
                continue
            module, _, kind = node.kind.partition(":")
            values = {**node.parameters, **(change or {}).get(node.name, {})}
            self.nodes[node.name] = getattr(importlib.import_module(module), kind)(
                context=context,
                cli_args=["--ros-args", "-r", f"__node:={node.name}"],
                parameter_overrides=[Parameter(name, value=value) for name, value in values.items()],
            )
        share_clock(list(self.nodes.values()))
        if handing_over:
            hand_over(list(self.nodes.values()))
        self.listener = Recorder(context, 6)
        self.nodes["listener"] = self.listener
        self.executor = make_executor("events", context=context)
        for each in self.nodes.values():
            self.executor.add_node(each)

    @property
    def plant(self) -> PlantNode:
        node = self.nodes["plant"]
        assert isinstance(node, PlantNode)
        return node

    def run(self, periods: int, longest: float = 90.0) -> None:
        end = periods * 40_000_000
        assert spin_until(self.executor, lambda: self.plant.vehicle.time >= end, longest), self.plant.waiting_for()

    def close(self) -> None:
        if not self.nodes:
            return
        for node in self.nodes.values():
            self.executor.remove_node(node)
        self.executor.shutdown()
        for node in self.nodes.values():
            node.destroy_node()
        self.nodes = {}


@pytest.fixture
def make(fresh_context: Callable[[], Context], tmp_path: Path) -> Iterator[Callable[..., Graph]]:
    graphs: list[Graph] = []
    script = tmp_path / "script.yaml"
    script.write_text(SCRIPT, "utf-8")

    def made(**given: Any) -> Graph:
        graphs.append(Graph(fresh_context(), script, **given))
        return graphs[-1]

    yield made
    for graph in graphs:
        graph.close()


def test_one_seed_has_one_content_handed_over_or_not_and_the_vehicle_follows(make: Callable[..., Graph]) -> None:
    found = []
    for over in (False, True):
        graph = make(handing_over=over, seed=3)
        graph.run(PERIODS + 3)
        found.append(graph.listener.until(PERIODS * 40_000_000))
        truth = graph.plant.vehicle._plant.truth()
        assert 0.1 < truth.velocity[0] < 0.25, "it surges"
        graph.close()
    assert len({topic for _, topic, _ in found[0]}) == 6 * 6 + 8
    assert found[0] == found[1]


def test_a_failed_thruster_is_reported_and_the_others_carry_the_wrench(make: Callable[..., Graph]) -> None:
    graph = make(change={"plant": {"failures": "T2 dead at 0.8 s"}}, handing_over=True)
    graph.run(PERIODS)
    content = graph.listener.until(PERIODS * 40_000_000)
    assert [stamp for stamp, topic, _ in content if topic == "rov/thruster_failure"] == [800_000_000]
    asked = [(stamp, text) for stamp, topic, text in content if topic == "thruster_1/thrust_setpoint"]
    assert all("thrust=0.0)" in text for stamp, text in asked if stamp > 840_000_000)
    assert not all("thrust=0.0)" in text for stamp, text in asked if stamp < 800_000_000)


@pytest.mark.parametrize("missing", ["vehicle_reference", "allocator", "inner_loop_2"])
def test_time_does_not_begin_without_a_node_and_its_topic_is_named(make: Callable[..., Graph], missing: str) -> None:
    graph = make(leave_out=(missing,), change={"plant": {"timeout": 0.3}})
    topic = {"vehicle_reference": "rov/setpoint", "allocator": "rov/wrench", "inner_loop_2": "thruster_2/throttle"}
    said = f"a publisher and a subscription of {topic[missing]}"
    spin_until(graph.executor, lambda: False, 1.0)
    assert said in graph.plant.waiting_for() and graph.plant.vehicle.time == 0


@pytest.mark.parametrize("lost", ["vehicle_reference", "allocator", "inner_loop_2"])
def test_in_lockstep_time_stops_when_a_node_is_lost_and_it_is_named(make: Callable[..., Graph], lost: str) -> None:
    graph = make()
    graph.run(10)
    node = graph.nodes.pop(lost)
    graph.executor.remove_node(node)
    spin_until(graph.executor, lambda: False, 0.3)  # what has come for it already
    node.destroy_node()
    gone = f"{lost} is gone"
    assert spin_until(graph.executor, lambda: any(gone in each for each in graph.plant.waiting_for()), 20.0)
    time = graph.plant.vehicle.time
    spin_until(graph.executor, lambda: False, 0.5)
    assert graph.plant.vehicle.time == time


@pytest.mark.parametrize("lost", ["vehicle_reference", "allocator", "inner_loop_2", "navigation"])
def test_in_real_time_the_loss_of_a_node_is_zero_throttle_within_a_fifth_of_a_second(
    make: Callable[..., Graph], lost: str
) -> None:
    graph = make(lockstep=False, feedback="estimator", handing_over=False)
    held = graph.plant._held
    monotonic = graph.plant._monotonic
    turning = lambda: all(abs(u) > 0.3 for u in held.at(monotonic()))  # noqa: E731
    assert spin_until(graph.executor, turning, 30.0), held.silent(monotonic())
    node = graph.nodes.pop(lost)
    graph.executor.remove_node(node)
    begin = monotonic()
    affected = [2] if lost == "inner_loop_2" else range(6)
    stopped = lambda: all(held.at(monotonic())[i] == 0.0 for i in affected)  # noqa: E731
    assert spin_until(graph.executor, stopped, 5.0)
    assert monotonic() - begin < 0.2
    node.destroy_node()
