"""From a vehicle's set point and state to the wrench that takes it there: (2.22) and its baselines."""
