"""Readings of a vehicle that rocks in one place, as columns of a table."""

import numpy as np

TIME = 5.0 + 0.02 * np.arange(400)
WAVE = np.sin(TIME)
FORCE = {"ax": 0.5 * WAVE, "ay": 0.3 * WAVE, "az": -9.8 + 0 * WAVE}
GYRO = {f"g{a}": 40.0 * np.sin(TIME + k) for k, a in enumerate("xyz")}
PULSES = 1500 + np.round(200 * WAVE)
