"""The whole graph with sensors lost, numbers that are none, steps too large, K_t singular: it goes on and says it."""

import math
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from diagnostic_msgs.msg import DiagnosticStatus

from thruster_model.errors import VehicleError
from thruster_msgs.msg import ThrusterFailure
from thruster_runtime.errors import StartRefused
from thruster_runtime.records import RecordPublisher

OK, WARN, ERROR = (level[0] for level in (DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR))
PERIOD = 40_000_000  # ns


def spoil(publisher: RecordPublisher, begin: float, end: float, **fields: float) -> None:
    """Let a publisher's messages have these fields from a time [s] on until another."""
    publish = publisher.publish

    def spoilt(record: Any) -> None:
        within = round(1e9 * begin) <= record.stamp < round(1e9 * end)
        publish(record._replace(**fields) if within else record)

    publisher.publish = spoilt  # type: ignore[method-assign]


def numbers(graph: Any, topic: str, field: str) -> dict[int, float]:
    """Return a field of a topic's messages by their periods."""
    found = {}
    for stamp, text in graph.listener.of(topic):
        value = text.partition(f"{field}=")[2].partition(",")[0].partition(")")[0]
        found[round(stamp / PERIOD)] = float(value)
    return found


@pytest.mark.parametrize(
    ("sensor", "words"),
    [
        ("velocity", "no velocity log for too long: velocity is integrated specific force and drifts"),
        ("depth", "no depth for too long: depth is integrated velocity and drifts"),
    ],
)
def test_without_velocity_log_or_depth_the_dive_goes_on_degraded_and_it_is_said(
    make: Callable[..., Any], sensor: str, words: str
) -> None:
    graph = make(
        feedback="estimator", handing_over=True, change={"plant": {"failures": f"{sensor} lost at 0.8 s"}}
    )  # fmt: skip
    graph.run(15)
    assert not graph.listener.heard_of("navigation", WARN, words)
    graph.run(75)
    assert graph.until(lambda: graph.listener.heard_of("navigation", WARN, words))
    truth = graph.plant.vehicle._plant.truth()
    assert 0.1 < truth.velocity[0] < 0.3, "it still follows its set point"
    assert [said for said in graph.listener.said if said[1] >= ERROR] == []
    throttles = numbers(graph, "thruster_0/throttle", "commanded")
    assert all(map(math.isfinite, throttles.values())) and abs(throttles[74]) > 0.3


@pytest.mark.parametrize(("sensor", "words"), [("velocity", "no velocity log for too"), ("depth", "no depth for too")])
def test_in_real_time_a_sensor_that_falls_silent_is_said_and_the_dive_goes_on(
    make: Callable[..., Any], sensor: str, words: str
) -> None:
    graph = make(feedback="estimator", lockstep=False)
    assert graph.until(lambda: len(graph.listener.of(f"rov/{sensor}")) > 3)
    graph.plant._sensors.publishers[sensor, -1].publish = lambda record: None  # its cable is out
    assert graph.until(lambda: graph.listener.heard_of("navigation", WARN, words))
    before = len(graph.listener.of("rov/odometry"))
    assert graph.until(lambda: len(graph.listener.of("rov/odometry")) > before + 25)


@pytest.mark.parametrize(
    ("sensor", "fields", "words"),
    [
        ("velocity", ["twist_twist_linear_x"], "no velocity log for too long"),
        ("depth", ["depth"], "no depth for too long"),
        ("imu", ["orientation_w"], "no attitude for too long: it follows from the gyro"),
    ],
)
def test_readings_that_are_no_numbers_are_as_if_the_sensor_were_lost_and_it_is_said(
    make: Callable[..., Any], sensor: str, fields: list[str], words: str
) -> None:
    graph = make(feedback="estimator", handing_over=True)
    spoil(graph.plant._sensors.publishers[sensor, -1], 0.8, 90.0, **dict.fromkeys(fields, math.nan))
    graph.run(90)
    assert graph.until(lambda: graph.listener.heard_of("navigation", WARN, words)), graph.listener.said
    assert 0.1 < graph.plant.vehicle._plant.truth().velocity[0] < 0.3, "it still follows its set point"
    throttles = numbers(graph, "thruster_0/throttle", "commanded")
    assert all(map(math.isfinite, throttles.values())) and abs(throttles[74]) > 0.3


def test_an_imu_that_tells_nothing_for_some_periods_is_bridged_by_what_it_told_last_and_it_is_said(
    make: Callable[..., Any],
) -> None:
    graph = make(feedback="estimator", handing_over=True)
    rates = {f"{name}_{axis}": math.nan for name in ("angular_velocity", "linear_acceleration") for axis in "xyz"}
    turns = {f"orientation_{axis}": math.nan for axis in "wxyz"}
    spoil(graph.plant._sensors.publishers["imu", -1], 1.2, 1.6, **rates, **turns)
    graph.run(90)
    words = "no angular velocity or specific force: the last ones were held"
    assert graph.until(lambda: graph.listener.heard_of("navigation", WARN, words)), graph.listener.said
    throttles = numbers(graph, "thruster_0/throttle", "commanded")
    assert all(map(math.isfinite, throttles.values())) and abs(throttles[85]) > 0.3
    assert 0.1 < graph.plant.vehicle._plant.truth().velocity[0] < 0.3


def test_odometry_that_is_no_number_is_no_thrust_until_it_is_one_again_and_is_said(make: Callable[..., Any]) -> None:
    graph = make(handing_over=True)
    spoil(graph.plant._rov["odometry"], 1.2, 1.6, pose_pose_orientation_w=math.nan)
    graph.run(60)
    assert graph.until(lambda: graph.listener.heard_of("allocator", ERROR, "odometry without a finite attitude"))
    thrusts = numbers(graph, "thruster_0/thrust_setpoint", "thrust")
    assert all(thrusts[k] == 0.0 for k in range(30, 40)) and thrusts[29] != 0.0 and thrusts[58] != 0.0
    throttles = numbers(graph, "thruster_0/throttle", "commanded")
    assert abs(throttles[38]) < abs(throttles[29]) < abs(throttles[58])
    assert 0.1 < graph.plant.vehicle._plant.truth().velocity[0] < 0.25


def test_an_unknown_velocity_leaves_attitude_under_control_and_is_said(make: Callable[..., Any]) -> None:
    graph = make(handing_over=True)
    spoil(graph.plant._rov["odometry"], 1.2, 9.0, twist_twist_linear_x=math.nan)
    graph.run(60)
    assert graph.until(lambda: graph.listener.heard_of("allocator", WARN, "linear velocity is unknown"))
    assert graph.until(lambda: graph.listener.heard_of("observer_0", WARN, "no ambient flow was used for too long"))
    assert numbers(graph, "thruster_0/thrust_setpoint", "thrust")[58] != 0.0
    assert 0.05 < graph.plant.vehicle._plant.truth().velocity[0] < 0.4


def test_a_set_point_that_is_no_number_is_no_thrust_and_is_said(make: Callable[..., Any]) -> None:
    graph = make(handing_over=True)
    spoil(graph.nodes["vehicle_reference"]._set_points, 1.2, 9.0, attitude=(math.nan, 0.0, 0.0))
    graph.run(50)
    assert graph.until(lambda: graph.listener.heard_of("allocator", WARN, "no set point: no thrust"))
    assert numbers(graph, "thruster_0/thrust_setpoint", "thrust")[48] == 0.0


def test_a_tachometer_that_tells_nothing_is_said_and_the_throttle_follows_the_set_point_alone(
    make: Callable[..., Any],
) -> None:
    graph = make(handing_over=True)
    spoil(graph.plant._sensors.publishers["tachometer", 2], 1.0, 9.0, n=math.nan)
    graph.run(70)
    assert graph.until(lambda: graph.listener.heard_of("observer_2", ERROR, "no speed was used for too long"))
    assert graph.until(lambda: graph.listener.heard_of("inner_loop_2", WARN, "no usable estimate"))
    assert not graph.listener.heard_of("observer_1", WARN, "no speed")
    throttles = numbers(graph, "thruster_2/throttle", "commanded")
    assert all(map(math.isfinite, throttles.values()))


def test_a_throttle_that_is_no_number_is_zero(make: Callable[..., Any]) -> None:
    graph = make(handing_over=True)
    spoil(graph.nodes["inner_loop_3"]._throttles, 1.2, 9.0, commanded=math.nan)
    graph.run(50)
    assert graph.plant.vehicle._held[3] == 0.0 and abs(graph.plant.vehicle._held[2]) > 0.3
    assert np.all(np.isfinite(graph.plant.vehicle._plant.state.velocity))


@pytest.mark.parametrize(
    "given",
    [
        {"thruster": 9, "kind": ThrusterFailure.KIND_DEAD},
        {"kind": ThrusterFailure.KIND_WEAK, "effectiveness": -1.0},
    ],
)
def test_a_report_of_a_failure_that_cannot_be_is_not_used(make: Callable[..., Any], given: dict[str, Any]) -> None:
    graph = make(handing_over=False)
    graph.run(5)
    publisher = graph.listener.create_publisher(ThrusterFailure, "rov/thruster_failure", 10)
    assert graph.until(lambda: publisher.get_subscription_count() >= 8)
    publisher.publish(ThrusterFailure(**given))
    assert graph.until(lambda: len(graph.listener.of("rov/thruster_failure")) == 1)
    graph.run(60)
    assert numbers(graph, "thruster_0/thrust_setpoint", "thrust")[58] != 0.0
    assert not graph.listener.heard_of("allocator", WARN, "")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"largest_step": 1.0}, r"largest_step"),
        ({"rate": math.nan}, "rate"),
        ({"current": "0 nan 0"}, "current: expected 3 finite numbers; found '0 nan 0'"),
        ({"attitude_deg": "0 0"}, "attitude_deg: expected 3 finite numbers"),
        ({"failures": "sonar lost at 3 s"}, "failures: expected such as"),
    ],
)
def test_a_plant_that_cannot_be_computed_is_refused_with_a_sentence(
    make: Callable[..., Any], change: dict[str, Any], said: str
) -> None:
    with pytest.raises(StartRefused, match=said):
        make(change={"plant": change})


def test_a_step_that_is_too_large_for_the_thrusters_is_refused_with_a_sentence(
    make: Callable[..., Any], tmp_path: Path
) -> None:
    fast = tmp_path / "fast.yaml"
    told = yaml.safe_load(files("thruster_model").joinpath("parameter_sets", "hq.yaml").read_text("utf-8"))
    told["parameters"]["k_n"]["value"] = 80.0
    fast.write_text(yaml.safe_dump(told), "utf-8")
    said = r"largest_step: expected at most 0\.0312 s, as a rotor \(k_n\) settles at 80 1/s; found 0\.1 s"
    with pytest.raises(StartRefused, match=said):
        make(change={"plant": {"truth": str(fast), "largest_step": 0.1, "rate": 5.0}})


def test_a_vehicle_that_leaves_the_numbers_ends_the_run_with_a_sentence(make: Callable[..., Any]) -> None:
    graph = make(handing_over=True)
    graph.run(5)
    graph.plant.vehicle._plant._sheet[0, 7] = math.inf
    with pytest.raises(VehicleError, match=r"state: expected finite numbers; found others after .* s: the step is too"):
        graph.run(10)


@pytest.mark.parametrize(("given_up", "lost", "least"), [("", "surge", -0.05), ("pitch", "pitch", 0.1)])
def test_a_vehicle_whose_configuration_is_singular_dives_and_says_what_it_lacks(
    make: Callable[..., Any], given_up: str, lost: str, least: float
) -> None:
    graph = make(vehicle="bluerov2", given_up=given_up, handing_over=True)
    graph.run(60)
    words = f"K_t has rank 5 of 6: no control of {lost}"
    assert graph.until(lambda: graph.listener.heard_of("allocator", OK, words)), graph.listener.said
    assert least < graph.plant.vehicle._plant.truth().velocity[0] < 0.3
    assert all(math.isfinite(u) for u in numbers(graph, "thruster_0/throttle", "commanded").values())
