"""Compile the vehicle's kernels into the cache:   python -m rov_sim.warm_cache"""

import numpy as np

from rov_sim.vehicle.plant import VehiclePlant, simulate
from rov_sim.vehicle.settings_io import load_vehicle_settings


def main() -> None:
    """Run each kernel once with arguments of the types that it is used with."""
    settings = load_vehicle_settings("ngs")
    simulate(settings, np.zeros((2, settings.count)), 0.01)
    VehiclePlant(settings).advance(np.zeros(settings.count), 0.01)


if __name__ == "__main__":
    main()
