"""A vehicle's attitude rates from what its thrusters push: model, fit to recordings, scores."""
