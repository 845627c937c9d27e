"""A vehicle driven by thrusters that are a maker's table: the table's force at the battery's voltage, nothing else."""

import numpy as np
import pytest

from rov_sim.vehicle.plant import VehiclePlant, VehicleSettings, simulate
from thruster_model.flow_tank import simulate as simulate_in_tank
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.vehicle_set_io import load_vehicle_set

pytestmark = pytest.mark.long

SET = load_parameter_set("force_table")
PULSES = np.array([1700.0, 1700.0, 1350.0, 1350.0, 1560.0, 1440.0])
PERIOD = 0.04


@pytest.fixture(scope="module")
def settings() -> VehicleSettings:
    """A standard BlueROV2 on a battery at 12.6 V of nominally 14 V."""
    coefficients = load_vehicle_set("bluerov2").coefficients._replace(supply=0.9)
    return VehicleSettings(coefficients=coefficients, thrusters=(SET.coefficients,) * 6)


def test_each_thruster_settles_at_its_table_s_force_at_the_battery_s_voltage(settings: VehicleSettings) -> None:
    assert SET.force_table is not None
    run = simulate(settings, np.tile(SET.command.throttle(PULSES), (50, 1)), PERIOD)
    assert run.thrust[-1] == pytest.approx(SET.force_table.force_at(PULSES, 12.6), abs=1e-4)
    assert run.n[-1] == pytest.approx(SET.force_table.value("speed", PULSES, 12.6), abs=1e-3)
    assert np.linalg.norm(run.velocity[-1][:3]) > 0.2


def test_on_its_way_it_is_the_thruster_in_its_tank(settings: VehicleSettings) -> None:
    u = SET.command.throttle(PULSES)
    run = simulate(settings, np.tile(u, (10, 1)), PERIOD)
    alone = simulate_in_tank(SET.coefficients, np.full(10, u[0]), PERIOD, supply=np.full(10, 0.9))
    assert run.thrust[:, 0] == pytest.approx(alone.thrust, abs=1e-3)


def test_period_by_period_it_is_the_same_to_the_bit(settings: VehicleSettings) -> None:
    u = SET.command.throttle(PULSES)
    whole = simulate(settings, np.tile(u, (5, 1)), PERIOD)
    plant = VehiclePlant(settings)
    for k in range(5):
        truth = plant.advance(u, PERIOD)
        assert truth.thrust.tobytes() == whole.thrust[k + 1].tobytes()
