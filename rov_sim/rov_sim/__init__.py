"""Simulated benches and vehicles with their sensors."""
