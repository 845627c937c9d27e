"""Identification: recordings prepared as experiments, fits of thruster models to them, and how far to trust those."""
