"""Print the benchmark rows of every package that has a module `benchmark` as one table."""

import importlib
import subprocess
import sys
import time

PACKAGES = ("thruster_model", "thruster_estimation", "rov_sim", "run_bag")
COLD_START = (
    "from thruster_model.flow_tank import simulate;"
    "from thruster_model.parameter_set_io import load_parameter_set as load;"
    "simulate(load('hq').coefficients, [1.0], 0.01)"
)


def main() -> None:
    """Measure and print."""
    print(f"{'what':<42}{'unit':<14}{'ours':>14}{'plain':>14}{'ratio':>9}")
    for package in PACKAGES:
        for row in importlib.import_module(f"{package}.benchmark").rows():
            ratio = f"{row.ours / row.plain:8.1f}x"
            print(f"{row.what:<42}{row.unit:<14}{row.ours:>14,.0f}{row.plain:>14,.0f}{ratio:>9}")
    print(f"{'process with a plant, from its cache':<42}{'s':<14}{_cold_start():>14.2f}")


def _cold_start() -> float:
    """Return the time [s] from starting Python to the first simulated step, best of three."""
    times = []
    for _ in range(3):
        begin = time.perf_counter()
        subprocess.run([sys.executable, "-c", COLD_START], check=True)
        times.append(time.perf_counter() - begin)
    return min(times)


if __name__ == "__main__":
    main()
