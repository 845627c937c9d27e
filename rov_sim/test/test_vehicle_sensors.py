"""The sensors of a vehicle: what they read, when, how wrongly, and that live and offline agree bit for bit."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from vehicle_motion import DEFAULT, GRAVITY, at, exact, moving, rotations, wobble

from rov_sim.vehicle.random_wrench import RandomWrench, WrenchStream
from rov_sim.vehicle.sensors.coefficients import sensor_coefficients
from rov_sim.vehicle.sensors.live import Reading, Sensors
from rov_sim.vehicle.sensors.measuring import imu_measured, reading_of
from rov_sim.vehicle.sensors.series import read_trajectory
from rov_sim.vehicle.sensors.settings import QUANTITIES, Sensor, VehicleSensors
from rov_sim.vehicle.sensors.settings_io import SensorSettingsError, parse_sensors
from rov_sim.vehicle.sensors.tachometers import chain_step
from thruster_model.effects.stages import effect_values

TICK = 10_000_000  # ns


def live(sensors: VehicleSensors, seed: int, truth: SimpleNamespace) -> list[tuple[int, Reading]]:
    """Return all readings with the instants [ns] at which they came, of a truth every tick from 0 on."""
    subject = Sensors(sensors, seed, truth.n.shape[1])
    return [(k * TICK, r) for k in range(1, len(truth.time)) for r in subject.read(k * TICK, at(truth, k))]


def test_every_default_says_its_unit_and_source() -> None:
    assert DEFAULT.there() == ("imu", "velocity", "depth", "tachometer", "battery")
    assert (DEFAULT.imu.rate, DEFAULT.velocity.rate, DEFAULT.depth.rate, DEFAULT.tachometer.rate) == (100, 5, 10, 25)
    assert DEFAULT.imu.noise == (0.004,) * 3 + (0.003,) * 3 + (0.05,) * 3
    assert (DEFAULT.velocity.noise, DEFAULT.depth.noise, DEFAULT.tachometer.noise) == ((0.008,) * 3, (0.006,), (1.2,))


def test_a_resting_vehicle_feels_its_weight_pushing_up() -> None:
    still = SimpleNamespace(
        time=np.array([0.0]), position=np.zeros((1, 3)), attitude=np.array([[1.0, 0, 0, 0]]), velocity=np.zeros((1, 6)),
        acceleration=np.zeros((1, 6)), n=np.zeros((1, 1)), supply=np.ones(1), current=np.zeros(1),
    )  # fmt: skip
    c = sensor_coefficients(exact())
    told = imu_measured(still.attitude[0], still.velocity[0], still.acceleration[0], 0.0, c, np.zeros(9))
    assert tuple(told) == (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -GRAVITY)


def test_a_steady_turn_is_felt_at_the_lever_arm_as_centripetal() -> None:
    """1 rad/s about down, the IMU 0.2 m ahead: 0.2 m/s^2 backwards; the log there drifts to starboard by 0.2 m/s."""
    sensors = exact(
        imu=replace(exact().imu, position=(0.2, 0.0, 0.0)), velocity=replace(exact().velocity, position=(0.2, 0.0, 0.0))
    )
    truth = SimpleNamespace(
        time=0.2 * np.arange(2), position=np.zeros((2, 3)), attitude=np.array([[1.0, 0, 0, 0]] * 2),
        velocity=np.array([[0, 0, 0, 0, 0, 1.0]] * 2), acceleration=np.zeros((2, 6)), n=np.zeros((2, 0)),
        supply=np.ones(2), current=np.zeros(2),
    )  # fmt: skip
    found = read_trajectory(replace(sensors, imu=replace(sensors.imu, rate=5.0), depth=off(sensors.depth)), 0, truth)
    np.testing.assert_allclose(found["imu", -1].values[0, 4:], [0, 0, 1, -0.2, 0, -GRAVITY], atol=1e-15)
    np.testing.assert_allclose(found["velocity", -1].values[0], [0, 0.2, 0], atol=1e-15)


def off(sensor: Sensor) -> Sensor:
    return replace(sensor, rate=0.0)


def test_readings_are_those_of_points_that_move_with_the_body() -> None:
    """Places of the sensors differentiated numerically, with rotations of another library."""
    mount = (0.1, -0.2, 0.4)
    imu = replace(exact().imu, position=(0.3, -0.2, 0.1), rotation=mount)
    log = replace(exact().velocity, position=(-0.4, 0.1, 0.3), rotation=(0.0, 0.3, -1.0))
    depth = replace(exact().depth, position=(0.5, -0.3, 0.2))
    time = 0.1 * np.arange(40)
    truth = moving(time)
    found = read_trajectory(
        exact(imu=replace(imu, rate=10.0), velocity=log, depth=depth, tachometer=off(exact().tachometer)), 0, truth
    )

    def place(t: np.ndarray, arm: tuple[float, ...]) -> np.ndarray:
        return wobble(t)[1] + rotations(t).apply(arm)

    h = 1e-3
    t = 1e-9 * found["imu", -1].taken
    to_imu = Rotation.from_euler("ZYX", mount[::-1])
    felt = (place(t + h, imu.position) - 2 * place(t, imu.position) + place(t - h, imu.position)) / h**2
    felt = to_imu.inv().apply(rotations(t).inv().apply(felt - [0, 0, GRAVITY]))
    np.testing.assert_allclose(found["imu", -1].values[:, 7:], felt, atol=1e-6)
    turn = (rotations(t) * to_imu).inv() * Rotation.from_quat(found["imu", -1].values[:, [1, 2, 3, 0]])
    assert turn.magnitude().max() < 1e-14
    rate = ((rotations(t - h) * to_imu).inv() * (rotations(t + h) * to_imu)).as_rotvec() / (2 * h)
    np.testing.assert_allclose(found["imu", -1].values[:, 4:7], rate, atol=1e-6)

    t = 1e-9 * found["velocity", -1].taken
    over_ground = (place(t + h, log.position) - place(t - h, log.position)) / (2 * h)
    seen = (rotations(t) * Rotation.from_euler("ZYX", log.rotation[::-1])).inv().apply(over_ground)
    np.testing.assert_allclose(found["velocity", -1].values, seen, atol=1e-6)
    t = 1e-9 * found["depth", -1].taken
    np.testing.assert_allclose(found["depth", -1].values[:, 0], place(t, depth.position)[:, 2], atol=1e-14)


def test_live_and_along_a_trajectory_the_readings_are_the_same_bits() -> None:
    sensors = replace(
        DEFAULT,
        velocity=replace(DEFAULT.velocity, lost_share=0.3, phase=0.07, delay=0.06),
        depth=replace(DEFAULT.depth, delay=0.25),
    )
    truth = moving(0.01 * np.arange(1001))
    series = read_trajectory(sensors, 7, truth)
    came = live(sensors, 7, truth)
    for (name, thruster), expected in series.items():
        mine = [(now, r) for now, r in came if (r.sensor, r.thruster) == (name, thruster)]
        there = expected.available <= 1000 * TICK
        assert np.sum(there) > 40
        np.testing.assert_array_equal([r.stamp for _, r in mine], expected.stamps[there])
        np.testing.assert_array_equal([now for now, _ in mine], expected.available[there])
        np.testing.assert_array_equal(np.array([r.values for _, r in mine]), expected.values[there])


def test_a_sensor_that_is_switched_off_or_changed_leaves_all_others_as_they_are() -> None:
    truth = moving(0.01 * np.arange(301))
    before = read_trajectory(DEFAULT, 3, truth)
    for name in QUANTITIES:
        for changed in (off(getattr(DEFAULT, name)), replace(getattr(DEFAULT, name), lost_share=0.4, delay=0.1)):
            after = read_trajectory(replace(DEFAULT, **{name: changed}), 3, truth)
            for key in before:
                if key[0] != name:
                    np.testing.assert_array_equal(after[key].values, before[key].values)
    assert ("tachometer", 2) in before and len({tuple(s.values[:, 0]) for s in before.values()}) == len(before)


def test_another_seed_is_another_noise_of_the_same_size() -> None:
    truth = moving(0.01 * np.arange(2001))
    true = read_trajectory(exact(), 0, truth)
    errors = []
    for seed in range(8):
        errors.append(read_trajectory(DEFAULT, seed, truth)["depth", -1].values - true["depth", -1].values)
    assert np.std(errors) == pytest.approx(0.006, rel=3 / np.sqrt(2 * 1600))
    assert abs(np.corrcoef(errors[0][:, 0], errors[1][:, 0])[0, 1]) < 4 / np.sqrt(200)


def test_the_attitude_is_off_by_its_noise_about_each_axis() -> None:
    truth = moving(0.01 * np.arange(3001))
    told = Rotation.from_quat(read_trajectory(DEFAULT, 1, truth)["imu", -1].values[:, [1, 2, 3, 0]])
    error = (rotations(truth.time[1:]).inv() * told).as_rotvec()
    np.testing.assert_allclose(np.std(error, axis=0), 0.004, rtol=4 / np.sqrt(6000))


def test_losses_have_their_share_and_come_in_a_row_and_leave_the_noise_of_the_others() -> None:
    truth = moving(0.05 * np.arange(40_001))
    none = {name: off(getattr(DEFAULT, name)) for name in QUANTITIES if name != "velocity"}
    sure = replace(DEFAULT, **none, velocity=replace(DEFAULT.velocity, lost_share=0.0))
    often = replace(sure, velocity=replace(DEFAULT.velocity, lost_share=0.25, lost_length=4.0))
    whole = read_trajectory(sure, 5, truth)["velocity", -1].values
    holed = read_trajectory(often, 5, truth)["velocity", -1].values
    lost = np.isnan(holed[:, 0])
    starts = np.sum(lost[1:] & ~lost[:-1])
    assert lost.mean() == pytest.approx(0.25, abs=0.02)
    assert lost.sum() / starts == pytest.approx(4.0, rel=0.1)
    np.testing.assert_array_equal(holed[~lost], whole[~lost])
    assert np.isnan(holed[lost]).all()


def test_a_bias_lasts_for_a_run_and_scatters_between_runs() -> None:
    biased = exact(depth=replace(exact().depth, bias=(0.5,), bias_deviation=(0.1,)))
    truth = moving(0.01 * np.arange(101))
    true = read_trajectory(exact(), 0, truth)["depth", -1].values
    found = [read_trajectory(biased, seed, truth)["depth", -1].values - true for seed in range(200)]
    assert max(np.ptp(each) for each in found) < 1e-14
    means = [each.mean() for each in found]
    assert np.mean(means) == pytest.approx(0.5, abs=0.03) and np.std(means) == pytest.approx(0.1, rel=0.2)


def test_an_unsigned_tachometer_tells_magnitudes() -> None:
    truth = moving(0.01 * np.arange(501))
    signed = read_trajectory(DEFAULT, 2, truth)["tachometer", 1].values
    magnitude = read_trajectory(replace(DEFAULT, signed=False), 2, truth)["tachometer", 1].values
    assert signed.min() < -50.0
    np.testing.assert_array_equal(magnitude, np.abs(signed))


def with_tachometers(*effects: dict[str, dict[str, float]]) -> tuple[object, ...]:
    return tuple(effect_values(each) for each in effects)


def test_effects_of_one_tachometer_change_that_one_alone_and_live_as_along_a_trajectory() -> None:
    truth = moving(0.01 * np.arange(401))
    effects = with_tachometers({}, {"tach_lag": {"time": 0.1}, "tach_scale": {"share": 0.05}}, {})
    plain = read_trajectory(exact(), 3, truth)
    found = read_trajectory(exact(), 3, truth, effects=effects)
    for key in plain:
        same = np.array_equal(plain[key].values, found[key].values)
        assert same == (key != ("tachometer", 1)), key
    subject = Sensors(exact(), 3, 3, effects=effects)
    readings = [r for k in range(1, 401) for r in subject.read(k * TICK, at(truth, k))]
    told = [r.values for r in readings if (r.sensor, r.thruster) == ("tachometer", 1)]
    np.testing.assert_array_equal(told, found["tachometer", 1].values)
    # behind a lag of 0.1 s a sine of 1 rad/s is smaller and later
    settled = 1e-9 * found["tachometer", 1].taken[50:]
    late = 105.0 / np.sqrt(1.01) * np.sin(settled + 1.0 - np.arctan(0.1))
    np.testing.assert_allclose(found["tachometer", 1].values[50:, 0], late, atol=0.01)


def test_effects_at_neutral_change_no_bit_and_chains_do_not_hang_on_other_sensors() -> None:
    truth = moving(0.01 * np.arange(201))
    plain = read_trajectory(DEFAULT, 3, truth)["tachometer", 2].values
    neutral = read_trajectory(DEFAULT, 3, truth, effects=with_tachometers({}, {}, {}))["tachometer", 2].values
    np.testing.assert_array_equal(neutral, plain)
    lag = with_tachometers(*[{"tach_lag": {"time": 0.2}}] * 3)
    alone = replace(DEFAULT, imu=off(DEFAULT.imu), depth=off(DEFAULT.depth))
    np.testing.assert_array_equal(
        read_trajectory(alone, 3, truth, effects=lag)["tachometer", 0].values,
        read_trajectory(DEFAULT, 3, truth, effects=lag)["tachometer", 0].values,
    )
    assert [chain_step(replace(DEFAULT.tachometer, rate=rate)) for rate in (25.0, 1e3, 30.0)] == [
        TICK,
        10**6,
        3_030_303,
    ]


def test_the_battery_tells_sagging_voltage_and_current() -> None:
    truth = moving(0.01 * np.arange(101))
    found = read_trajectory(exact(), 0, truth)["battery", -1]
    at_readings = np.round(found.taken / TICK).astype(int)
    np.testing.assert_allclose(found.values[:, 0], 16.0 * truth.supply[at_readings], rtol=1e-15)
    np.testing.assert_allclose(found.values[:, 1], 1.5 + 100.0 * truth.current[at_readings], rtol=1e-15)


def test_the_tick_holds_every_instant_and_a_loop_knows_which_reading_is_due() -> None:
    sensors = replace(DEFAULT, velocity=replace(DEFAULT.velocity, phase=0.07))
    subject = Sensors(sensors, 0, 1)
    assert (subject.tick, subject.next_instant) == (TICK, TICK)
    taken = read_trajectory(sensors, 0, moving(0.01 * np.arange(101)))["velocity", -1].taken // TICK
    assert [tick for tick in range(101) if reading_of(tick, 7, 20) >= 0] == taken.tolist()
    assert [reading_of(tick, 7, 20) for tick in taken] == list(range(len(taken)))


def test_an_instant_left_out_is_named() -> None:
    truth = moving(0.01 * np.arange(4))
    subject = Sensors(DEFAULT, 0, 3)
    with pytest.raises(ValueError, match=r"imu: expected to be read at 0.01 s; found 0.02 s: advance .* by 0.01 s"):
        subject.read(2 * TICK, at(truth, 2))
    with pytest.raises(ValueError, match=r"imu: .*found nothing at 0.01 s, though it lasts from 0 to 0.6 s"):
        read_trajectory(DEFAULT, 0, moving(0.02 * np.arange(31)))


@pytest.mark.parametrize(
    ("before", "after", "sentence"),
    [
        ("rate: {value: 5.0, unit: Hz", "rate: {value: 5.0, unit: rpm", "velocity.rate.unit': expected 'Hz'; found"),
        ("signed: {value: true", "signed: {value: 3", "key 'tachometer.signed.value': expected true or false; found 3"),
        ("velocity_noise: {value: 0.008", "velocity_noise: {value: [1, 2]", r"a number or 3; found \[1, 2\]"),
        ("  depth_noise:", "  deep_noise:", "key 'depth.deep_noise': unknown; known are rate, .*depth_noise"),
        ("  depth_noise:", "  deep_noise:", "depth_noise.*; a diagnosis reads position alone"),
        ("signed: {value: true", "sined: {value: true", "known are rate, .*signed.*; a diagnosis reads none of it"),
        ("depth:\n", "dept:\n", "key 'dept': expected one of imu, velocity, depth, tachometer, battery"),
        ("lost_share: {value: 0.02", "lost_share: {value: 0.9", "velocity: lost_share: expected 0 to 0.75"),
        ("rate: {value: 5.0", "rate: {value: -5.0", "velocity: rate: expected 0 to 10000 Hz; found -5.0"),
        ("rate: {value: 100.0", "rate: {value: 0.3", None),
        ("depth_noise: {value: 0.006", "depth_noise: {value: -0.006", "depth: noise, bias_deviation: expected 0"),
        ("imu:", "imu: [", "expected YAML; found"),
        ("nominal_voltage: {value: 16.0", "nominal_voltage: {value: 0.0", "battery: nominal_voltage: expected more"),
        ("nominal_voltage: {value: 16.0", "nominal_voltage: {value: .nan", "expected more than 0 V, finite.*nan$"),
    ],
)  # fmt: skip
def test_wrong_settings_are_refused_in_sentences(before: str, after: str, sentence: str | None) -> None:
    from importlib import resources

    text = (resources.files("rov_sim") / "vehicle/sensors/vehicle_sensors.yaml").read_text("utf-8")
    assert before in text
    changed = text.replace(before, after, 1)
    if sentence is None:
        assert parse_sensors(changed, origin="mine.yaml").imu.period == 3_333_333_333
        return
    with pytest.raises(SensorSettingsError, match=f"mine.yaml: .*{sentence}"):
        parse_sensors(changed, origin="mine.yaml")


def test_a_file_with_places_alone_has_all_else_from_the_package() -> None:
    own = "depth: {position: {value: [-0.2, 0.0, 0.1], unit: m, source: measured}}"
    mine = parse_sensors(own, origin="mine.yaml")
    assert mine.depth.position == (-0.2, 0.0, 0.1) and mine.depth.noise == DEFAULT.depth.noise
    assert (mine.imu, mine.velocity, mine.battery) == (DEFAULT.imu, DEFAULT.velocity, DEFAULT.battery)


def test_a_place_may_be_in_other_units_of_its_quantity() -> None:
    told = (
        "value: [0, 0, 45], unit: deg, source: bracket}, position: {value: [-200, 0, 100], unit: mm, source: measured"
    )
    mine = parse_sensors(f"velocity: {{rotation: {{{told}}}}}", origin="mine.yaml").velocity
    np.testing.assert_allclose(mine.rotation, (0.0, 0.0, np.pi / 4.0))
    np.testing.assert_allclose(mine.position, (-0.2, 0.0, 0.1))


@pytest.mark.parametrize(
    ("value", "sentence"),
    [("0.3", "key 'velocity.position.value': expected 3 numbers; found 0.3"),
     ("[18, 0, 0]", "velocity: position: expected at most 10 m from the origin")],
)  # fmt: skip
def test_a_place_is_three_numbers_on_the_vehicle(value: str, sentence: str) -> None:
    with pytest.raises(SensorSettingsError, match=sentence):
        parse_sensors(f"velocity: {{position: {{value: {value}, unit: m, source: measured}}}}", origin="mine.yaml")


def test_the_random_wrench_has_its_sizes_and_time_and_is_the_same_period_by_period() -> None:
    wrench = RandomWrench(size=(4.0, 2.0, 0.0, 0.1, 0.5, 1.0), time=2.0)
    w = wrench.series(200_000, 0.1, 4)
    independent = 200_000 * 0.1 / 4.0  # samples worth, of a mean square: half of tau each
    np.testing.assert_allclose(w.std(axis=0), wrench.size, rtol=4 / np.sqrt(2 * independent))
    for lag in (5, 20):
        correlation = [np.corrcoef(w[lag:, j], w[:-lag, j])[0, 1] for j in (0, 1, 3, 4, 5)]
        np.testing.assert_allclose(correlation, np.exp(-0.1 * lag / 2.0), atol=0.05)
    stream = WrenchStream(wrench, 0.1, 4)
    np.testing.assert_array_equal(np.concatenate([stream.take(1) for _ in range(50)]), w[:50])
    assert RandomWrench().series(3, 0.1, 0).any() == np.False_


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"size": (1.0,)}, "size: expected six finite numbers"),
        ({"time": -1.0}, "time: expected a finite number of seconds"),
    ],
)
def test_a_wrong_random_wrench_is_refused(values: dict[str, object], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        RandomWrench(**values)  # type: ignore[arg-type]
