"""What effects do to vectors and turns of a sensor, along or about one of its axes."""

from rov_sim.vehicle.sensors.coefficients import Quaternion, Vector
from thruster_model.equations.attitude import quaternion_product
from thruster_model.equations.rotation_vector import rotation

__all__ = ["AXES", "moved", "scaled", "turned"]

AXES = ("x", "y", "z")


def scaled(vector: Vector, axis: str | None, share: float) -> Vector:
    """Return a vector whose entry of `axis` is (1 + share) times as large; None: all entries."""
    x, y, z = (v * (1.0 + share) if axis in (None, name) else v for v, name in zip(vector, AXES, strict=True))
    return x, y, z


def moved(vector: Vector, axis: str, by: float) -> Vector:
    """Return a vector moved `by` along `axis`."""
    x, y, z = (v + by if axis == name else v for v, name in zip(vector, AXES, strict=True))
    return x, y, z


def turned(attitude: Quaternion, axis: str, angle: float) -> Quaternion:
    """Return a turn of a sensor's axes, turned on by `angle` [rad] about its own `axis`."""
    about = AXES.index(axis)
    w, x, y, z = quaternion_product(attitude, rotation(tuple(angle if i == about else 0.0 for i in range(3))))
    return float(w), float(x), float(y), float(z)
