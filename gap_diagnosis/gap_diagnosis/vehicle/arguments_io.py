"""Which vehicle a command is about: the same arguments for all of them."""

import argparse
import sys
from collections.abc import Callable
from math import nan
from pathlib import Path

from gap_diagnosis.vehicle import rules
from thruster_model.vehicle_set_io import available_vehicles

__all__ = ["add_longest", "add_sets", "between", "told"]


def told(text: str) -> None:
    """Tell how far a command has come, beside what it prints."""
    sys.stderr.write(f"{text}\n")
    sys.stderr.flush()


def add_sets(parser: argparse.ArgumentParser) -> None:
    """Add the vehicle's set, its thrusters' and its sensors' to the arguments of a command."""
    sets = ", ".join(available_vehicles())
    parser.add_argument("--vehicle", metavar="SET", required=True, help=f"the vehicle's set: {sets} or a YAML file")
    text = "set of its thrusters, not of the vehicle; seldom needed, as the vehicle's set names it"
    parser.add_argument("--set", "--model", dest="set", metavar="THRUSTERS", help=text)
    parser.add_argument("--sensors", type=Path, help="its sensors and battery, a YAML file: see docs/own_dive.md")


def between(lower: float, upper: float) -> Callable[[str], float]:
    """Return the type of an argument that is a number from `lower` to `upper`."""

    def number(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = nan
        if not lower <= value <= upper:
            raise argparse.ArgumentTypeError(f"expected {lower:g} to {upper:g}; found {text}")
        return value

    return number


def add_longest(parser: argparse.ArgumentParser) -> None:
    """Add how much of long dives is used to the arguments of a command."""
    text = "of dives that are longer together, use so much, in stretches (default {:g} beyond {:g})"
    parser.add_argument("--longest", type=float, metavar="SECONDS", help=text.format(rules.THINNED, rules.LONGEST))
