"""Print the rows of every benchmark as one table; what is being measured goes to standard error.

Of the graph, "ours" is all nodes in one process and "plain" a process each; of the recorder, "plain" is what was
published, and the whole of a core.
"""

import importlib
import subprocess
import sys
import time

MODULES = (
    "thruster_model.benchmark", "thruster_estimation.benchmark", "rov_sim.benchmark", "run_bag.benchmark",
    "run_bag.live.benchmark", "thruster_runtime.benchmark", "rov_sim.vehicle.graph_benchmark",
)  # fmt: skip
TIMES = ("ns", "us", "ms", "s")
COLD_START = (
    "from thruster_model.flow_tank import simulate;"
    "from thruster_model.parameter_set_io import load_parameter_set as load;"
    "simulate(load('hq').coefficients, [1.0], 0.01)"
)


def main() -> None:
    """Measure and print."""
    print(f"{'what':<42}{'unit':<14}{'ours':>14}{'plain':>14}  ours is", flush=True)
    for module in MODULES:
        print(f"measuring {module.removesuffix('.benchmark')}", file=sys.stderr, flush=True)
        for row in importlib.import_module(module).rows():
            ours, plain = (f"{x:>14,.{0 if x >= 100.0 else 1}f}" for x in (row.ours, row.plain))
            said = compared(row.ours, row.plain, row.unit)
            print(f"{row.what:<42}{row.unit:<14}{ours}{plain}  {said}", flush=True)
    print(f"{'process with a plant, from its cache':<42}{'s':<14}{_cold_start():>14.2f}")


def compared(ours: float, plain: float, unit: str) -> str:
    """Return how many times ours is better or worse: of times less is better, of all else more."""
    better = plain / ours if unit in TIMES else ours / plain
    return f"{better:.3g} x better" if better >= 1.0 else f"{1.0 / better:.3g} x worse"


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
