"""The navigation believes in the sensors that are simulated by default."""

import pytest
from rov_sim.vehicle.sensors.believed import navigation_settings
from rov_sim.vehicle.sensors.settings_io import load_sensors

from thruster_estimation.navigation_parameters import NAVIGATION_PARAMETERS, chosen_settings


def test_the_nodes_defaults_are_the_places_and_noise_of_the_simulated_sensors() -> None:
    sensors = load_sensors()
    believed = chosen_settings({p.name: p.default for p in NAVIGATION_PARAMETERS})
    expected = navigation_settings(sensors)
    for name in believed._fields:
        if name not in ("gyro_bias_deviation", "force_bias_deviation"):
            assert getattr(believed, name) == pytest.approx(getattr(expected, name), abs=1e-15), name


def test_the_nodes_defaults_wait_for_readings_at_the_simulated_rates() -> None:
    defaults, sensors = {p.name: p.default for p in NAVIGATION_PARAMETERS}, load_sensors()
    for name in ("velocity", "depth"):
        sensor = getattr(sensors, name)
        assert defaults[f"{name}_every"] == pytest.approx(1.0 / sensor.rate + sensor.delay)
