"""The wires of inner loop and reference: one test for each topic, and what is refused."""

import math
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import BatteryState

from thruster_control import inner_loop_parameters, reference_node
from thruster_control.inner_loop import AT_REST, compiled_step
from thruster_control.inner_loop_node import InnerLoopNode
from thruster_control.reference_node import ReferenceNode
from thruster_control.strategies_io import load_strategy
from thruster_msgs.msg import (
    FlowVelocity,
    Throttle,
    ThrusterEstimate,
    ThrusterFailure,
    ThrusterState,
    ThrustSetpoint,
)
from thruster_runtime.errors import StartRefused
from thruster_runtime.executors import spin_until
from thruster_runtime.qos import RELIABLE

PERIOD = 40_000_000  # ns
KINDS = {
    "state": ThrusterState, "flow": FlowVelocity, "load": WrenchStamped, "estimate": ThrusterEstimate,
    "thrust_setpoint": ThrustSetpoint, "throttle": Throttle, "battery": BatteryState,
}  # fmt: skip
KNOWN = {"n": 60.0, "v": 0.1, "ambient": 0.1}
Spun = Callable[..., Executor]


class Scene:
    """A node of thruster 1 in simulated time, and one that plays the rest."""

    def __init__(self, context: Context, spun: Spun, subject: type[Node] = InnerLoopNode, **values: Any) -> None:
        given = {"thruster": 1, "use_sim_time": True, **values}
        self.subject = subject(context=context, parameter_overrides=[Parameter(k, value=v) for k, v in given.items()])
        self.rest = Node("rest", context=context)
        self.heard: dict[str, list[Any]] = {name: [] for name in ("throttle", "thrust_setpoint")}
        for name, messages in self.heard.items():
            self.rest.create_subscription(KINDS[name], f"thruster_1/{name}", messages.append, RELIABLE)
        self.told: list[DiagnosticArray] = []
        self.rest.create_subscription(DiagnosticArray, "/diagnostics", self.told.append, RELIABLE)
        heard = {s.topic_name for s in self.subject.subscriptions}
        topics = {name: "/rov/battery" if name == "battery" else f"/thruster_1/{name}" for name in KINDS}
        self.sent = {n: self.rest.create_publisher(KINDS[n], t, RELIABLE) for n, t in topics.items() if t in heard}
        self.clock = self.rest.create_publisher(Clock, "/clock", RELIABLE)
        self.executor = spun(self.subject, self.rest)
        out = [p for p in self.subject.publishers if "thruster_1" in p.topic_name or "diag" in p.topic_name]
        wires = [*self.sent.values(), self.clock, *out]
        assert spin_until(self.executor, lambda: all(p.get_subscription_count() for p in wires), 10.0)

    def send(self, name: str, k: int, **fields: Any) -> None:
        message = KINDS[name](**fields)
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(k * PERIOD, 10**9)
        self.sent[name].publish(message)

    def estimate(self, k: int, **fields: Any) -> None:
        self.send("estimate", k, **{**KNOWN, **fields})

    def set_point(self, k: int, thrust: float) -> None:
        self.send("thrust_setpoint", k, thrust=thrust)

    def set_time(self, nanoseconds: int) -> None:
        message = Clock()
        message.clock.sec, message.clock.nanosec = divmod(nanoseconds, 10**9)
        self.clock.publish(message)
        now = self.subject.get_clock().now
        assert spin_until(self.executor, lambda: now().nanoseconds == nanoseconds, 5.0)

    def after(self, count: int, name: str = "throttle", timeout: float = 5.0) -> list[Any]:
        """Return the messages once that many have come, and a little longer."""
        spin_until(self.executor, lambda: len(self.heard[name]) >= count, timeout)
        spin_until(self.executor, lambda: len(self.heard[name]) > count, 0.1)
        return self.heard[name]

    def throttles(self, count: int, timeout: float = 5.0) -> list[float]:
        return [message.commanded for message in self.after(count, timeout=timeout)]


@pytest.fixture
def running(context: Context, spun: Spun) -> Callable[..., Scene]:
    return partial(Scene, context, spun)


def law(strategy: str, T_d: float, n: float, v: float, U: float, T: float = math.nan) -> float:
    """Return the first throttle of a strategy [V]."""
    ready = load_strategy(strategy)
    return float(compiled_step(AT_REST, T_d, n, v, U, True, 0.04, ready.settings, ready.coefficients, T, 0.0)[1].u)


# ---- inner loop


def test_an_estimate_waits_for_the_set_point_of_its_stamp_and_becomes_a_throttle(running: Callable[..., Scene]) -> None:
    scene = running()
    scene.estimate(25)
    assert scene.throttles(0, 0.2) == []
    scene.set_point(25, 5.0)
    (message,) = scene.after(1)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 0)
    assert message.commanded == law("hl-ekf", 5.0, 60.0, 0.1, 0.1) > 1.0
    assert math.isnan(message.sent)


def test_the_lookup_table_takes_states_for_ticks(running: Callable[..., Scene]) -> None:
    scene = running(strategy="lookup")
    scene.set_point(0, 5.0)
    scene.send("state", 0, n=math.nan)
    assert scene.throttles(1) == [law("lookup", 5.0, math.nan, math.nan, math.nan)]


@pytest.mark.parametrize(("volts", "supply"), [(12.6, 0.9), (math.nan, 1.0)])
def test_the_force_table_is_looked_up_at_the_measured_supply_voltage(
    running: Callable[..., Scene], volts: float, supply: float
) -> None:
    scene = running(strategy="force-table")
    scene.set_point(0, 20.0)
    scene.send("state", 0, n=math.nan, supply_voltage=volts)
    ready = load_strategy("force-table")
    arguments = (math.nan, math.nan, math.nan, True, 0.04, ready.settings, ready.coefficients, math.nan, 0.0, supply)
    assert scene.throttles(1) == [float(compiled_step(AT_REST, 20.0, *arguments)[1].u)]
    assert scene.throttles(1)[0] > 2.5


def test_the_force_table_waits_for_a_slower_battery_and_takes_its_voltage(running: Callable[..., Scene]) -> None:
    scene = running(strategy="force-table", battery_every=0.25)
    scene.set_point(10, 20.0)
    scene.send("battery", 0, voltage=14.0)
    scene.send("state", 10, n=math.nan, supply_voltage=math.nan)
    assert scene.throttles(0, 0.2) == []  # that voltage is older than the next one can be
    scene.send("battery", 5, voltage=12.25)
    ready = load_strategy("force-table")
    arguments = (math.nan, math.nan, math.nan, True, 0.04, ready.settings, ready.coefficients, math.nan, 0.0, 0.875)
    assert scene.throttles(1) == [float(compiled_step(AT_REST, 20.0, *arguments)[1].u)]


def test_the_steady_flow_law_takes_the_measured_ambient_flow(running: Callable[..., Scene]) -> None:
    scene = running(strategy="steady-flow")
    scene.set_point(0, 5.0)
    scene.estimate(0, v=math.nan, ambient=math.nan)
    assert scene.throttles(0, 0.2) == []
    scene.send("flow", 0, axial=math.nan, ambient=0.3)
    assert scene.throttles(1) == [law("steady-flow", 5.0, 60.0, math.nan, 0.3)]


def test_the_thrust_loop_feeds_the_load_cell_back_on_request(running: Callable[..., Scene]) -> None:
    scene = running(strategy="pi-thrust", load_cell=True)
    scene.set_point(0, 5.0)
    scene.estimate(0)
    assert scene.throttles(0, 0.2) == []
    message = WrenchStamped()
    message.wrench.force.x = 3.0
    scene.send("load", 0, wrench=message.wrench)
    expected = law("pi-thrust", 5.0, 60.0, 0.1, 0.1, 3.0)
    assert scene.throttles(1) == [expected]
    assert expected != law("pi-thrust", 5.0, 60.0, 0.1, 0.1)


def test_an_estimate_that_is_too_old_or_invalid_is_not_used(running: Callable[..., Scene]) -> None:
    fresh, stale, invalid = [], [], []
    scene = running()
    for found, age, status in ((fresh, 0, 0), (stale, 200_000_000, 0), (invalid, 0, 2)):
        scene.heard["throttle"].clear()
        for k in (0, 1):
            scene.set_time(k * PERIOD + (age if k else 0) + 1)
            scene.set_point(k, 5.0)
            scene.estimate(k, n=60.0 - 30.0 * k, status=status if k else 0)
        found += scene.throttles(2)
    assert stale[1] == invalid[1] < fresh[1], "the speed that fell is not fed back"


def test_without_an_estimate_for_too_long_the_throttle_runs_down_and_health_says_so(
    running: Callable[..., Scene],
) -> None:
    scene = running()
    for k in range(30):
        scene.set_point(k, 5.0)
        scene.estimate(k, status=ThrusterEstimate.STATUS_INVALID if k else 0)
        scene.after(k + 1, timeout=1.0)
    found = scene.throttles(30)
    assert found[1] > 1.0 and found[-1] == 0.0
    assert spin_until(scene.executor, lambda: any("runs down" in a.status[0].message for a in scene.told), 5.0)


def test_a_set_point_is_held_for_its_time_out_and_then_the_throttle_runs_down(running: Callable[..., Scene]) -> None:
    scene = running(setpoint_timeout=0.2, wait_for_setpoint=False)
    scene.set_point(0, 5.0)
    spin_until(scene.executor, lambda: False, 0.2)  # nothing waits for it
    for k in range(20):
        scene.estimate(k)
        scene.after(k + 1, timeout=1.0)
    found = scene.throttles(20)
    assert min(found[:6]) > 1.0, "0.2 s are five periods"
    assert found[6] < found[5] and found[-1] == 0.0


def test_a_set_point_that_is_lost_costs_one_period_and_is_told(running: Callable[..., Scene]) -> None:
    scene = running()
    scene.set_point(0, 5.0)
    scene.estimate(0)
    assert len(scene.after(1)) == 1
    for k in (1, 2):
        scene.estimate(k)
    assert len(scene.after(2)) == 2
    scene.set_point(2, 5.0)
    assert len(scene.after(3)) == 3
    for k in range(3, 30):  # the counts are told once a second
        scene.set_point(k, 5.0)
        scene.estimate(k)
        scene.after(k + 1, timeout=1.0)
    before = len(scene.told)
    scene.set_time(2 * 10**9)
    assert spin_until(scene.executor, lambda: len(scene.told) > before, 5.0)
    assert {pair.key: pair.value for pair in scene.told[-1].status[0].values}["missing setpoint"] == "1"


def test_a_thruster_whose_speed_is_reported_lost_goes_on_by_its_table_until_it_is_well_again(
    running: Callable[..., Scene],
) -> None:
    scene = running(strategy="hl-ekf")
    failures = scene.rest.create_publisher(ThrusterFailure, "rov/thruster_failure", RELIABLE)
    assert spin_until(scene.executor, lambda: failures.get_subscription_count() == 1, 5.0)
    scene.estimate(0)
    scene.set_point(0, 5.0)
    scene.after(1)
    failures.publish(ThrusterFailure(thruster=2, kind=ThrusterFailure.KIND_NO_SPEED))  # another one
    failures.publish(ThrusterFailure(thruster=1, kind=ThrusterFailure.KIND_NO_SPEED))
    spin_until(scene.executor, lambda: False, 0.2)
    for k in range(1, 40):  # for longer than a lost estimate is bridged
        scene.estimate(k, n=math.nan, v=math.nan, status=ThrusterEstimate.STATUS_INVALID)
        scene.set_point(k, 5.0)
        scene.after(k + 1, timeout=1.0)
    ready = load_strategy("lookup", parameter_set="hl")
    _, out = compiled_step(
        AT_REST, 5.0, math.nan, 0.0, 0.0, False, 0.04, ready.settings, ready.coefficients, math.nan, 0.0, 1.0
    )
    assert scene.throttles(40)[-1] == pytest.approx(out.u) and out.u > 1.0
    assert spin_until(scene.executor, lambda: any("without feedback" in a.status[0].message for a in scene.told), 5.0)
    failures.publish(ThrusterFailure(thruster=1, kind=ThrusterFailure.KIND_NONE))
    spin_until(scene.executor, lambda: False, 0.2)
    for k in range(40, 80):
        scene.estimate(k, n=math.nan, status=ThrusterEstimate.STATUS_INVALID)
        scene.set_point(k, 5.0)
        scene.after(k + 1, timeout=1.0)
    assert scene.throttles(80)[-1] == 0.0


def test_time_that_begins_again_begins_the_loop_again(running: Callable[..., Scene]) -> None:
    scene = running()
    for k in (100, 101, 0):
        scene.set_point(k, 5.0)
        scene.estimate(k)
        scene.after(len(scene.heard["throttle"]) + 1, timeout=1.0)
    found = scene.throttles(3)
    assert found[2] == found[0] != found[1]


def test_the_last_word_of_the_inner_loop_is_no_throttle(running: Callable[..., Scene]) -> None:
    scene = running()
    scene.subject.on_stop()  # type: ignore[attr-defined]
    assert scene.throttles(1) == [0.0]


def test_the_last_word_is_not_stamped_before_the_last_throttle_where_the_clock_comes_late(
    running: Callable[..., Scene],
) -> None:
    scene = running()
    for k in (10, 11):
        scene.set_point(k, 5.0)
        scene.estimate(k)
        scene.after(k - 9)
    scene.set_time(10 * PERIOD)
    scene.subject.on_stop()  # type: ignore[attr-defined]
    stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in scene.after(3)]
    assert stamps == [10 * PERIOD, 11 * PERIOD, 11 * PERIOD]


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"strategy": "pid"}, "strategy: expected one of lookup, simplified, .*; found 'pid'"),
        ({"parameter_set": "none"}, "parameter none: expected a YAML file or one of the known sets"),
        ({"parameter_set": "kim_chung"}, "hl-ekf: expected a set of the thesis' common form"),
        ({"strategy": "lookup", "k_P": 3.0}, "k_P: expected a number of TableLaw; it has none such"),
        ({"u_max": 0.0}, r"u_max \[V\]: expected a finite number above 0, or NaN for none; found 0.0"),
        ({"load_cell": True}, "load_cell: expected the strategy pi-thrust; found hl-ekf"),
        ({"rate_form": "bench", "rate_time": 0.0}, "rate_time: expected more than 0 s with the bench's form"),
    ],
    ids=str,
)
def test_wrong_parameters_are_refused_in_a_sentence(context: Context, values: dict[str, Any], sentence: str) -> None:
    with pytest.raises(StartRefused, match=sentence):
        InnerLoopNode(context=context, parameter_overrides=[Parameter(k, value=v) for k, v in values.items()])


def test_gains_and_limits_given_as_parameters_reach_the_law(context: Context) -> None:
    values = {"k_P": 7.0, "rate_form": "none", "u_max": 2}
    node = InnerLoopNode(context=context, parameter_overrides=[Parameter(k, value=v) for k, v in values.items()])
    settings = node._with_speed
    assert (settings.gains.k_P, settings.gains.k_I, settings.gains.rate_form) == (7.0, 10.0, 2)
    assert settings.limits.u_max == 2.0
    node.destroy_node()


def changed(node: Node, **values: Any) -> str:
    """Return what setting a running node's parameters together is answered."""
    result = node.set_parameters_atomically([Parameter(name, value=value) for name, value in values.items()])
    return "" if result.successful else str(result.reason)


def test_gains_change_while_it_runs_without_a_jump_of_the_throttle(running: Callable[..., Scene]) -> None:
    scene = running()

    def drive(k: int) -> None:
        scene.set_point(k, 5.0)
        scene.estimate(k)
        assert spin_until(scene.executor, lambda: len(scene.heard["throttle"]) > k - 25, 10.0)

    for k in range(25, 35):
        drive(k)
    before = scene.throttles(10)[-1]
    assert changed(scene.subject, k_P=9, rate_form="bench", rate_time=0.04, u_max=2.9) == ""
    for k in range(35, 70):
        drive(k)
    after = [before, *scene.throttles(45)[10:]]
    assert max(abs(b - a) for a, b in pairwise(after)) <= 5.0 * 0.04 + 1e-9
    assert scene.subject._with_speed.gains.k_P == 9.0  # type: ignore[attr-defined]
    ready = load_strategy("hl-ekf")
    law = ready.settings._replace(gains=ready.settings.gains._replace(k_P=9.0, rate_form=1, rate_time=0.04))
    jump = compiled_step(AT_REST, 5.0, 60.0, 0.1, 0.1, True, 0.04, law, ready.coefficients, math.nan, 0.0)[1].u
    assert abs(jump - before) > 0.4, "such a change would jump"


def test_what_is_wrong_with_a_change_is_said_as_at_the_start_and_changes_nothing(running: Callable[..., Scene]) -> None:
    node = running(strategy="lookup").subject
    before = node._with_speed  # type: ignore[attr-defined]
    assert changed(node, hysteresis=-1.0) == (
        "/inner_loop: parameter hysteresis [N]: expected a finite number from 0; found -1.0"
    )
    assert changed(node, k_P=3.0) == "/inner_loop: parameter k_P: expected a number of TableLaw; it has none such"
    assert changed(node, strategy="hl-ekf").startswith("/inner_loop: parameter strategy: fixed at start")
    assert node._with_speed is before  # type: ignore[attr-defined]


# ---- reference


def test_each_state_is_answered_by_a_set_point_of_its_stamp(running: Callable[..., Scene]) -> None:
    scene = running(ReferenceNode, kind="step", start_delay=0.04)
    for k in (50, 51, 176, 177):  # the delay ends at 51, the step comes 5 s later
        scene.send("state", k, n=0.0)
    messages = scene.after(4, "thrust_setpoint")
    assert [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in messages] == [
        k * PERIOD for k in (50, 51, 176, 177)
    ]
    assert [m.thrust for m in messages] == [0.0, -10.0, 10.0, 10.0]


def test_ticks_that_begin_again_begin_the_set_point_again(running: Callable[..., Scene]) -> None:
    scene = running(ReferenceNode, kind="step")
    for k in (100, 250, 10):
        scene.send("state", k, n=0.0)
    assert [m.thrust for m in scene.after(3, "thrust_setpoint")] == [-10.0, 10.0, -10.0]


def test_a_timer_of_simulated_time_ticks_with_its_period(running: Callable[..., Scene]) -> None:
    scene = running(ReferenceNode, kind="constant", level=3.0, trigger="timer", period=0.1)
    scene.set_time(10**9)
    spin_until(scene.executor, lambda: False, 0.2)  # the timer's first tick, overdue since time 0
    scene.heard["thrust_setpoint"].clear()
    scene.set_time(10**9 + 150_000_000)
    (message,) = scene.after(1, "thrust_setpoint")
    assert (message.thrust, message.header.stamp.nanosec) == (3.0, 150_000_000)


def test_level_and_kind_of_the_set_point_change_while_it_runs(running: Callable[..., Scene]) -> None:
    scene = running(ReferenceNode, kind="constant", level=3.0, repeats=0, start_delay=0.04)
    for k in (50, 51):
        scene.send("state", k, n=0.0)
    assert [m.thrust for m in scene.after(2, "thrust_setpoint")] == [0.0, 3.0]
    assert changed(scene.subject, level=4) == ""
    scene.send("state", 52, n=0.0)
    assert scene.after(3, "thrust_setpoint")[-1].thrust == 4.0
    assert changed(scene.subject, kind="step") == ""
    scene.send("state", 53, n=0.0)  # the step begins at its beginning
    scene.send("state", 180, n=0.0)
    assert [m.thrust for m in scene.after(5, "thrust_setpoint")][3:] == [-10.0, 10.0]
    assert "expected one of" in changed(scene.subject, kind="square")
    assert "start_delay: fixed at start" in changed(scene.subject, start_delay=0.0)


def test_no_thrust_is_asked_for_before_the_topic_that_is_waited_for_has_a_publisher(
    running: Callable[..., Scene],
) -> None:
    scene = running(ReferenceNode, kind="constant", level=3.0, wait_for="recorder/recorded")
    scene.send("state", 50, n=0.0)
    assert math.isnan(scene.after(1, "thrust_setpoint")[0].thrust)
    scene.rest.create_publisher(Clock, "recorder/recorded", RELIABLE)
    count = scene.subject.count_publishers
    assert spin_until(scene.executor, lambda: count("recorder/recorded") == 1, 10.0)
    scene.send("state", 51, n=0.0)
    assert scene.after(2, "thrust_setpoint")[1].thrust == 3.0


def test_the_last_word_of_the_reference_takes_the_request_back(running: Callable[..., Scene]) -> None:
    scene = running(ReferenceNode)
    scene.subject.on_stop()  # type: ignore[attr-defined]
    (message,) = scene.after(1, "thrust_setpoint")
    assert math.isnan(message.thrust)


@pytest.mark.parametrize(
    ("file", "table"),
    [("inner_loop", inner_loop_parameters.PARAMETERS), ("reference", reference_node.PARAMETERS)],
    ids=["inner_loop", "reference"],
)
def test_the_parameter_file_holds_every_parameter_at_its_default(file: str, table: Any) -> None:
    text = (Path(__file__).parents[1] / f"config/{file}.yaml").read_text("utf-8")
    given = yaml.safe_load(text)["/**"]["ros__parameters"]
    assert {name: str(value) for name, value in given.items()} == {p.name: str(p.default) for p in table}
