"""A vehicle with its thrusters: the plant, its unmodelled effects and its sensors."""
