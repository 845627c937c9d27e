"""Compile the inner loops into the cache:   python -m thruster_control.warm_cache"""

from math import nan

from thruster_control.inner_loop import AT_REST, compiled_step
from thruster_control.strategies import STRATEGIES
from thruster_control.strategies_io import load_strategy


def main() -> None:
    """Step each strategy once with arguments of the types that it is used with."""
    for name in STRATEGIES:
        ready = load_strategy(name)
        compiled_step(AT_REST, 0.0, 0.0, 0.0, 0.0, True, 0.04, ready.settings, ready.coefficients, nan, 0.0)


if __name__ == "__main__":
    main()
