"""Models, parameter sets, compiled plants and identification of underwater thrusters."""

import run_bag.missing_modules  # noqa: F401  what is missing is said in a sentence
