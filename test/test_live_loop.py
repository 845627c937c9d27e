"""Reference, observer and inner loop as nodes in lockstep with a plant, composed: twice the same, and as offline."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter

from thruster_control.inner_loop import AT_REST, compiled_step
from thruster_control.inner_loop_node import InnerLoopNode
from thruster_control.reference_node import ReferenceNode
from thruster_control.references import REFERENCES
from thruster_control.strategies_io import load_strategy
from thruster_estimation import offline
from thruster_estimation.belief import Level, initial_belief, level
from thruster_estimation.observer_node import ObserverNode
from thruster_estimation.settings import SpeedEkfSettings, bench_settings
from thruster_model import flow_tank
from thruster_model.parameter_set_io import load_parameter_set
from thruster_msgs.msg import FlowVelocity, Throttle, ThrusterEstimate, ThrusterState, ThrustSetpoint
from thruster_runtime.executors import make_executor, spin_until
from thruster_runtime.hand_over import hand_over
from thruster_runtime.qos import RECORDER, RELIABLE

PERIOD = 40_000_000  # ns
PERIODS = 200
TRUTH = load_parameter_set("hl_bench").coefficients
TOPICS = {
    "state": ThrusterState, "flow": FlowVelocity, "thrust_setpoint": ThrustSetpoint, "estimate": ThrusterEstimate,
    "throttle": Throttle,
}  # fmt: skip


class Sensors:
    """Readings of the plant with noise that depends on the period alone."""

    def __init__(self) -> None:
        self.noise = np.random.default_rng(11).normal(size=(PERIODS + 1, 2))
        self.state = flow_tank.AT_REST

    def read(self, k: int) -> tuple[float, float]:
        return abs(self.state.n + 1.5 * self.noise[k, 0]), self.state.ambient + 0.01 * self.noise[k, 1]

    def hold(self, u: float) -> None:
        made = flow_tank.simulate(TRUTH, [u], PERIOD / 1e9, initial=self.state)
        self.state = flow_tank.PlantState(made.n[-1], made.v[-1], made.ambient[-1], made.u[-1])


class Plant(Node):
    """Publishes what the sensors read; goes on a period when the throttle of the present stamp has come."""

    def __init__(self, context: Context) -> None:
        super().__init__("plant", context=context)
        self.sensors, self.period = Sensors(), -1
        self.recorded: list[tuple[int, str, str]] = []
        self.messages: dict[str, list[Any]] = {name: [] for name in TOPICS}
        self.outputs = {name: self.create_publisher(TOPICS[name], f"thruster_0/{name}", RELIABLE) for name in TOPICS}
        for name, kind in TOPICS.items():
            self.create_subscription(kind, f"thruster_0/{name}", self._recorder_of(name), RECORDER)
        self.create_subscription(Throttle, "thruster_0/throttle", self._on_throttle, RELIABLE)

    def _recorder_of(self, name: str) -> Callable[[Any], None]:
        def record(message: Any) -> None:
            stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
            # Not the payload's bytes: between its fields are some that the middleware leaves as they were in memory.
            self.recorded.append((stamp, name, repr(message)))
            self.messages[name].append(message)

        return record

    def tick(self) -> None:
        self.period += 1
        n, U = self.sensors.read(self.period)
        # Flow and state in turns, so that no order is what makes it work.
        sent = [("state", ThrusterState(n=n)), ("flow", FlowVelocity(axial=math.nan, ambient=U))]
        for name, message in sent[:: 1 if self.period % 2 else -1]:
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(self.period * PERIOD, 10**9)
            self.outputs[name].publish(message)

    def _on_throttle(self, message: Throttle) -> None:
        assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == self.period * PERIOD
        self.sensors.hold(message.commanded)
        if self.period + 1 < PERIODS:
            self.tick()


def believed_by_observer(strategy: str) -> str:
    """Return the parameter set: no observer works with a steady-flow set."""
    return "simplified" if strategy == "steady-flow" else load_strategy(strategy).strategy.parameter_set


def live(context: Context, strategy: str, kind: str, *, handing_over: bool = False) -> Plant:
    """Run the nodes for all periods in one executor."""

    def options(**values: Any) -> dict[str, Any]:
        overrides = [Parameter(name, value=value) for name, value in {"use_sim_time": True, **values}.items()]
        return {"context": context, "parameter_overrides": overrides}

    chosen = load_strategy(strategy).strategy
    nodes = [ReferenceNode(**options(kind=kind)), InnerLoopNode(**options(strategy=strategy))]
    if chosen.observer != "none":
        nodes.append(ObserverNode(**options(estimator=chosen.observer, parameter_set=believed_by_observer(strategy))))
    handed = hand_over(nodes) if handing_over else []
    plant = Plant(context)
    nodes.append(plant)
    executor = make_executor("events", context=context)
    for node in nodes:
        executor.add_node(node)
    # What a plant needs to know before it starts, the recorder and itself included.
    flow = {"none": 1, "speed-ekf": 1}.get(chosen.observer, 2) + (strategy == "steady-flow")
    state = 2 if chosen.observer != "none" else 3
    heard = {"state": state + (chosen.observer != "none"), "flow": flow, "thrust_setpoint": 2}
    heard["thrust_setpoint"] -= "/thruster_0/thrust_setpoint" in handed
    try:
        assert spin_until(executor, lambda: all(_matched(plant, name, n) for name, n in heard.items()), 20.0)
        spin_until(executor, lambda: False, 0.3)
        plant.tick()
        assert spin_until(executor, lambda: len(plant.messages["throttle"]) == PERIODS, 60.0), plant.period
        spin_until(executor, lambda: all(len(plant.messages[name]) == PERIODS for name in ("state", "flow")), 5.0)
    finally:
        for node in nodes:
            executor.remove_node(node)
        executor.shutdown()
        for node in nodes:
            node.destroy_node()
    return plant


def _matched(plant: Plant, name: str, count: int) -> bool:
    return plant.outputs[name].get_subscription_count() >= count


class Offline(NamedTuple):
    """Estimates and throttles of the step functions, (PERIODS, 3) and (PERIODS,)."""

    estimates: np.ndarray
    throttles: np.ndarray


def offline_loop(strategy: str, kind: str) -> Offline:
    """Run the same loop with the step functions alone."""
    ready = load_strategy(strategy)
    sensors, memory, u, estimates, throttles = Sensors(), AT_REST, math.nan, [], []
    observed = ready.strategy.observer != "none"
    belief = settings = None
    p = load_parameter_set(believed_by_observer(strategy)).coefficients
    if observed:
        settings = bench_settings(ready.strategy.observer, k_U=p.k_U)
    for k in range(PERIODS):
        n, U = sensors.read(k)
        x, valid = (math.nan, math.nan, math.nan), False
        if observed:
            if belief is None:
                belief = initial_belief(n, 0.0, U, deviation_n=20.0, deviation_v=0.1, deviation_U=0.1)
            one_state = isinstance(settings, SpeedEkfSettings)
            y_U, dt = math.nan if one_state else U, PERIOD / 1e9 if k else 0.0
            belief, _ = offline.compiled_step(belief, n, y_U, dt, u, settings, p)
            valid = level(belief.status) != Level.INVALID
            x = (belief.n, math.nan, math.nan) if one_state else (belief.n, belief.v, belief.U)
        T_d = float(REFERENCES[kind].thrust(k * PERIOD / 1e9))
        ambient = U if strategy == "steady-flow" else x[2]
        memory, out = compiled_step(
            memory, T_d, x[0], x[1], ambient, valid, PERIOD / 1e9, ready.settings, ready.coefficients, math.nan, 0.0
        )
        u = out.u
        sensors.hold(u)
        estimates.append(x)
        throttles.append(u)
    return Offline(np.array(estimates), np.array(throttles))


@pytest.mark.parametrize(
    ("strategy", "kind"), [("hl-ekf", "step"), ("hq-nlo", "sine"), ("steady-flow", "ramp"), ("lookup", "ramp")]
)
def test_a_composed_run_in_lockstep_is_the_same_twice_and_the_offline_loop(
    fresh_context: Callable[[], Context], strategy: str, kind: str
) -> None:
    first, second = (live(fresh_context(), strategy, kind) for _ in range(2))
    assert sorted(first.recorded) == sorted(second.recorded)
    offline_run = offline_loop(strategy, kind)
    commanded = np.array([message.commanded for message in first.messages["throttle"]])
    assert np.ptp(commanded) > 0.5, "the loop does something"
    np.testing.assert_allclose(commanded, offline_run.throttles, rtol=0.0, atol=1e-12)
    if strategy == "lookup":
        assert not first.messages["estimate"]
        return
    estimates = np.array([(m.n, m.v, m.ambient) for m in first.messages["estimate"]])
    np.testing.assert_allclose(estimates, offline_run.estimates, rtol=0.0, atol=1e-12)


def test_nodes_that_hand_their_messages_over_send_out_the_same(fresh_context: Callable[[], Context]) -> None:
    handed, sent = (live(fresh_context(), "hl-ekf", "step", handing_over=over) for over in (True, False))
    assert sorted(handed.recorded) == sorted(sent.recorded)
