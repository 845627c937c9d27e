"""Diagnosis of a vehicle: which thruster, axis, sensor or wire is behind the gap, or the water, or none of them."""
