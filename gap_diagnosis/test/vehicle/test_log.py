"""Readings of any rate on one grid."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.log_io import _at_instants, _commanded, _held_mean, log_of, scatter, suited_period
from gap_diagnosis.vehicle.turns import Stated
from rov_sim.vehicle.effects.active import ActiveVehicleEffect
from run_bag import Channel, Run, RunError

GRID = 0.04 * np.arange(100)


def test_a_held_throttle_gives_each_period_its_mean() -> None:
    time, values = np.array([0.0, 0.05, 0.10]), np.array([1.0, 2.0, 4.0])
    # by hand: [0, 0.04] all 1; [0.04, 0.08]: 1 for 10 ms, 2 for 30; [0.08, 0.12]: 2 for 20 ms, 4 for 20
    assert _held_mean(time, values, np.array([0.0, 0.04, 0.08]), 0.04) == pytest.approx([1.0, 1.75, 3.0])


@pytest.mark.parametrize(
    ("spacing", "period"),
    [
        (0.04, 0.04),
        (0.05, 0.05),
        (0.02, 0.04),
        (1.0 / 30.0, 1.0 / 30.0),
        (0.2, 0.04),
        (1.0 / 15.0, 1.0 / 30.0),
    ],
)
def test_commands_change_at_the_instants_of_a_period_near_the_usual_one(spacing: float, period: float) -> None:
    name = "thruster_0/throttle.commanded"
    stamps = np.round(1e9 * (1.0 + spacing * np.arange(500))).astype(np.int64)
    stamps[250:] += 2_000_000_000  # a pause says nothing of how often they come
    run = Run(name="dive", channels={name: Channel(name=name, stamps=stamps, values=np.zeros(500))})
    assert suited_period([run], 1) == pytest.approx(period, rel=1e-6)


def test_commands_that_come_irregularly_have_the_usual_period() -> None:
    name = "thruster_0/throttle.commanded"
    stamps = np.cumsum(1e9 * np.random.default_rng(0).exponential(0.3, 200)).astype(np.int64)
    run = Run(name="dive", channels={name: Channel(name=name, stamps=stamps, values=np.zeros(200))})
    assert suited_period([run], 1) == 0.04


def test_a_reading_of_a_fast_sensor_does_not_lag_behind_what_bends() -> None:
    time = np.arange(0.0, 4.0, 0.01)
    parabola = (3.0 * time**2)[:, None]
    told, _, _ = _at_instants(time, parabola, GRID[2:-2], 0.04)
    assert told[:, 0] == pytest.approx(3.0 * GRID[2:-2] ** 2, abs=1e-9)


def test_the_noise_of_a_reading_is_told_within_a_tenth() -> None:
    rng = np.random.default_rng(0)
    time = np.arange(0.0, 40.0, 0.01)
    values = np.sin(time)[:, None] + 0.02 * rng.normal(size=(time.size, 1))
    assert scatter(values)[0] == pytest.approx(0.02, rel=0.1)
    told, noise, _ = _at_instants(time, values, 0.04 * np.arange(1, 990), 0.04)
    error = told[:, 0] - np.sin(0.04 * np.arange(1, 990))
    assert np.std(error) == pytest.approx(noise[0], rel=0.1)


def test_slow_readings_stand_at_their_instants_and_nowhere_else() -> None:
    time = np.arange(0.0, 3.9, 0.2)
    told, _, _ = _at_instants(time, time[:, None], GRID, 0.04)
    seen = np.isfinite(told[:, 0])
    assert seen.sum() == time.size and told[seen, 0] == pytest.approx(time)


def _run(names: list[str]) -> Run:
    stamps = (1_000_000_000 + 40_000_000 * np.arange(50)).astype(np.int64)
    return Run(name="short", channels={n: Channel(name=n, stamps=stamps, values=np.zeros(50)) for n in names})


@pytest.mark.parametrize(
    ("channels", "thrusters", "text"),
    [
        (["rov/imu.angular_velocity.x"], 2, "expected thruster_<i>/throttle"),
        (["thruster_0/throttle.commanded"], 1, "expected rov/imu or rov/odometry with attitude or rates"),
        (["thruster_0/throttle.commanded", "thruster_3/throttle.commanded"], 2, "expected 2 thrusters"),
    ],
)
def test_what_cannot_be_used_is_refused_in_a_sentence(channels: list[str], thrusters: int, text: str) -> None:
    with pytest.raises(RunError, match=text):
        log_of(_run(channels), thrusters)


@pytest.mark.parametrize(("gauge", "seen"), [("voltage", [True, False]), ("current", [False, True])])
def test_one_of_the_two_readings_of_a_battery_is_enough(gauge: str, seen: list[bool]) -> None:
    gyro = [f"rov/imu.angular_velocity.{axis}" for axis in "xyz"]
    log = log_of(_run([*gyro, "thruster_0/throttle.commanded", f"rov/battery.{gauge}"]), 1)
    assert np.isfinite(log.battery).any(axis=0).tolist() == seen


def test_commands_that_come_unevenly_act_as_they_are_to_half_a_part_of_a_period() -> None:
    rng = np.random.default_rng(3)
    time, period = np.cumsum(rng.uniform(0.03, 0.07, 400)), 0.04
    values = rng.choice([-2.0, 0.0, 3.0], time.size)
    grid = 0.1 + period * np.arange(400)
    acting = _commanded(time, values, grid, period).ravel()
    assert set(np.unique(acting)) == {-2.0, 0.0, 3.0}
    at = 0.1 + 0.25 * period * np.arange(acting.size)
    changes = at[1:][np.diff(acting) != 0.0]
    asked = time[1:][np.diff(values) != 0.0]
    asked = asked[(asked > 0.2) & (asked < at[-1] - 0.1)]
    assert max(np.abs(changes - each).min() for each in asked) <= 0.125 * period + 1e-9
    fast = np.arange(0.0, 20.0, 0.002)
    assert _commanded(fast, np.sin(fast), grid, period).ravel() == pytest.approx(np.sin(at + 0.004), abs=2e-3)


def test_commands_whose_hold_is_stated_as_linear_go_on_straight_lines() -> None:
    time, period = 0.1 * np.arange(60), 0.04
    told = Channel(name="thruster_0/throttle.commanded", stamps=np.round(1e9 * time).astype(int), values=np.sin(time))
    gyro = Channel(name="rov/imu.angular_velocity.x", stamps=told.stamps, values=np.cos(time))
    others = [replace(gyro, name=f"rov/imu.angular_velocity.{axis}") for axis in "yz"]
    channels = {each.name: each for each in (told, gyro, *others)}
    log = log_of(Run(name="lines", channels=channels, metadata={"hold": {"throttle": "linear"}}), 1, period)
    middles = period / 4 * (np.arange(log.commands.size) + 0.5)
    assert log.commands.ravel() == pytest.approx(np.interp(middles, time, np.sin(time)), abs=1e-9)


@pytest.mark.parametrize("period", [0.04, 0.05, 1.0 / 30.0])
def test_delays_of_commands_are_remembered_at_any_period(period: float) -> None:
    model = replace(load_model("bluerov2"), period=period)
    late = ActiveVehicleEffect(id="command_delay", thruster=2, sizes={"time": 0.11})
    assert model.built({}, [late]).steps(period) == pytest.approx((1, period / 4))


def test_an_odometry_tells_of_the_body_however_the_imu_is_mounted() -> None:
    mounted, stamps = (0.3, -0.2, np.pi / 2), (1_000_000_000 + 40_000_000 * np.arange(50)).astype(np.int64)
    angles = np.linspace(0.0, 0.5, 50)
    told = {
        "thruster_0/throttle.commanded": np.zeros(50),
        **{
            f"rov/odometry.twist.twist.angular.{a}": v * np.ones(50)
            for a, v in zip("xyz", (0.1, 0.2, 0.3), strict=True)
        },
        **{
            f"rov/odometry.pose.pose.orientation.{part}": each
            for part, each in zip("wxyz", (np.cos(angles / 2), np.sin(angles / 2), 0 * angles, 0 * angles), strict=True)
        },
    }
    channels = {n: Channel(name=n, stamps=stamps, values=values) for n, values in told.items()}
    log = log_of(Run(name="turned", channels=channels), 1, stated=Stated(imu=mounted))
    expected = Rotation.from_euler("x", angles[-1])
    found = Rotation.from_quat(log.attitude[np.isfinite(log.attitude[:, 0])][-1][[1, 2, 3, 0]])
    assert (expected.inv() * found).magnitude() < 0.02
    assert np.nanmean(log.told[:, 3:6], axis=0) == pytest.approx((0.1, 0.2, 0.3))
    assert "gyro: the rates of rov/odometry, as rov/imu has none" in log.notes
