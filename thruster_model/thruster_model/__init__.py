"""Models, parameter sets, compiled plants and identification of underwater thrusters."""
