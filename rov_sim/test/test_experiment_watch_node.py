"""The watch of an experiment: over after the run, or in time with a sentence and what the others said."""

import math
import threading
from collections.abc import Callable
from functools import partial

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter

from rov_sim.experiment_watch_node import ExperimentWatch
from thruster_msgs.msg import ThrustSetpoint, VehicleSetpoint
from thruster_runtime.executors import spin_until
from thruster_runtime.qos import RELIABLE


class Scene:
    """A watch whose wall clock the test moves, and somebody who publishes."""

    def __init__(self, context: Context, spun: Callable[..., Executor], *, vehicle: bool = False) -> None:
        self.stop, self.now = threading.Event(), 0.0
        given = [Parameter("start_delay", value=1.0), Parameter("tail", value=0.5), Parameter("vehicle", value=vehicle)]
        self.watch = ExperimentWatch(self.stop, monotonic=lambda: self.now, context=context, parameter_overrides=given)
        self.node = Node("others", context=context)
        kind, topic = (VehicleSetpoint, "rov/setpoint") if vehicle else (ThrustSetpoint, "thruster_0/thrust_setpoint")
        self.set_points = self.node.create_publisher(kind, topic, RELIABLE)
        self.health = self.node.create_publisher(DiagnosticArray, "/diagnostics", RELIABLE)
        self.executor = spun(self.watch, self.node, kind="single")
        connected = lambda: self.set_points.get_subscription_count() and self.health.get_subscription_count()  # noqa: E731
        assert spin_until(self.executor, lambda: bool(connected()), 10.0)

    def ask(self, milliseconds: int) -> None:
        message = ThrustSetpoint(thrust=1.0)
        message.header.stamp.sec, rest = divmod(milliseconds, 1000)
        message.header.stamp.nanosec = 1_000_000 * rest
        self.set_points.publish(message)

    def tell(self, milliseconds: int, pitch: float) -> None:
        """Publish a vehicle's set point; NaN: taken back."""
        message = VehicleSetpoint(attitude=[pitch, pitch, pitch])
        message.header.stamp.sec, rest = divmod(milliseconds, 1000)
        message.header.stamp.nanosec = 1_000_000 * rest
        self.set_points.publish(message)

    def ends(self, timeout: float) -> bool:
        return spin_until(self.executor, self.stop.is_set, timeout)


@pytest.fixture
def watching(context: Context, spun: Callable[..., Executor]) -> Callable[..., Scene]:
    return partial(Scene, context, spun)


@pytest.mark.parametrize("late", [False, True])
def test_a_vehicle_s_run_is_over_once_its_set_point_is_taken_back_also_for_a_watch_that_heard_that_alone(
    watching: Callable[..., Scene], late: bool
) -> None:
    scene = watching(vehicle=True)
    for k in range(0 if late else 3):
        scene.tell(1_000 + 40 * k, 0.1)
    scene.tell(5_000, math.nan)
    scene.tell(5_400, math.nan)
    assert not scene.ends(0.4)
    scene.tell(5_500, math.nan)
    assert scene.ends(5.0) and scene.watch.trouble == ""


def test_it_ends_well_once_the_run_and_its_tail_are_over(watching: Callable[..., Scene]) -> None:
    scene = watching()
    scene.ask(5_000)
    scene.ask(5_000 + 11_499)
    assert not scene.ends(0.4)
    scene.ask(5_000 + 11_500)
    assert scene.ends(5.0)
    assert scene.watch.trouble == ""


@pytest.mark.parametrize(
    ("begun", "later", "said"),
    [
        (lambda scene: None, 61.0, "no set point within 60 s"),
        (lambda scene: scene.ask(0), 31.0, "no further set point within 30 s"),
    ],
)
def test_it_ends_in_time_and_names_who_is_not_well(
    watching: Callable[..., Scene], begun: Callable[[Scene], None], later: float, said: str
) -> None:
    scene = watching()
    begun(scene)
    statuses = [
        DiagnosticStatus(name="/driver", level=DiagnosticStatus.ERROR, message="absent"),
        DiagnosticStatus(name="/observer", level=DiagnosticStatus.OK, message="estimating"),
    ]
    scene.health.publish(DiagnosticArray(status=statuses))
    assert not scene.ends(0.4)
    scene.now = later
    assert scene.ends(5.0)
    assert scene.watch.trouble == said
    assert scene.watch.unwell() == ["/driver: absent"]


def test_a_watch_that_is_stopped_is_no_success(watching: Callable[..., Scene]) -> None:
    scene = watching()
    assert scene.watch.trouble == "it was stopped before the run was over"
