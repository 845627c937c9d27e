"""Compile the inner loops, and the usual outer loops, into the cache:   python -m thruster_control.warm_cache"""

from math import nan

import numpy as np

from thruster_control.allocation.failures import allocation
from thruster_control.allocation.limits import limits_of_sets
from thruster_control.allocation.settings import AllocationSettings
from thruster_control.inner_loop import AT_REST, compiled_step
from thruster_control.outer_loop.controller import Controller
from thruster_control.outer_loop.settings import VehicleSetPoint, euler_law, quaternion_law
from thruster_control.strategies import STRATEGIES
from thruster_control.strategies_io import load_strategy
from thruster_control.vehicle_loop import VehicleLoop
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.vehicle_set_io import load_vehicle_set


def main() -> None:
    """Step each strategy and outer loop once with arguments of the types that it is used with."""
    for name in STRATEGIES:
        ready = load_strategy(name)
        compiled_step(AT_REST, 0.0, 0.0, 0.0, 0.0, True, 0.04, ready.settings, ready.coefficients, nan, 0.0)
    vehicle, settings = load_vehicle_set("ngs").coefficients, AllocationSettings()
    limits = limits_of_sets(vehicle.thrusters * [load_parameter_set("hq").coefficients], 3.0)
    for law in (quaternion_law(1.0, 1.0), euler_law(1.0, 1.0)):
        controller = Controller(law, vehicle, limits, allocation(vehicle.K_t, settings))
        loop = VehicleLoop(controller, settings, 0.04)
        loop.advance(None, (1.0, 0.0, 0.0, 0.0), np.zeros(6), VehicleSetPoint(), np.full(vehicle.thrusters, nan))


if __name__ == "__main__":
    main()
