"""The vehicle period by period: the plant's own numbers, sensors in between, failures, throttles nobody answers for."""

from dataclasses import replace
from math import nan

import numpy as np
import pytest

from rov_sim.vehicle.effects.active import ActiveVehicleEffect
from rov_sim.vehicle.effects.words import effects_of_words
from rov_sim.vehicle.failure_words import parse_failures
from rov_sim.vehicle.held_throttles import HeldThrottles
from rov_sim.vehicle.live import Failing, FailureKind, Instant, LiveSettings, LiveVehicle, Losing
from rov_sim.vehicle.noisy_odometry import OdometryNoise
from rov_sim.vehicle.plant import VehicleSettings, simulate
from rov_sim.vehicle.random_wrench import RandomWrench
from rov_sim.vehicle.sensors.settings_io import load_sensors
from thruster_model.effects.stages import NEUTRAL, effect_values
from thruster_model.equations.thruster import thrust
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.vehicle_set_io import load_vehicle_set

PERIOD = 0.04
THROTTLES = (2.0, 1.8, 2.2, 1.6, -1.5, -2.0)


def settings(**given: object) -> LiveSettings:
    thrusters = (load_parameter_set("hq").coefficients,) * 6
    plant = VehicleSettings(coefficients=load_vehicle_set("ngs").coefficients, thrusters=thrusters)
    return LiveSettings(**{"plant": plant, "sensors": load_sensors(), "period": PERIOD, **given})  # type: ignore[arg-type]


def dive(given: LiveSettings, periods: int = 25) -> list[Instant]:
    vehicle = LiveVehicle(given)
    return [vehicle.advance(THROTTLES) for _ in range(periods)]


def test_it_moves_as_the_plant_does_under_the_same_throttles_and_wrenches() -> None:
    wrench = RandomWrench(size=(3.0, 3.0, 3.0, 0.3, 0.3, 0.3), time=1.0)
    given = settings(wrench=wrench, seed=4)
    found = dive(given)
    run = simulate(given.plant, np.tile(THROTTLES, (25, 1)), PERIOD, wrench=wrench.series(25, PERIOD, 4))
    for k, instant in enumerate(found, start=1):
        np.testing.assert_allclose(instant.truth.position, run.position[k], rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(instant.truth.velocity, run.velocity[k], rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(instant.truth.n, run.n[k], rtol=1e-12)


def test_every_sensor_reads_at_its_own_instants() -> None:
    found = dive(settings())
    stamps = {name: [] for name in ("imu", "velocity", "depth", "tachometer", "battery")}  # type: ignore[var-annotated]
    for instant in found:
        for reading in instant.readings:
            assert instant.time - 40_000_000 < reading.stamp <= instant.time
            stamps[reading.sensor].append(reading.stamp)
    assert {name: len(each) for name, each in stamps.items()} == {
        "imu": 100, "velocity": 5, "depth": 10, "tachometer": 150, "battery": 5,
    }  # fmt: skip
    assert np.unique(np.diff(stamps["imu"])).tolist() == [10_000_000]


def test_one_seed_is_one_run_and_another_seed_is_another() -> None:
    noise = OdometryNoise(0.01, 0.01, 0.01)
    first, again, other = (dive(settings(seed=seed, noise=noise), 5)[-1] for seed in (1, 1, 2))
    assert repr(first) == repr(again)
    assert repr(first.odometry) != repr(other.odometry) and repr(first.readings) != repr(other.readings)


def test_the_odometry_is_the_truth_where_it_has_no_noise() -> None:
    last = dive(settings())[-1]
    np.testing.assert_allclose(last.odometry.attitude, last.truth.attitude, rtol=0.0, atol=1e-15)
    np.testing.assert_array_equal(last.odometry.velocity, last.truth.velocity)


def test_failing_thrusters_fail_in_time() -> None:
    failures, _ = parse_failures("T2 dead at 0.4 s; T3 weak 0.5 at 0.4; T4 stuck at 0.4 s")
    whole = dive(settings())
    vehicle = LiveVehicle(settings(failures=failures))
    found = [vehicle.advance(THROTTLES if k < 10 else 6 * (0.0,)) for k in range(25)]
    assert [len(instant.failed) for instant in found] == 9 * [0] + [3] + 15 * [0]
    assert found[9].truth.thrust[0] == whole[9].truth.thrust[0]
    assert found[10].truth.thrust[1] == 0.0 and found[10].truth.n[1] > 10.0, "it turns without thrust"
    assert found[-1].truth.u[3] == THROTTLES[3], "its throttle stays"
    assert found[-1].truth.u[0] == 0.0
    held = LiveVehicle(settings(failures=failures))
    weak = [held.advance(THROTTLES) for _ in range(11)][-1]
    p = load_parameter_set("hq").coefficients
    healthy = thrust(weak.truth.n[2], weak.truth.axial[2], p)
    assert weak.truth.thrust[2] == pytest.approx(0.5 * healthy, rel=1e-12), "half of what its speed and flow give"
    assert healthy > whole[10].truth.thrust[2], "as half the thrust makes less flow"


def test_a_weak_thruster_is_one_that_loses_thrust_from_then_on() -> None:
    weak = LiveVehicle(settings(failures=parse_failures("T3 weak 0.5 at 0 s")[0]))
    found = [weak.advance(THROTTLES) for _ in range(26)][-1].truth
    lossy = settings()
    effects = [NEUTRAL] * 6
    effects[2] = effect_values({"thrust_loss": {"share": 0.5}})
    once = LiveVehicle(replace(lossy, plant=replace(lossy.plant, effects=tuple(effects))))
    expected = [once.advance(THROTTLES) for _ in range(26)][-1].truth
    assert found.thrust[2] == pytest.approx(expected.thrust[2], rel=1e-3), "with the flow that so much thrust makes"
    assert found.axial[2] == pytest.approx(expected.axial[2], rel=1e-2)


def test_a_failure_does_not_make_a_plant_forget_commands_that_are_under_way() -> None:
    late = settings()
    effects = (effect_values({"command_delay": {"time": 0.1}}),) * 6
    late = replace(late, plant=replace(late.plant, effects=effects))
    whole, failing = (
        LiveVehicle(replace(late, failures=parse_failures(text)[0])) for text in ("", "T1 weak 0.5 at 0.4 s")
    )
    rising = [tuple(0.1 * k * np.ones(6)) for k in range(15)]
    expected, found = ([vehicle.advance(u).truth for u in rising][-1] for vehicle in (whole, failing))
    np.testing.assert_allclose(found.n[1:], expected.n[1:], rtol=1e-4)


def test_a_thruster_that_is_elsewhere_has_the_speed_that_is_told() -> None:
    vehicle = LiveVehicle(settings())
    for _ in range(5):
        now = vehicle.advance((2.0, *5 * (0.0,)), {0: 40.0})
    simulated = dive(settings(), 5)[-1].truth.n[0]
    assert 40.0 < now.truth.n[0] < simulated - 5.0, "from the speed that it had a period ago"
    assert now.truth.thrust[0] > 1.0
    assert now.truth.n[1] == 0.0


def test_a_rotor_that_has_stopped_stands_still_whatever_is_told() -> None:
    given = settings()
    stopped = given.plant.coefficients._replace(turning=np.array([0.0, 1.0, 1.0, 1.0, 1.0, 1.0]))
    vehicle = LiveVehicle(replace(given, plant=replace(given.plant, coefficients=stopped)))
    now = [vehicle.advance(6 * (0.0,), {0: 40.0, 1: 40.0}) for _ in range(3)][-1]
    assert now.truth.n[0] == 0.0 and now.truth.n[1] > 10.0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("T2 broken at 3 s", "expected such as 'T2 dead at 12 s'"),
        ("T0 dead at 3 s", "expected such as"),
        ("T1 weak at 3 s", "expected such as"),
        ("T1 dead 0.5 at 3 s", "expected such as"),
        ("T1 dead at 3.4.5 s", "expected such as"),
        ("tachometer lost at 3 s", "expected such as"),
    ],
)
def test_failures_that_cannot_be_read_are_said(text: str, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        parse_failures(text)


def test_failures_that_cannot_be_are_said() -> None:
    with pytest.raises(ValueError, match="expected T1 to T6; found T7"):
        settings(failures=(Failing(6, FailureKind.DEAD, 1.0),))
    with pytest.raises(ValueError, match=r"expected an effectiveness between 0 and 1; found 1\.5"):
        settings(failures=(Failing(0, FailureKind.WEAK, 1.0, 1.5),))
    with pytest.raises(ValueError, match=r"lost: expected one of imu, velocity, depth, battery; found 'sonar'"):
        settings(lost=(Losing("sonar", 1.0),))
    with pytest.raises(ValueError, match=r"expected a time of 0 s or more; found -1\.0"):
        settings(lost=(Losing("depth", -1.0),))


def test_a_lost_sensor_tells_nothing_from_its_time_on_and_all_else_is_as_before() -> None:
    _, lost = parse_failures("Depth lost at 0.4 s")
    assert lost == (Losing("depth", 0.4),)
    whole, without = dive(settings()), dive(settings(lost=lost))
    for one, other in zip(whole, without, strict=True):
        for reading, told in zip(one.readings, other.readings, strict=True):
            gone = reading.sensor == "depth" and reading.taken >= 400_000_000
            assert all(np.isnan(told.values)) if gone else repr(told) == repr(reading)
        assert repr(one.truth) == repr(other.truth)


def test_a_sensor_that_is_not_there_is_not_waited_for() -> None:
    sensors = load_sensors()
    without = replace(sensors, velocity=replace(sensors.velocity, rate=0.0))
    assert not [r for instant in dive(settings(sensors=without)) for r in instant.readings if r.sensor == "velocity"]


def test_effects_are_named_by_words() -> None:
    found = effects_of_words(
        ["coulomb_friction[T2].deceleration=60", "velocity_scale[axis=x].share=0.05", "depth_bias.offset=0.1"]
    )
    assert found == (
        ActiveVehicleEffect(id="coulomb_friction", sizes={"deceleration": 60.0}, thruster=1),
        ActiveVehicleEffect(id="velocity_scale", sizes={"share": 0.05}, axis="x"),
        ActiveVehicleEffect(id="depth_bias", sizes={"offset": 0.1}),
    )


@pytest.mark.parametrize("word", ["depth_bias", "depth_bias.offset=deep", "depth_bias[x].offset=1", "a[T1,T2,T3].b=1"])
def test_words_that_name_no_effect_are_said(word: str) -> None:
    with pytest.raises(ValueError, match=r"expected EFFECT\.PARAMETER=SIZE or EFFECT"):
        effects_of_words([word])


def test_a_throttle_that_stays_away_is_zero_and_all_are_where_a_word_is_missing() -> None:
    held = HeldThrottles(2, 0.12)
    held.watch(["rov/wrench"])
    held.heard("rov/wrench", 0.0)
    held.hold(0, 2.0, 0.0)
    held.hold(1, nan, 0.0)
    assert held.values == [2.0, 0.0] and held.at(0.1) == [2.0, 0.0]
    held.hold(1, 1.0, 0.1)
    held.heard("rov/wrench", 0.1)
    assert held.at(0.2) == [0.0, 1.0] and held.silent(0.2) == ["thruster_0/throttle"]
    held.hold(0, 2.0, 0.3)
    held.hold(1, 1.0, 0.3)
    assert held.at(0.3) == [0.0, 0.0] and held.silent(0.3) == ["rov/wrench"]
