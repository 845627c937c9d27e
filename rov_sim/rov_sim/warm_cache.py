"""Compile the vehicle's kernels into the cache:   python -m rov_sim.warm_cache"""

from dataclasses import replace

import numpy as np

from rov_sim.vehicle.plant import VehiclePlant, simulate
from rov_sim.vehicle.settings_io import load_vehicle_settings
from thruster_model.effects.stages import NEUTRAL, NO_EFFECTS


def main() -> None:
    """Run each kernel once with arguments of the types that it is used with."""
    settings = load_vehicle_settings("ngs")
    simulate(settings, np.zeros((2, settings.count)), 0.01)
    for effects in (NO_EFFECTS, NEUTRAL):  # a vehicle whose thrusters are made to fail, or have an effect, has others
        plant = VehiclePlant(replace(settings, effects=settings.count * (effects,)))
        plant.advance(np.zeros(settings.count), 0.01)


if __name__ == "__main__":
    main()
