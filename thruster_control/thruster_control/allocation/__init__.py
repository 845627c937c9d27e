"""From a wrench on the vehicle to the thrust of each thruster: (2.21), limits, failures, dead zones."""
