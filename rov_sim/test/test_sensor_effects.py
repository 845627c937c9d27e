"""Effects of a vehicle's sensors: neutral to the bit, and each with the signature that a diagnosis looks for."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from vehicle_motion import DEFAULT, exact, moving, rotations, wobble

from rov_sim.vehicle.effects.active import VEHICLE_LIBRARY, ActiveVehicleEffect, sensing_with, thruster_effects
from rov_sim.vehicle.sensors.coefficients import sensor_coefficients
from rov_sim.vehicle.sensors.live import Sensors
from rov_sim.vehicle.sensors.series import Series, read_trajectory

EFFECTS = {
    "gyro_scale": (("imu",), {"share": 0.1}, {}),
    "imu_bias": (("imu",), {"rate": 0.02, "force": 0.3}, {"axis": "y"}),
    "imu_misalignment": (("imu",), {"angle": 0.1}, {"axis": "z"}),
    "imu_delay": (("imu",), {"time": 0.12}, {}),
    "velocity_delay": (("velocity",), {"time": 0.12}, {}),
    "velocity_scale": (("velocity",), {"share": -0.1}, {}),
    "velocity_misalignment": (("velocity",), {"angle": 0.1}, {"axis": "z"}),
    "sensor_lever_arm": (("depth",), {"offset": 0.2}, {"sensor": "depth", "axis": "x"}),
    "depth_bias": (("depth",), {"offset": 0.4}, {}),
    "heading_bias": (("imu",), {"angle": 0.3}, {}),
    "depth_scale": (("depth",), {"share": 0.05}, {}),
    "magnetic_disturbance": (("imu",), {"angle": 0.2}, {}),
    "compass_deviation": (
        ("imu",),
        {"semicircular_sin": 0.1, "semicircular_cos": -0.05, "quadrantal_sin": 0.04, "quadrantal_cos": 0.02},
        {},
    ),
}
"""Sensors that are concerned, sizes, and what the effect acts on."""
TIME = 0.01 * np.arange(401)
TRUTH = moving(TIME)


def read(sensors: Any, *active: ActiveVehicleEffect, seed: int = 0) -> dict[tuple[str, int], Series]:
    return read_trajectory(sensors, seed, TRUTH, sensing_with(sensor_coefficients(sensors), active))


def of(name: str, **changes: float) -> ActiveVehicleEffect:
    _, sizes, target = EFFECTS[name]
    return ActiveVehicleEffect(id=name, sizes={**sizes, **changes}, **target)


def test_every_effect_of_a_sensor_is_tried_here() -> None:
    assert set(EFFECTS) == {name for name, effect in VEHICLE_LIBRARY.items() if effect.sensing is not None}


@pytest.mark.parametrize("name", EFFECTS)
def test_at_neutral_an_effect_changes_no_bit(name: str) -> None:
    neutral = {p.name: p.neutral for p in VEHICLE_LIBRARY[name].parameters}
    before, after = read(DEFAULT), read(DEFAULT, of(name, **neutral))
    for key in before:
        for one, other in zip(before[key], after[key], strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("name", EFFECTS)
def test_an_effect_changes_its_sensor_alone(name: str) -> None:
    before, after = read(DEFAULT), read(DEFAULT, of(name))
    for key in before:
        same = all(
            np.array_equal(one, other, equal_nan=True) for one, other in zip(before[key], after[key], strict=True)
        )
        assert same == (key[0] not in EFFECTS[name][0]), key


@pytest.mark.parametrize("name", EFFECTS)
def test_live_an_effect_gives_the_same_readings(name: str) -> None:
    after = read(DEFAULT, of(name))
    c = sensing_with(sensor_coefficients(DEFAULT), [of(name)])
    subject, came = Sensors(DEFAULT, 0, 3, c), []
    for k in range(1, len(TIME)):
        now = SimpleNamespace(**{key: rows[k] for key, rows in vars(TRUTH).items()})
        came += [r for r in subject.read(k * 10_000_000, now) if r.sensor in EFFECTS[name][0]]
    expected = after[EFFECTS[name][0][0], -1]
    assert len(came) > 15
    np.testing.assert_array_equal([r.values for r in came], expected.values[: len(came)])
    np.testing.assert_array_equal([r.stamp for r in came], expected.stamps[: len(came)])


def test_the_gyro_tells_more_of_every_turn_while_the_attitude_tells_the_truth() -> None:
    before, after = read(exact())["imu", -1].values, read(exact(), of("gyro_scale"))["imu", -1].values
    np.testing.assert_allclose(after[:, 4:7], 1.1 * before[:, 4:7], rtol=1e-14)
    np.testing.assert_array_equal(np.delete(after, [4, 5, 6], axis=1), np.delete(before, [4, 5, 6], axis=1))
    one = ActiveVehicleEffect(id="gyro_scale", sizes={"share": 0.1}, axis="z")
    after = read(exact(), one)["imu", -1].values
    np.testing.assert_array_equal(after[:, 4:6], before[:, 4:6])
    np.testing.assert_allclose(after[:, 6], 1.1 * before[:, 6], rtol=1e-14)


def test_a_bias_is_added_along_its_axis() -> None:
    difference = read(exact(), of("imu_bias"))["imu", -1].values - read(exact())["imu", -1].values
    np.testing.assert_allclose(difference, np.tile([0, 0, 0, 0, 0, 0.02, 0, 0, 0.3, 0], (400, 1)), atol=1e-14)


def test_an_imu_askew_turns_all_that_it_tells_by_one_angle() -> None:
    before, after = read(exact())["imu", -1].values, read(exact(), of("imu_misalignment"))["imu", -1].values
    turn = Rotation.from_rotvec([0.0, 0.0, 0.1])
    for columns in (slice(4, 7), slice(7, 10)):
        np.testing.assert_allclose(after[:, columns], turn.inv().apply(before[:, columns]), atol=1e-12)
    told = Rotation.from_quat(after[:, [1, 2, 3, 0]])
    assert (told.inv() * Rotation.from_quat(before[:, [1, 2, 3, 0]]) * turn).magnitude().max() < 1e-12


def test_a_late_imu_tells_what_it_told_before_under_stamps_of_now() -> None:
    before, after = read(exact())["imu", -1], read(exact(), of("imu_delay"))["imu", -1]
    late = round(0.12 / (1e-9 * (before.stamps[1] - before.stamps[0])))
    np.testing.assert_array_equal(after.values[late:], before.values[:-late])
    np.testing.assert_array_equal(after.values[:late], np.tile(before.values[0], (late, 1)))
    np.testing.assert_array_equal(after.stamps, before.stamps)


def test_a_late_log_tells_the_velocity_before_its_stamp() -> None:
    before, after = read(exact())["velocity", -1], read(exact(), of("velocity_delay"))["velocity", -1]
    np.testing.assert_array_equal(after.values, before.values)
    np.testing.assert_array_equal(after.stamps, before.stamps + 120_000_000)
    np.testing.assert_array_equal(after.available, after.stamps)


def test_a_log_with_wrong_scale_or_askew_is_wrong_in_proportion_to_speed() -> None:
    before = read(exact())["velocity", -1].values
    np.testing.assert_allclose(read(exact(), of("velocity_scale"))["velocity", -1].values, 0.9 * before, rtol=1e-14)
    askew = read(exact(), of("velocity_misalignment"))["velocity", -1].values
    np.testing.assert_allclose(askew, Rotation.from_rotvec([0, 0, -0.1]).apply(before), atol=1e-14)


@pytest.mark.parametrize(("sensor", "columns"), [("imu", [7, 8, 9]), ("velocity", [0, 1, 2]), ("depth", [0])])
def test_a_sensor_elsewhere_feels_other_motion(sensor: str, columns: list[int]) -> None:
    moved = ActiveVehicleEffect(id="sensor_lever_arm", sizes={"offset": 0.2}, sensor=sensor, axis="x")
    before, after = read(exact())[sensor, -1], read(exact(), moved)[sensor, -1]
    t, h = 1e-9 * before.taken, 1e-3

    def arm(at: np.ndarray) -> np.ndarray:
        return rotations(at).apply([0.2, 0.0, 0.0])

    if sensor == "depth":
        expected = arm(t)[:, 2:]
    elif sensor == "velocity":
        expected = rotations(t).inv().apply((arm(t + h) - arm(t - h)) / (2 * h))
    else:
        expected = rotations(t).inv().apply((arm(t + h) - 2 * arm(t) + arm(t - h)) / h**2)
    np.testing.assert_allclose((after.values - before.values)[:, columns], expected, atol=1e-6)
    assert wobble(t)[0].any()


def test_a_depth_off_its_zero_is_deeper_all_the_time() -> None:
    difference = read(exact(), of("depth_bias"))["depth", -1].values - read(exact())["depth", -1].values
    np.testing.assert_allclose(difference, 0.4, atol=1e-14)


def test_a_wrong_scale_of_the_depth_grows_with_the_depth() -> None:
    before, after = read(exact())["depth", -1].values, read(exact(), of("depth_scale"))["depth", -1].values
    np.testing.assert_allclose(after, 1.05 * before, rtol=1e-14)


def test_the_thrusters_current_turns_the_heading_and_nothing_else() -> None:
    before, after = read(exact())["imu", -1].values, read(exact(), of("magnetic_disturbance"))["imu", -1].values
    np.testing.assert_array_equal(after[:, 4:], before[:, 4:])
    turn = Rotation.from_quat(after[:, [1, 2, 3, 0]]) * Rotation.from_quat(before[:, [1, 2, 3, 0]]).inv()
    off = np.outer(0.2 * TRUTH.current[1:], [0.0, 0.0, 1.0])
    np.testing.assert_allclose(turn.as_rotvec(), off, atol=1e-12)


def test_a_biased_heading_is_turned_by_one_angle_about_down_whatever_the_attitude() -> None:
    before, after = read(exact())["imu", -1].values, read(exact(), of("heading_bias"))["imu", -1].values
    np.testing.assert_array_equal(after[:, 4:], before[:, 4:])
    turn = Rotation.from_quat(after[:, [1, 2, 3, 0]]) * Rotation.from_quat(before[:, [1, 2, 3, 0]]).inv()
    np.testing.assert_allclose(turn.as_rotvec(), np.tile([0.0, 0.0, 0.3], (400, 1)), atol=1e-12)


def test_a_compass_beside_iron_errs_by_the_formula_of_compass_adjusters_and_in_the_heading_alone() -> None:
    before, after = read(exact())["imu", -1].values, read(exact(), of("compass_deviation"))["imu", -1].values
    np.testing.assert_array_equal(after[:, 4:], before[:, 4:])
    turn = Rotation.from_quat(after[:, [1, 2, 3, 0]]) * Rotation.from_quat(before[:, [1, 2, 3, 0]]).inv()
    psi = Rotation.from_quat(before[:, [1, 2, 3, 0]]).as_euler("ZYX")[:, 0]
    off = 0.1 * np.sin(psi) - 0.05 * np.cos(psi) + 0.04 * np.sin(2.0 * psi) + 0.02 * np.cos(2.0 * psi)
    assert np.ptp(psi) > 0.2
    np.testing.assert_allclose(turn.as_rotvec(), np.outer(off, [0.0, 0.0, 1.0]), atol=1e-12)


def test_effects_compose() -> None:
    both = read(exact(), of("velocity_scale"), of("velocity_misalignment"), of("depth_bias"))
    askew = read(exact(), of("velocity_misalignment"))["velocity", -1].values
    np.testing.assert_allclose(both["velocity", -1].values, 0.9 * askew, rtol=1e-14)
    np.testing.assert_allclose(both["depth", -1].values, read(exact(), of("depth_bias"))["depth", -1].values)


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"id": "gyro_scal"}, "key 'effects.gyro_scal': expected one of"),
        ({"id": "gyro_scale", "sizes": {"share": 2.0}}, "gyro_scale.share': expected 0 or -0.3 to 0.3 1; found 2.0"),
        ({"id": "gyro_scale", "sizes": {"scale": 0.1}}, "gyro_scale': expected parameters share; found 'scale'"),
        ({"id": "gyro_scale", "axis": "roll"}, "gyro_scale.axis': expected one of x, y, z; found 'roll'"),
        ({"id": "imu_bias", "sizes": {"rate": 0.01}}, "imu_bias.axis': missing"),
        ({"id": "depth_bias", "thruster": 1}, "depth_bias.thruster': expected none; found 1"),
        ({"id": "sensor_lever_arm", "sensor": "battery", "axis": "x"}, "sensor': expected one of imu, velocity, depth"),
        ({"id": "ambient_current", "sizes": {}}, "ambient_current': expected an effect of a vehicle; found"),
        ({"id": "tank_recirculation"}, "found one of a tank: on a vehicle U follows from motion"),
        ({"id": "load_cell_bias"}, "load_cell_bias': expected an effect of a vehicle's sensors; found one of a rig's"),
        ({"id": "tach_lag", "sizes": {"time": 9.0}}, "tach_lag.time': expected 0 or 0 to 0.4 s; found 9.0"),
        ({"id": "tach_lag", "axis": "x"}, "tach_lag.axis': expected none; found 'x'"),
    ],
    ids=str,
)  # fmt: skip
def test_effects_that_make_no_sense_are_refused_in_sentences(values: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        ActiveVehicleEffect(**values)


def test_effects_of_thrusters_are_on_one_or_on_all() -> None:
    one = ActiveVehicleEffect(id="tach_lag", sizes={"time": 0.1}, thruster=1)
    both = thruster_effects([one, ActiveVehicleEffect(id="tach_dropout", sizes={"threshold": 20.0})], 3)
    assert both is not None
    assert [e.tach_lag_time for e in both] == [0.0, 0.1, 0.0]
    assert [e.tach_dropout_threshold for e in both] == [20.0] * 3
    assert thruster_effects([of("depth_bias")], 3) is None
    with pytest.raises(ValueError, match=r"effects\.tach_lag\.thruster': expected 0 to 0; found 1"):
        thruster_effects([one], 1)
