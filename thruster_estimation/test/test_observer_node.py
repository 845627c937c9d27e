"""The observer's wires: one test for each topic, and what is refused."""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter

from thruster_estimation.observer_node import ObserverNode
from thruster_estimation.observer_parameters import PARAMETERS
from thruster_estimation.online import START, Measured, advance
from thruster_estimation.settings import bench_settings
from thruster_model.parameter_set_io import load_parameter_set
from thruster_msgs.msg import FlowVelocity, Throttle, ThrusterEstimate, ThrusterState
from thruster_runtime.errors import StartRefused
from thruster_runtime.executors import spin_until
from thruster_runtime.qos import RELIABLE

PERIOD = 40_000_000  # ns
INPUTS = {"state": ThrusterState, "flow": FlowVelocity, "throttle": Throttle, "throttle_sent": Throttle}


class Scene:
    """An observer of thruster 2, and a node that plays the rest."""

    def __init__(self, context: Context, spun: Callable[..., Executor], **values: Any) -> None:
        overrides = [Parameter(name, value=value) for name, value in {"thruster": 2, **values}.items()]
        self.subject = ObserverNode(context=context, parameter_overrides=overrides)
        self.rest = Node("rest", context=context)
        self.sent = {name: self.rest.create_publisher(t, f"thruster_2/{name}", RELIABLE) for name, t in INPUTS.items()}
        self.estimates: list[ThrusterEstimate] = []
        self.told: list[DiagnosticArray] = []
        self.rest.create_subscription(ThrusterEstimate, "thruster_2/estimate", self.estimates.append, RELIABLE)
        self.rest.create_subscription(DiagnosticArray, "/diagnostics", self.told.append, RELIABLE)
        self.executor = spun(self.subject, self.rest)
        heard = [s.topic_name for s in self.subject.subscriptions]
        ready = [p for name, p in self.sent.items() if f"/thruster_2/{name}" in heard]
        out = [p for p in self.subject.publishers if "estimate" in p.topic_name or "diag" in p.topic_name]
        assert spin_until(self.executor, lambda: all(p.get_subscription_count() for p in [*ready, *out]), 10.0)

    def send(self, name: str, k: int, **fields: Any) -> None:
        message = INPUTS[name](**fields)
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(k * PERIOD, 10**9)
        message.header.frame_id = "duct"
        self.sent[name].publish(message)

    def state(self, k: int, n: float, **fields: Any) -> None:
        self.send("state", k, n=n, **fields)

    def count(self, expected: int, timeout: float = 5.0) -> bool:
        """Return whether exactly that many estimates come."""
        spin_until(self.executor, lambda: len(self.estimates) >= expected, timeout)
        spin_until(self.executor, lambda: len(self.estimates) > expected, 0.1)
        return len(self.estimates) == expected


@pytest.fixture
def observing(context: Context, spun: Callable[..., Executor]) -> Callable[..., Scene]:
    return partial(Scene, context, spun)


def test_a_state_becomes_an_estimate_of_its_stamp_and_frame(observing: Callable[..., Scene]) -> None:
    scene = observing(estimator="speed-ekf", parameter_set="simplified")
    scene.state(25, 50.0)
    assert scene.count(1)
    (estimate,) = scene.estimates
    assert (estimate.header.stamp.sec, estimate.header.stamp.nanosec, estimate.header.frame_id) == (1, 0, "duct")
    assert (estimate.n, estimate.estimator) == (50.0, "speed-ekf")
    assert math.isnan(estimate.v) and math.isnan(estimate.ambient)
    assert estimate.covariance[0] > 0.0 and math.isnan(estimate.covariance[4])


def test_the_estimate_waits_for_the_flow_of_its_stamp_and_takes_it_in(observing: Callable[..., Scene]) -> None:
    scene = observing()
    scene.state(0, 50.0)
    assert scene.count(0, 0.2)
    scene.send("flow", 0, axial=math.nan, ambient=0.2)
    assert scene.count(1)
    assert scene.estimates[0].ambient == pytest.approx(0.2)


def test_the_estimate_waits_for_the_throttle_that_acted_and_predicts_with_it(observing: Callable[..., Scene]) -> None:
    scene = observing(estimator="speed-ekf")
    scene.state(0, 50.0)
    assert scene.count(1)
    scene.state(1, math.nan)
    assert scene.count(1, 0.2)
    scene.send("throttle", 0, commanded=2.0, sent=math.nan)
    assert scene.count(2)
    settings, p = bench_settings("speed-ekf"), load_parameter_set("hl").coefficients
    track = advance(START, Measured(0, 50.0, math.nan, True), math.nan, settings, p)
    track = advance(track, Measured(PERIOD, math.nan, math.nan, True), 2.0, settings, p)
    assert track.belief is not None and abs(track.belief.n - 50.0) > 1.0
    assert scene.estimates[1].n == pytest.approx(track.belief.n, abs=1e-12)


def test_on_request_the_throttle_is_what_the_device_got(observing: Callable[..., Scene]) -> None:
    scene = observing(estimator="speed-ekf", throttle="sent")
    scene.state(0, 50.0)
    scene.send("throttle_sent", 0, commanded=math.nan, sent=2.0)
    scene.state(1, math.nan)
    assert scene.count(2)
    assert "throttle" not in scene.estimates[1].reason


def test_a_flow_that_does_not_come_costs_one_period_and_is_told(observing: Callable[..., Scene]) -> None:
    scene = observing(wait_for_throttle=False)
    for k in range(3):
        scene.state(k, 50.0)
    assert scene.count(2)
    scene.send("flow", 2, axial=math.nan, ambient=0.1)
    assert scene.count(3)
    assert [e.header.stamp.nanosec for e in scene.estimates] == [k * PERIOD for k in range(3)]
    values = {pair.key: pair.value for array in scene.told for status in array.status for pair in status.values}
    assert values["missing flow"] == "1"


def test_an_outlier_of_the_velocimeter_is_no_measurement(observing: Callable[..., Scene]) -> None:
    scene = observing()
    scene.state(0, 50.0)
    scene.send("flow", 0, axial=math.nan, ambient=0.4, spike=True)
    assert scene.count(1)
    assert scene.estimates[0].ambient == 0.0


def test_the_tachometers_sign_counts_only_where_it_was_measured(observing: Callable[..., Scene]) -> None:
    scene = observing(estimator="speed-ekf", wait_for_throttle=False)
    scene.state(0, -50.0, sign_source=ThrusterState.SIGN_MEASURED)
    assert scene.count(1)
    assert scene.estimates[0].n == -50.0
    scene.state(0, -50.0, sign_source=ThrusterState.SIGN_INFERRED)  # repeated: not answered
    scene.state(1, -50.0, sign_source=ThrusterState.SIGN_INFERRED)
    assert scene.count(2)
    assert "no usable speed" not in scene.estimates[1].reason, "a magnitude, with the belief's sign"


@pytest.mark.parametrize("form", ["proper", "bench"])
def test_readings_that_no_thruster_can_give_are_refused_counted_and_said_and_the_estimate_goes_on(
    observing: Callable[..., Scene], form: str
) -> None:
    scene = observing(estimator="ekf", form=form, wait_for_throttle=False, wait_for_flow=False)
    readings = [50.0, 50.0, 1e9, 50.0, 1e307, 50.0]
    for k, n in enumerate(readings):
        scene.send("flow", k, axial=math.nan, ambient=1e9 if k == 3 else 0.1)
        scene.state(k, n)
        assert scene.count(k + 1)
    assert all(abs(e.n) < 80.0 and abs(e.ambient) < 1.0 for e in scene.estimates)
    refused = [k for k, e in enumerate(scene.estimates) if "one that no thruster has and was refused" in e.reason]
    assert refused == [2, 4]
    assert all(scene.estimates[k].status != ThrusterEstimate.STATUS_OK for k in refused)
    assert scene.subject._refused["implausible speeds"] == 2


def test_densities_and_gates_change_while_it_runs_by_the_same_rules_and_the_belief_stays(
    observing: Callable[..., Scene],
) -> None:
    scene = observing(estimator="speed-ekf", wait_for_throttle=False)
    scene.state(0, 50.0)
    assert scene.count(1)

    def change(name: str, value: Any) -> str:
        (result,) = scene.subject.set_parameters([Parameter(name, value=value)])
        return str(result.reason) if not result.successful else "changed"

    assert change("gate", 16) == "changed"  # an integer for a number
    assert change("speed_noise", 2.0) == "changed"
    assert (scene.subject._settings.gate, scene.subject._settings.r_n) == (16.0, 4.0)
    assert scene.subject._track.belief is not None and scene.subject._track.belief.n == pytest.approx(50.0)
    assert "expected a number above 0, or NaN for none; found 0.0" in change("gate", 0.0)
    assert "q_v: expected a setting of speed-ekf; found one that it does not have" in change("q_v", 1.0)
    assert "estimator: fixed at start" in change("estimator", "nlo")
    assert scene.subject.get_parameter("gate").value == 16.0


def test_a_bench_that_starts_again_begins_a_new_estimate(observing: Callable[..., Scene]) -> None:
    scene = observing(estimator="speed-ekf", wait_for_throttle=False)
    for k, n in ((100, 90.0), (101, 90.0), (0, 10.0)):
        scene.state(k, n)
    assert scene.count(3)
    assert scene.estimates[2].n == pytest.approx(10.0)


def test_health_follows_the_estimate(observing: Callable[..., Scene]) -> None:
    scene = observing(estimator="speed-ekf", wait_for_throttle=False)
    scene.state(0, 50.0)
    assert scene.count(1)
    for k in (1, 30):
        scene.state(k, math.nan)
    assert scene.count(3)
    assert spin_until(scene.executor, lambda: any("too long" in a.status[0].message for a in scene.told), 5.0)
    assert [e.status for e in scene.estimates][-1] == ThrusterEstimate.STATUS_INVALID


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"estimator": "ukf"}, "estimator: expected one of ekf, nlo, kfnlo, speed-ekf; found 'ukf'"),
        ({"parameter_set": "none"}, "parameter_set: none: expected a YAML file or one of the known sets"),
        ({"parameter_set": "simplified"}, "parameter_set: ekf with simplified: the model has no axial flow"),
        ({"estimator": "nlo", "q_v": 1.0}, "q_v: expected a setting of nlo; found one that it does not have"),
        ({"gate": 0.0}, r"gate \[1\]: expected a number above 0, or NaN for none; found 0.0"),
    ],
    ids=str,
)
def test_wrong_parameters_are_refused_in_a_sentence(context: Context, values: dict[str, Any], sentence: str) -> None:
    with pytest.raises(StartRefused, match=sentence):
        ObserverNode(context=context, parameter_overrides=[Parameter(name, value=v) for name, v in values.items()])


def test_settings_given_as_parameters_reach_the_observer(context: Context) -> None:
    overrides = [Parameter(name, value=value) for name, value in {"gate": 16, "speed_noise": 2.0, "q_v": 0.01}.items()]
    node = ObserverNode(context=context, parameter_overrides=overrides)
    assert (node._settings.gate, node._settings.r_n, node._settings.q_v) == (16.0, 4.0, 0.01)
    node.destroy_node()


def test_the_parameter_file_holds_every_parameter_at_its_default() -> None:
    file = Path(__file__).parents[1] / "config/observer.yaml"
    given = yaml.safe_load(file.read_text("utf-8"))["/**"]["ros__parameters"]
    assert {name: str(value) for name, value in given.items()} == {p.name: str(p.default) for p in PARAMETERS}
