"""Write a maker's sheet and a recording of a thruster like a T200: python3 docs/examples/t200.py FOLDER.

Invented numbers of the T200's size, and nothing of this project's code: a force over pulse and voltage, a rotor that
lags by 0.12 s, a battery that sags, a load cell's noise. Hidden in the recording: every command comes 0.15 s late.
"""

import csv
import sys
from pathlib import Path

import numpy as np

LATE, LAG, STEP = 0.15, 0.12, 0.002  # s


def force(pulse, volts):
    """Return the steady force [kgf] over the pulse [µs] and the supply [V]: a dead band, then nearly quadratic."""
    beyond = np.clip(np.abs(pulse - 1500.0) - 28.0, 0.0, None) / 372.0
    strength = np.where(pulse > 1500.0, 5.2, 4.1) * (volts / 16.0) ** 1.6
    return np.sign(pulse - 1500.0) * strength * beyond**1.7


def sheet(path):
    """Write the sheet: pulse, voltage, force, and the speed, which the recording does not have."""
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["PWM (µs)", "Voltage (V)", "Force (Kg f)", "RPM"])
        for volts in (12.0, 14.0, 16.0):
            for pulse in range(1100, 1901, 20):
                kgf = float(force(pulse, volts))
                rows.writerow([pulse, volts, f"{kgf:.4f}", round(1560.0 * abs(kgf) ** 0.5)])


def recording(path, seed=1):
    """Write 33 s at 50 Hz: rest, steps of all sizes, ramps through the dead band."""
    rng = np.random.default_rng(seed)
    pulses = np.concatenate([[1500.0], rng.choice([1500, 1620, 1700, 1800, 1380, 1300, 1220, 1650], 20)])
    steps = np.repeat(pulses, round(1.0 / STEP))
    ramps = 1500.0 + 330.0 * np.sin(2.0 * np.pi * 0.16 * STEP * np.arange(round(12.0 / STEP)))
    command = np.round(np.concatenate([steps, ramps]) / 2.0) * 2.0
    held = np.repeat(command[:: round(0.02 / STEP)], round(0.02 / STEP))  # sent at 50 Hz
    volts = 15.8 - 0.9 * np.arange(held.size) / held.size
    arriving = np.concatenate([np.full(round(LATE / STEP), 1500.0), held])[: held.size]
    steady = force(arriving, volts)
    wanted, speed = np.sign(steady) * np.sqrt(np.abs(steady)), np.zeros(held.size)
    for k in range(1, held.size):  # the rotor lags; the force is that of its speed
        speed[k] = wanted[k] + (speed[k - 1] - wanted[k]) * np.exp(-STEP / LAG)
    kgf = speed * np.abs(speed)
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["time_s", "pwm", "battery_mV", "thrust_kgf"])
        for k in range(0, held.size, round(0.02 / STEP)):
            read = kgf[k] + 0.02 * rng.standard_normal()
            rows.writerow([f"{k * STEP:.3f}", int(held[k]), round(1e3 * volts[k]), f"{read:.4f}"])


COLUMNS = """name: like a T200
source: docs/examples/t200.py, invented
command: {column: PWM (µs), unit: µs, stop: 1500}
supply: {column: Voltage (V), unit: V}
force: {column: Force (Kg f), unit: N, scale: 9.80665}
speed: {column: RPM, unit: rad/s, scale: 0.10471975511965977, signed: false}
"""

if __name__ == "__main__":
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True)
    sheet(folder / "sheet.csv")
    (folder / "columns.yaml").write_text(COLUMNS, encoding="utf-8")
    recording(folder / "log.csv")
    sys.stdout.write(f"{folder}: sheet.csv, columns.yaml, log.csv\n")
