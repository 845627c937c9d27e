"""A dive that the graph made and the recorder kept is, to rounding, what the study's offline loop makes of the same."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray

from rov_sim.vehicle.loop import VehicleLoopRun, simulate_vehicle_loop
from rov_sim.vehicle.sensors import settings_io
from rov_sim.vehicle.sensors.believed import navigation_settings
from rov_sim.vehicle.sensors.settings_io import load_sensors
from rov_sim.vehicle_study.assumptions import Assumptions
from rov_sim.vehicle_study.conditions import drawn_vehicle, feedback_of, sensors_of, steering_of
from rov_sim.vehicle_study.controllers import inner_loop_of
from rov_sim.vehicle_study.plan_io import load_plan
from rov_sim.vehicle_study.results_io import contents_of, sets_of
from run_bag import Run, read_run
from thruster_control.strategies import strategy
from thruster_control.vehicle_set_points_io import load_script

Array = NDArray[np.float64]
PERIODS, SEED, DELAY = 60, 3, 0.2
"""Recorded periods, seed of everything random, how long the graph holds the script's beginning [s]."""
PLAN = load_plan("thesis")
SETS = sets_of(contents_of(PLAN))
QUATERNION, AXES = "wxyz", "xyz"


def assumptions(**changes: Any) -> Assumptions:
    """Return the study's first case on the vehicle as it is believed to be."""
    told = {name: assumed.value for name, assumed in PLAN.assumed.items()}
    return Assumptions(**{**told, "deviation": 0.0, **changes})


def offline(name: str, given: Assumptions, script: Path) -> VehicleLoopRun:
    """Run the study's loop; its script begins when the graph's does, which counts from its first tick."""
    loaded = load_script(str(script))
    moves = loaded.moves.copy()
    moves[:, 1] += given.period + DELAY
    believed, truth = SETS.thrusters[strategy(name).parameter_set], SETS.thrusters[given.truth]
    return simulate_vehicle_loop(
        loaded._replace(moves=moves, end=loaded.end + given.period + DELAY),
        drawn_vehicle(given, SETS, (1, SEED)),
        steering_of(given, SETS),
        inner_loop_of(name, given, believed.coefficients, truth.coefficients),
        feedback_of(given, SETS),
        period=given.period,
        duration=(PERIODS + 1) * given.period,
        seed=SEED,
    )


def sensors_file(given: Assumptions, folder: Path) -> Path:
    """Write the sensors of the study's case as the plant's node reads them."""
    text = (Path(settings_io.__file__).parent / "vehicle_sensors.yaml").read_text("utf-8")
    told = yaml.safe_load(text)
    for sensor, rate in {"imu": 25.0, "velocity": 5.0, "depth": 5.0, "battery": 0.0}.items():
        told[sensor]["rate"]["value"] = rate
    file = folder / "sensors.yaml"
    file.write_text(yaml.safe_dump(told), "utf-8")
    assert load_sensors(file) == sensors_of(given, load_sensors())
    return file


def recorded(run: Run, topic: str, *fields: str) -> Array:
    """Return fields of the first ticks, (PERIODS, len(fields))."""
    channels = [run[f"{topic}.{field}"] for field in fields]
    ticks = np.arange(1, PERIODS + 1) * 40_000_000
    for channel in channels:
        np.testing.assert_array_equal(channel.stamps[:PERIODS], ticks, err_msg=channel.name)
    return np.stack([channel.values[:PERIODS] for channel in channels], axis=1)


def motion(run: Run, topic: str) -> tuple[Array, Array]:
    """Return attitude (PERIODS, 4) and velocity (PERIODS, 6) of an odometry."""
    attitude = recorded(run, topic, *(f"pose.pose.orientation.{each}" for each in QUATERNION))
    moving = [f"twist.twist.{kind}.{axis}" for kind in ("linear", "angular") for axis in AXES]
    return attitude, recorded(run, topic, *moving)


def of_thrusters(run: Run, name: str) -> Array:
    """Return a channel of all thrusters, (PERIODS, 6)."""
    topic, _, field = name.partition(".")
    return np.concatenate([recorded(run, f"thruster_{i}/{topic}", field) for i in range(6)], axis=1)


@pytest.mark.parametrize(
    ("name", "feedback"),
    [
        ("hq-ekf", "truth"),
        ("lookup", "estimator"),
        # these compile a loop of their own, for ten seconds each
        pytest.param("hl-nlo", "truth", marks=pytest.mark.long),
        pytest.param("hq-kfnlo", "estimator", marks=pytest.mark.long),
    ],
)
def test_a_recorded_dive_is_the_study_s_offline_run_to_rounding(
    make: Callable[..., Any], tmp_path: Path, name: str, feedback: str
) -> None:
    given = assumptions(feedback=feedback)
    file = sensors_file(given, tmp_path)
    change: dict[str, dict[str, Any]] = {"plant": {"largest_step": given.largest_step}}
    if feedback == "estimator":  # the study's filter knows how much its biases scatter, a navigation node guesses
        knows = navigation_settings(load_sensors(file))
        change["navigation"] = {name: getattr(knows, name) for name in ("gyro_bias_deviation", "force_bias_deviation")}
    graph = make(
        record=tmp_path / "dive", handing_over=True, strategy=name, feedback=feedback, seed=SEED, start_delay=DELAY,
        allocation="pseudo-inverse", truth=given.truth, sensors=load_sensors(file), sensors_file=str(file),
        change=change,
    )  # fmt: skip
    graph.run(PERIODS + 2)
    graph.close()
    run, whole = read_run(tmp_path / "dive"), offline(name, given, tmp_path / "script.yaml")
    ours = whole.record
    attitude, velocity = motion(run, "rov/truth")
    told_attitude, told_velocity = motion(run, "rov/odometry")
    pairs = {
        "set point": (recorded(run, "rov/setpoint", "velocity[0]"), ours.points[:, 9:10]),
        "odometry, attitude": (told_attitude, ours.told_attitude),
        "odometry, velocity": (told_velocity, ours.told_velocity),
        "wrench": (recorded(run, "rov/wrench", "wrench.force.x", "wrench.torque.y"), ours.wrench[:, [0, 4]]),
        "wanted thrust": (of_thrusters(run, "thrust_setpoint.thrust"), ours.T_d),
        "throttle": (of_thrusters(run, "throttle.commanded"), whole.of("u")),
        "speed measured": (of_thrusters(run, "state.n"), ours.y_n),
        "attitude": (attitude, ours.attitude),
        "velocity": (velocity, ours.velocity),
        "speed": (of_thrusters(run, "truth.n"), ours.n),
        "thrust": (of_thrusters(run, "truth.thrust"), ours.thrust),
    }
    if name != "lookup":
        pairs |= {
            f"estimate of {x}": (of_thrusters(run, f"estimate.{field}"), whole.of(x))
            for x, field in (("n", "n"), ("v", "v"), ("U", "ambient"))
        }
    for what, (live, alone) in pairs.items():
        np.testing.assert_allclose(live, alone, rtol=1e-9, atol=1e-9, err_msg=what)
    assert np.max(np.abs(whole.of("u"))) > 0.5 and ours.velocity[-1, 0] > 0.1, "it moves"
