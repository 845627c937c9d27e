"""Sensors, effects and navigation on the simulated vehicle: live and over a whole run."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from vehicle_motion import DEFAULT

from rov_sim.vehicle.effects.active import ActiveVehicleEffect, sensing_with, thruster_effects
from rov_sim.vehicle.plant import VehiclePlant, VehicleSettings, simulate
from rov_sim.vehicle.random_wrench import RandomWrench
from rov_sim.vehicle.sensors.believed import navigation_settings
from rov_sim.vehicle.sensors.coefficients import sensor_coefficients
from rov_sim.vehicle.sensors.live import Sensors
from rov_sim.vehicle.sensors.series import Series, read_trajectory
from thruster_estimation.navigation_output import NavigationHistory, navigate
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.vehicle_set_io import load_vehicle_set

TICK = 10_000_000  # ns
SECONDS = 30
WRENCH = RandomWrench(size=(2.0, 2.0, 2.0, 0.1, 0.1, 0.1), time=3.0).series(100 * SECONDS, 0.01, 5)


def settings_of() -> VehicleSettings:
    hq = load_parameter_set("hq").coefficients
    return VehicleSettings(coefficients=load_vehicle_set("ngs").coefficients, thrusters=(hq,) * 6)


def throttles() -> Any:
    t = np.repeat(0.04 * np.arange(25 * SECONDS), 4)
    return 2.0 * np.sin(np.outer(t, [0.3, 0.35, 0.4, 0.45, 0.2, 0.25]) + np.arange(6))


@pytest.fixture(scope="module")
def run() -> Any:
    return simulate(settings_of(), throttles(), 0.01, wrench=WRENCH)


EFFECTS = [
    ActiveVehicleEffect(id="gyro_scale", sizes={"share": 0.02}),
    ActiveVehicleEffect(id="imu_delay", sizes={"time": 0.03}),
    ActiveVehicleEffect(id="velocity_delay", sizes={"time": 0.05}),
    ActiveVehicleEffect(id="magnetic_disturbance", sizes={"angle": 0.1}),
    ActiveVehicleEffect(id="tach_lag", sizes={"time": 0.1}, thruster=2),
    ActiveVehicleEffect(id="tach_dropout", sizes={"threshold": 10.0}),
]


def test_on_the_plant_live_readings_are_those_of_the_whole_run_bit_for_bit(run: Any) -> None:
    c, own = sensing_with(sensor_coefficients(DEFAULT), EFFECTS), thruster_effects(EFFECTS, 6)
    expected = read_trajectory(DEFAULT, 11, run, c, own)
    plant, subject = VehiclePlant(settings_of()), Sensors(DEFAULT, 11, 6, c, own)
    came: dict[tuple[str, int], list[tuple[float, ...]]] = {key: [] for key in expected}
    for k, u in enumerate(throttles()[:600], start=1):
        plant.advance(u, 0.01, WRENCH[k - 1])
        for reading in subject.read(k * TICK, plant.truth(WRENCH[k])):  # of the period that begins
            came[reading.sensor, reading.thruster].append(reading.values)
    for key, series in expected.items():
        assert len(came[key]) > 25
        np.testing.assert_array_equal(came[key], series.values[: len(came[key])])


def navigated(run: Any, found: dict[tuple[str, int], Series]) -> NavigationHistory:
    heard = np.full((len(run.time) - 1, 14), np.nan)
    for name, columns in (("imu", slice(0, 10)), ("velocity", slice(10, 13)), ("depth", slice(13, 14))):
        series = found[name, -1]
        rows = np.ceil(series.stamps / TICK).astype(int) - 1
        inside = rows < len(heard)
        heard[rows[inside], columns] = series.values[inside]
    return navigate(heard, np.full(len(heard), 0.01), navigation_settings(DEFAULT))


def errors(run: Any, found: NavigationHistory) -> np.ndarray:
    """Return errors of depth, attitude about the earth's axes and velocity, from 5 s on, shape (K, 10)."""
    true, told = (Rotation.from_quat(q[:, [1, 2, 3, 0]]) for q in (run.attitude[1:], found.attitude))
    depth = run.position[1:, 2:] - found.position[:, 2:]
    return np.hstack((depth, (true * told.inv()).as_rotvec(), run.velocity[1:] - found.velocity))[500:]


def test_the_navigation_follows_the_vehicle_as_well_as_it_says(run: Any) -> None:
    shares = []
    for seed in range(6):
        found = navigated(run, read_trajectory(DEFAULT, seed, run))
        deviations = found.deviations[500:, [2, *range(3, 12)]]
        shares.append(np.mean((errors(run, found) / deviations) ** 2, axis=0))
    assert np.all(np.abs(run.velocity[500:]).max(axis=0) > 0.05), "a run in which it moves about every axis"
    assert np.all((np.mean(shares, axis=0) > 0.4) & (np.mean(shares, axis=0) < 2.2)), np.mean(shares, axis=0)


@pytest.mark.parametrize(
    ("effect", "column"),
    [
        (ActiveVehicleEffect(id="gyro_scale", sizes={"share": 0.3}), 9),
        (ActiveVehicleEffect(id="velocity_scale", sizes={"share": 0.3}), 4),
        (ActiveVehicleEffect(id="magnetic_disturbance", sizes={"angle": 0.3}), 3),
        (ActiveVehicleEffect(id="depth_bias", sizes={"offset": 0.5}), 0),
    ],
    ids=lambda each: getattr(each, "id", None),
)
def test_an_unknown_effect_of_a_sensor_misleads_the_navigation_where_it_acts(
    run: Any, effect: ActiveVehicleEffect, column: int
) -> None:
    c = sensing_with(sensor_coefficients(DEFAULT), [effect])
    sound = np.std(errors(run, navigated(run, read_trajectory(DEFAULT, 1, run)))[:, column])
    misled = np.sqrt(np.mean(errors(run, navigated(run, read_trajectory(DEFAULT, 1, run, c)))[:, column] ** 2))
    assert misled > 2.0 * sound
