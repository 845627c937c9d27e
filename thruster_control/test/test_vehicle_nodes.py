"""The wires of allocator and vehicle_reference: one test for each topic, what fails, and what is refused."""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped, WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from scipy.spatial.transform import Rotation
from std_msgs.msg import Header

from thruster_control import allocator_parameters, vehicle_reference_node
from thruster_control.allocation.failures import FailureKind
from thruster_control.allocator_node import AllocatorNode
from thruster_control.allocator_parameters import chosen_loop
from thruster_control.outer_loop.settings import VehicleSetPoint
from thruster_control.vehicle_reference_node import VehicleReferenceNode
from thruster_control.vehicle_set_points import set_point_at
from thruster_control.vehicle_set_points_io import load_script
from thruster_msgs.msg import ThrusterEstimate, ThrusterFailure, ThrustSetpoint, VehicleSetpoint
from thruster_runtime.errors import StartRefused
from thruster_runtime.executors import spin_until
from thruster_runtime.qos import RELIABLE

PERIOD = 40_000_000  # ns
THRUSTERS = 6
KINDS: dict[str, Any] = {
    "rov/odometry": Odometry, "rov/setpoint": VehicleSetpoint, "rov/thruster_failure": ThrusterFailure,
    "rov/operator": TwistStamped, "rov/wrench": WrenchStamped,
    **{f"thruster_{i}/thrust_setpoint": ThrustSetpoint for i in range(THRUSTERS)},
    **{f"thruster_{i}/estimate": ThrusterEstimate for i in range(THRUSTERS)},
}  # fmt: skip
ETA, NU = (0.1, -0.2, 0.3), (0.2, -0.1, 0.05, 0.1, -0.05, 0.2)
SP = VehicleSetPoint((0.0, 0.1, 0.5), (0.05, -0.1, 0.2), (0.01, 0.02, -0.03), (0.3, 0.0, 0.0), (0.05, 0.0, 0.0))
COMPILED_FOR_SECONDS = ("linear", "pid")
GIVEN = {each.name: each.default for each in allocator_parameters.PARAMETERS}
Spun = Callable[..., Executor]


class Scene:
    """A node in simulated time, and one that plays the rest."""

    def __init__(self, context: Context, spun: Spun, subject: type[Node] = AllocatorNode, **values: Any) -> None:
        given = {"use_sim_time": True, **values}
        self.subject = subject(context=context, parameter_overrides=[Parameter(k, value=v) for k, v in given.items()])
        self.rest = Node("rest", context=context)
        out = {p.topic_name.lstrip("/") for p in self.subject.publishers} & set(KINDS)
        self.heard: dict[str, list[Any]] = {name: [] for name in out}
        for name, messages in self.heard.items():
            self.rest.create_subscription(KINDS[name], name, messages.append, RELIABLE)
        self.told: list[DiagnosticArray] = []
        self.rest.create_subscription(DiagnosticArray, "/diagnostics", self.told.append, RELIABLE)
        wanted = {s.topic_name.lstrip("/") for s in self.subject.subscriptions} & set(KINDS)
        self.sent = {name: self.rest.create_publisher(KINDS[name], name, RELIABLE) for name in wanted}
        self.clock = self.rest.create_publisher(Clock, "/clock", RELIABLE)
        self.executor = spun(self.subject, self.rest)
        known = [p for p in self.subject.publishers if p.topic_name.lstrip("/") in out or "diag" in p.topic_name]
        wires = [*self.sent.values(), self.clock, *known]
        assert spin_until(self.executor, lambda: all(p.get_subscription_count() for p in wires), 10.0)

    def send(self, topic: str, k: float, message: Any) -> None:
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(round(k * PERIOD), 10**9)
        self.sent[topic].publish(message)

    def odometry(
        self, k: int, eta: Any = ETA, nu: Any = NU, frames: tuple[str, str] = ("map_ned", "base_link_frd")
    ) -> None:
        message = Odometry(child_frame_id=frames[1])
        message.header.frame_id = frames[0]
        q = message.pose.pose.orientation
        q.x, q.y, q.z, q.w = map(float, Rotation.from_euler("ZYX", eta[::-1]).as_quat())
        linear, angular = message.twist.twist.linear, message.twist.twist.angular
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z = map(float, nu)
        self.send("rov/odometry", k, message)

    def set_point(self, k: int, sp: VehicleSetPoint = SP) -> None:
        self.send("rov/setpoint", k, VehicleSetpoint(**{name: list(part) for name, part in sp._asdict().items()}))

    def fail(self, thruster: int, kind: int, **sizes: float) -> None:
        known = {"effectiveness": math.nan, "stuck_thrust": math.nan, **sizes}
        self.send("rov/thruster_failure", 0, ThrusterFailure(thruster=thruster, kind=kind, **known))
        self.wait(0.2)

    def wait(self, seconds: float) -> None:
        spin_until(self.executor, lambda: False, seconds)

    def set_time(self, nanoseconds: int) -> None:
        message = Clock()
        message.clock.sec, message.clock.nanosec = divmod(nanoseconds, 10**9)
        self.clock.publish(message)
        now = self.subject.get_clock().now
        assert spin_until(self.executor, lambda: now().nanoseconds == nanoseconds, 5.0)

    def after(self, count: int, topic: str, timeout: float = 5.0) -> list[Any]:
        """Return the messages once that many have come, and a little longer."""
        spin_until(self.executor, lambda: len(self.heard[topic]) >= count, timeout)
        spin_until(self.executor, lambda: len(self.heard[topic]) > count, 0.1)
        return self.heard[topic]

    def thrusts(self, count: int, timeout: float = 5.0) -> list[list[float]]:
        """Return the thrusts of each instant, once so many have come from all thrusters."""
        columns = [self.after(count, f"thruster_{i}/thrust_setpoint", timeout) for i in range(THRUSTERS)]
        return [[message.thrust for message in row] for row in zip(*columns, strict=True)]

    def says(self, words: str) -> bool:
        return bool(spin_until(self.executor, lambda: any(words in a.status[0].message for a in self.told), 5.0))


@pytest.fixture
def running(context: Context, spun: Spun) -> Callable[..., Scene]:
    return partial(Scene, context, spun)


def expected(eta: Any = ETA, nu: Any = NU, U: float = math.nan, **values: Any) -> list[float]:
    """Return the first thrusts of the loop, called as offline code calls it."""
    loop, _ = chosen_loop({**GIVEN, **values})
    assert loop is not None
    x, y, z, w = Rotation.from_euler("ZYX", eta[::-1]).as_quat()
    given = np.array(nu, dtype=np.float64), SP, np.full(THRUSTERS, U)
    return loop.advance(None, (w, x, y, z), *given).thrusts.tolist()  # type: ignore[no-any-return]


# ---- allocator


def test_odometry_waits_for_the_set_point_of_its_stamp_and_becomes_thrusts_and_a_wrench(
    running: Callable[..., Scene],
) -> None:
    scene = running()
    scene.odometry(25)
    assert scene.thrusts(0, 0.2) == []
    scene.set_point(25)
    (found,) = scene.thrusts(1)
    assert found == pytest.approx(expected(), abs=1e-12)
    assert max(map(abs, found)) > 1.0
    (wrench,) = scene.after(1, "rov/wrench")
    assert wrench.header.frame_id == "base_link_frd"
    for message in (wrench, scene.heard["thruster_3/thrust_setpoint"][0]):
        assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 0)
    assert scene.says("following the set point")


def test_the_wrench_is_that_of_2_22(running: Callable[..., Scene], ngs: Any) -> None:
    scene = running(law="euler", method="pseudo-inverse")
    scene.set_point(0)
    scene.odometry(0)
    (found,) = scene.thrusts(1)
    assert found == pytest.approx(
        [8.817924866, 5.7592052358, 6.7014129705, 7.9775092305, -9.9946469163, -6.6279172923], abs=1e-9
    )
    (message,) = scene.after(1, "rov/wrench")
    f, m = message.wrench.force, message.wrench.torque
    assert [f.x, f.y, f.z, m.x, m.y, m.z] == pytest.approx((ngs @ found).tolist(), abs=1e-9)


def test_gains_change_while_it_runs_little_by_little_without_a_jump_of_the_wrench(
    running: Callable[..., Scene],
) -> None:
    scene = running(AllocatorNode, K_P_linear=1.0)
    answered = [Parameter("K_P_linear", value=4), Parameter("K_P_angular", value=-1.0), Parameter("law", value="pid")]
    surges = []
    for k in range(40):
        scene.set_point(k)
        scene.odometry(k)
        surges.append(scene.after(k + 1, "rov/wrench")[k].wrench.force.x)
        if k == 5:
            done, wrong, fixed = scene.subject.set_parameters(answered)
            assert done.successful
            assert "K_P_angular [1/s]: expected a finite number above 0 and up to 100; found -1.0" in wrong.reason
            assert "law: fixed at start" in fixed.reason
    steps = np.abs(np.diff(surges))
    whole = abs(surges[-1] - surges[5])
    assert whole > 1.0
    assert np.max(steps) < 1.5 * whole * 0.04, "over a second, in steps of a period"
    assert np.all(steps[-5:] < 1e-9)
    assert surges[:6] == pytest.approx(6 * [surges[0]])


def test_observers_inflow_is_waited_for_and_used_on_request(running: Callable[..., Scene]) -> None:
    scene = running(estimated_inflow=True)
    scene.set_point(0)
    scene.odometry(0)
    assert scene.thrusts(0, 0.2) == []
    for i in range(THRUSTERS):
        scene.send(f"thruster_{i}/estimate", 0, ThrusterEstimate(n=0.0, v=0.0, ambient=0.3, status=0))
    assert scene.thrusts(1) == [pytest.approx(expected(U=0.3), abs=1e-12)]
    assert expected(U=0.3) != pytest.approx(expected(), abs=1e-3), "less is left at 0.3 m/s"


def test_a_dead_thruster_is_left_out_and_what_is_lost_is_said(running: Callable[..., Scene], ngs: Any) -> None:
    scene = running(method="pseudo-inverse")
    scene.fail(4, FailureKind.DEAD)
    scene.set_point(0)
    scene.odometry(0)
    (found,) = scene.thrusts(1)
    (message,) = scene.after(1, "rov/wrench")
    wanted = message.wrench.torque
    assert found[4] == 0.0
    assert (ngs @ found)[3:] == pytest.approx([wanted.x, wanted.y, wanted.z], abs=1e-9)
    assert scene.says("thruster 4 is dead; K_t has rank 5 of 6: no control of heave (0.83) with surge (0.55)")
    scene.fail(4, FailureKind.NONE)
    scene.set_point(1)
    scene.odometry(1)
    assert scene.thrusts(2)[1][4] != 0.0


def test_an_unknown_stuck_thrust_is_the_last_one_asked_for(running: Callable[..., Scene], ngs: Any) -> None:
    scene = running(law="euler", method="pseudo-inverse")
    scene.set_point(0)
    scene.odometry(0)
    (before,) = scene.thrusts(1)
    scene.fail(0, FailureKind.STUCK)
    scene.set_point(1)
    scene.odometry(1)
    found = scene.thrusts(2)[1]
    assert found[0] == 0.0
    assert (ngs @ [before[0], *found[1:]])[3:] == pytest.approx((ngs @ before)[3:], abs=1e-9)
    assert scene.says(f"thruster 0 is stuck at {before[0]:g} N")


def test_a_report_that_cannot_be_is_not_used(running: Callable[..., Scene]) -> None:
    scene = running()
    scene.fail(9, FailureKind.DEAD)
    scene.fail(1, 77)
    scene.set_point(0)
    scene.odometry(0)
    assert scene.thrusts(1) == [pytest.approx(expected(), abs=1e-12)]


def test_a_set_point_that_is_lost_is_held_for_its_time_out_and_then_no_thrust_is_asked_for(
    running: Callable[..., Scene],
) -> None:
    scene = running(setpoint_timeout=0.2, wait_for_setpoint=False)
    scene.set_point(0)
    scene.wait(0.2)
    for k in range(9):
        scene.odometry(k)
        scene.thrusts(k + 1, 1.0)
    found = scene.thrusts(9)
    assert all(any(row) for row in found[:6]), "0.2 s are five periods"
    assert all(row == [0.0] * THRUSTERS for row in found[6:])
    assert scene.says("no set point: no thrust")


def test_a_set_point_with_nan_is_none(running: Callable[..., Scene]) -> None:
    scene = running()
    scene.set_point(0, SP._replace(velocity=(math.nan, 0.0, 0.0)))
    scene.odometry(0)
    assert scene.thrusts(1) == [[0.0] * THRUSTERS]


def test_without_odometry_no_thrust_is_asked_for_within_its_time_out(running: Callable[..., Scene]) -> None:
    scene = running(odometry_timeout=0.2)
    scene.set_time(10**9)
    scene.set_point(25)
    scene.odometry(25)
    assert any(scene.thrusts(1)[0])
    for step in range(1, 6):
        scene.set_time(10**9 + step * 50_000_000)
        scene.wait(0.05)
    found = scene.thrusts(2)
    assert found[1] == [0.0] * THRUSTERS and len(found) == 2
    assert scene.says("no odometry: no thrust")
    scene.set_point(26)
    scene.odometry(26)  # late: measured before time ran out
    scene.thrusts(3)
    stamps = [Time.from_msg(each.header.stamp).nanoseconds for each in scene.heard["thruster_0/thrust_setpoint"]]
    assert stamps == sorted(stamps), "stamps never run backwards"


def test_odometry_in_other_frames_is_answered_with_no_thrust_and_named(running: Callable[..., Scene]) -> None:
    scene = running()
    scene.set_point(0)
    scene.odometry(0, frames=("map", "base_link"))
    assert scene.thrusts(1) == [[0.0] * THRUSTERS]
    assert scene.says("odometry in 'map' and 'base_link': expected map_ned and base_link_frd: no thrust")


def test_without_linear_velocity_attitude_is_held_and_said(running: Callable[..., Scene]) -> None:
    scene = running()
    scene.set_point(0)
    scene.odometry(0, nu=(math.nan, math.nan, math.nan, *NU[3:]))
    (found,) = scene.thrusts(1)
    assert any(found) and all(map(math.isfinite, found))
    assert scene.says("linear velocity is unknown")


def test_the_last_word_of_the_allocator_takes_the_requests_back(running: Callable[..., Scene]) -> None:
    scene = running()
    scene.subject.on_stop()  # type: ignore[attr-defined]
    (found,) = scene.thrusts(1)
    assert all(map(math.isnan, found))


@pytest.mark.parametrize(
    "law",
    [
        pytest.param(law, marks=pytest.mark.long if law in COMPILED_FOR_SECONDS else ())
        for law in allocator_parameters.LAWS
    ],
)
def test_every_law_can_be_chosen_by_name(law: str) -> None:
    thrusts = expected(law=law)
    assert all(map(math.isfinite, thrusts)) and any(thrusts)


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"vehicle": "submarine"}, "parameter vehicle: submarine: expected a YAML file or one of the known"),
        ({"parameter_set": "none"}, "parameter parameter_set: none: expected a YAML file or one of the known sets"),
        ({"law": "lqr"}, "law: expected one of quaternion, euler, linear, pid; found 'lqr'"),
        ({"given_up": "pitch, depth"}, "given_up: expected axes among surge, .*; found depth"),
        ({"K_P_linear": 0.0}, r"K_P_linear \[1/s\]: expected a finite number above 0"),
    ],
    ids=str,
)
def test_wrong_parameters_of_the_allocator_are_refused_in_a_sentence(
    context: Context, values: dict[str, Any], sentence: str
) -> None:
    with pytest.raises(StartRefused, match=sentence):
        AllocatorNode(context=context, parameter_overrides=[Parameter(k, value=v) for k, v in values.items()])


# ---- vehicle_reference


def test_each_odometry_is_answered_by_the_script_s_set_point_of_its_stamp(running: Callable[..., Scene]) -> None:
    scene = running(VehicleReferenceNode, script="surge_and_pitch", start_delay=0.4)
    ticks = (50, 60, 185, 5000)
    for k in ticks:
        scene.odometry(k)
    messages = scene.after(4, "rov/setpoint")
    script = load_script("surge_and_pitch")
    for k, message in zip(ticks, messages, strict=True):
        wanted = set_point_at(script, max(k * 0.04 - 2.4, 0.0))
        assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == k * PERIOD
        assert list(message.attitude) == pytest.approx(wanted.attitude, nan_ok=True)
        assert list(message.acceleration) == pytest.approx(wanted.acceleration, nan_ok=True)
    assert messages[2].attitude[1] > 0.0 and math.isnan(messages[3].attitude[1])
    assert scene.says("the script surge_and_pitch has ended: no set point")


def test_the_script_begins_once_the_topic_that_is_waited_for_has_a_publisher(running: Callable[..., Scene]) -> None:
    scene = running(VehicleReferenceNode, script="surge_and_pitch", start_delay=0.4, wait_for="recorder/recorded")
    for k in (50, 185):
        scene.odometry(k)
    assert [message.attitude[1] for message in scene.after(2, "rov/setpoint")] == [0.0, 0.0]
    assert scene.says("holding the beginning of the script surge_and_pitch: nobody publishes recorder/recorded")
    scene.rest.create_publisher(Header, "recorder/recorded", RELIABLE)
    count = scene.subject.count_publishers
    assert spin_until(scene.executor, lambda: count("recorder/recorded") == 1, 10.0)
    for k in (200, 335):
        scene.odometry(k)
    found = scene.after(4, "rov/setpoint")[2:]
    assert [m.attitude[1] for m in found] == [0.0, set_point_at(load_script("surge_and_pitch"), 5.0).attitude[1]]
    assert found[1].attitude[1] > 0.0 and scene.says("following the script surge_and_pitch")


def test_an_operator_steers_from_the_heading_there_is_and_its_loss_keeps_the_attitude(
    running: Callable[..., Scene],
) -> None:
    scene = running(VehicleReferenceNode, source="operator", operator_timeout=0.2)
    scene.odometry(0, eta=(0.3, 0.2, 1.0))
    twist = TwistStamped()
    twist.twist.linear.x, twist.twist.angular.z = 0.4, 0.5
    for k in range(1, 40):
        if k < 20:
            scene.send("rov/operator", k, twist)
            scene.wait(0.02)
        scene.odometry(k, eta=(0.3, 0.2, 1.0))
        scene.after(k + 1, "rov/setpoint", 1.0)
    found = scene.after(40, "rov/setpoint")
    assert list(found[0].attitude) == pytest.approx([0.0, 0.0, 1.0]), "level, on its heading"
    assert found[19].velocity[0] > 0.3 and found[19].attitude[2] > 1.1
    assert list(found[-1].attitude_rate) == [0.0, 0.0, 0.0]
    assert found[-1].velocity[0] < found[24].velocity[0]
    assert found[-1].attitude[2] == found[-2].attitude[2] > 1.2
    assert scene.says("an operator steers") and scene.says("no operator: the vehicle stops and keeps its attitude")


def test_without_a_heading_an_operator_has_no_set_point(running: Callable[..., Scene]) -> None:
    scene = running(VehicleReferenceNode, source="operator", trigger="timer", period=0.1)
    scene.set_time(10**9)
    assert math.isnan(scene.after(1, "rov/setpoint")[0].attitude[0])
    assert scene.says("heading is not known yet")


def test_a_timer_ticks_with_its_period(running: Callable[..., Scene]) -> None:
    scene = running(VehicleReferenceNode, script="hover", trigger="timer", period=0.1)
    scene.set_time(10**9)
    scene.wait(0.2)
    scene.heard["rov/setpoint"].clear()
    scene.set_time(10**9 + 150_000_000)
    (message,) = scene.after(1, "rov/setpoint")
    assert (message.header.stamp.nanosec, list(message.attitude)) == (150_000_000, [0.0, 0.0, 0.0])


def test_the_last_word_of_the_reference_takes_the_set_point_back(running: Callable[..., Scene]) -> None:
    scene = running(VehicleReferenceNode)
    scene.subject.on_stop()  # type: ignore[attr-defined]
    (message,) = scene.after(1, "rov/setpoint")
    assert math.isnan(message.attitude[0]) and math.isnan(message.acceleration[2])


def test_a_script_that_is_not_there_is_refused_in_a_sentence(context: Context) -> None:
    with pytest.raises(StartRefused, match="parameter script: loops: expected a YAML file or one of the known scripts"):
        VehicleReferenceNode(context=context, parameter_overrides=[Parameter("script", value="loops")])


@pytest.mark.parametrize(
    ("file", "table"),
    [("allocator", allocator_parameters.PARAMETERS), ("vehicle_reference", vehicle_reference_node.PARAMETERS)],
    ids=["allocator", "vehicle_reference"],
)
def test_the_parameter_file_holds_every_parameter_at_its_default(file: str, table: Any) -> None:
    text = (Path(__file__).parents[1] / f"config/{file}.yaml").read_text("utf-8")
    given = yaml.safe_load(text)["/**"]["ros__parameters"]
    assert {name: str(value) for name, value in given.items()} == {p.name: str(p.default) for p in table}
