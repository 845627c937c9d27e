"""Where a vehicle's thrusters are, for its picture."""

import numpy as np

from rov_sim.vehicle.scene import Layout
from thruster_model.vehicle_set_io import load_vehicle_set

__all__ = ["layout_of"]


def layout_of(vehicle: str) -> Layout:
    """Return the layout of a vehicle set, by name or file.

    Raises:
        ThrusterModelError: there is none, or it is not valid.
    """
    thrusters = load_vehicle_set(vehicle).layout
    return Layout(np.array([each.position for each in thrusters]), np.array([each.axis for each in thrusters]))
