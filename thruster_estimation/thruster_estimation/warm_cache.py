"""Compile all observers and the navigation filter:   python -m thruster_estimation.warm_cache"""

import numpy as np

from thruster_estimation.belief import initial_belief
from thruster_estimation.navigation_belief import Heard, NavigationSettings, checked_navigation
from thruster_estimation.navigation_output import compiled_first, compiled_navigation, compiled_output, navigate
from thruster_estimation.offline import compiled_step, observe
from thruster_estimation.settings import OBSERVERS, bench_settings
from thruster_model.equations.thruster import ThrusterCoefficients


def main() -> None:
    """Run each kernel once with arguments of the types that it is used with."""
    zeros = dict.fromkeys(ThrusterCoefficients._fields, 0.0)
    coefficients = ThrusterCoefficients(**(zeros | {"k_n": 1.0, "drive_gain": 1.0}))
    belief = initial_belief(deviation_n=1.0, deviation_v=1.0, deviation_U=1.0)
    for observer in OBSERVERS:
        compiled_step(belief, 0.0, 0.0, 0.04, 0.0, bench_settings(observer), coefficients)
        observe(np.zeros(2), 0.0, 0.0, 0.04, belief, bench_settings(observer), coefficients)
    navigation = checked_navigation(NavigationSettings())
    begin = compiled_first(Heard(), navigation)[0]
    compiled_output(compiled_navigation(begin, Heard(), 0.01, navigation)[0], navigation)
    navigate(np.full((2, len(Heard._fields)), np.nan), np.full(2, 0.01), navigation)


if __name__ == "__main__":
    main()
