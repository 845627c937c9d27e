"""Write two logs as a stranger's logger would, for docs/own_csv.md: python3 docs/examples/own_csv.py FOLDER

The thruster is one of `thruster simulate`: its parameters are drawn, and it has an effect that no set has. The log has
names and units of its own: milliseconds, pulses, semicolons, decimal commas, a speed without a unit, a temperature.
"""

import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from run_bag import read_run

THRUSTER = ["--set", "simplified", "--spread", "0.05", "--seed", "4", "--effect", "coulomb_friction.deceleration=150"]
PERIOD, SENT = 0.01, 0.05  # s, of the log and of the commands
AT_REST = 1.15  # rad/s that the tachometer reads of a rotor at rest, which this logger takes off


def throttle(rng):
    """Return times [s] and throttle [V]: rest, steps of all sizes both ways, ramps through the dead zone, rest."""
    time = SENT * np.arange(round(40.0 / SENT))
    sizes = rng.permutation([4.5, 3.6, 3.0, 2.5, 2.0, 1.3, 0.0, -1.3, -2.0, -2.5, -3.0, -4.5])
    steps = sizes[np.clip((time - 2.0) / 1.5, 0, len(sizes) - 1).astype(int)]
    ramps = 3.5 * np.sin(2.0 * np.pi * (time - 20.0) / 9.0)
    return time, np.select([time < 2.0, time < 20.0, time < 38.0], [0.0, steps, ramps], 0.0)


def simulated(thruster, seed, folder):
    """Return a run of a thruster, with a programme and noise of its own, and the file with the thruster's numbers."""
    programme = folder / "programme.csv"
    with programme.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["time_s", "throttle_V"])
        rows.writerows(zip(*throttle(np.random.default_rng(seed)), strict=True))
    command = ["thruster", "simulate", *thruster, "--programme", str(programme), "--out", str(folder / "runs")]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return read_run(folder / "runs/programme_ambient"), folder / "runs/truth.yaml"


def write_log(run, path):
    """Write what was read last at each instant of the logger."""
    time = np.arange(0.1, run.duration - 0.1, PERIOD)
    u, n = run.align(["thruster_0/throttle.commanded", "thruster_0/state.n"], time, "previous").values()
    n = n - AT_REST * np.sign(n)
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, delimiter=";")
        rows.writerow(["t_ms", "esc", "tacho", "temp"])
        for cells in zip(1e3 * time, 1500.0 + 80.0 * u, n, np.full(time.size, 17.2), strict=True):
            rows.writerow([f"{x:.{digits}f}".replace(".", ",") for x, digits in zip(cells, (0, 3, 6, 1), strict=True)])


if __name__ == "__main__":
    out = Path(sys.argv[1])
    out.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as first, tempfile.TemporaryDirectory() as second:
        run, numbers = simulated(THRUSTER, 1, Path(first))
        write_log(run, out / "log_1.csv")
        run, _ = simulated(["--set", str(numbers), "--spread", "0", "--seed", "5"], 2, Path(second))
        write_log(run, out / "log_2.csv")
    sys.stdout.write(f"{out}: log_1.csv, log_2.csv\n")
