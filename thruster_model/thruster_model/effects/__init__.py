"""Unmodelled effects: defined once, simulated, diagnosed and exported from that definition."""
