"""What the sensors of a vehicle tell of its true states, live and over whole trajectories."""
