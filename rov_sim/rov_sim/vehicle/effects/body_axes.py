"""The axes of a vehicle by name, one and in pairs such as `surge-pitch`."""

from thruster_model.vehicle_parameters import AXIS_NAMES

__all__ = ["AXIS_PAIRS", "BODY_AXES", "axis_index", "axis_pair"]

BODY_AXES = AXIS_NAMES
AXIS_PAIRS = tuple(f"{a}-{b}" for a in BODY_AXES for b in BODY_AXES if a != b)


def axis_index(axis: str) -> int:
    """Return the place of an axis in nu."""
    return BODY_AXES.index(axis)


def axis_pair(axes: str) -> tuple[int, int]:
    """Return the places of two axes in nu."""
    first, second = axes.split("-")
    return axis_index(first), axis_index(second)
