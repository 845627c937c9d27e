"""Estimators of the states of a thruster."""
