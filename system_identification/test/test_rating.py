"""The first look at suspects: what does as a parameter does is rated by how far the parameter could go back."""

from dataclasses import replace

import numpy as np
import pytest
from spring import NOMINAL, recorded, suspects

from system_identification.fitting import fit
from system_identification.noise import whitener
from system_identification.rating import rated, standing_in, tried

WRONG = 0.75
"""Of the stiffness: five of its deviations off."""


@pytest.mark.parametrize("share", [0.05, 1.0])
def test_what_does_as_a_parameter_does_is_worth_what_the_parameter_then_costs_less(share):
    system = recorded(17, push=0.0, stiffness=WRONG, damping=1.0)
    noise = whitener(system, np.zeros(2)).scattering(3.0)
    fitted = fit(system, noise, np.zeros(2), iterations=12)
    assert fitted.x[0] == pytest.approx(-5.0, abs=0.2)
    (cubic,) = (each for each in suspects() if each.effect == "cubic")
    softer = replace(cubic, effect="softer", grid=-share * np.array([[0.02], [0.3]]))

    def predicted(suspect):
        if suspect is cubic:
            return system.tried(fitted.x, suspect)
        stiffness = NOMINAL["stiffness"] + 1.5 * fitted.x[0]
        moved = [(stiffness * (1.0 + s) - NOMINAL["stiffness"]) / 1.5 for s in suspect.grid[:, 0]]
        return np.array([system.predicted(np.array([each, fitted.x[1]])) for each in moved])

    trials = tried(fitted, [softer, cubic], predicted)
    looks = {each.suspect.effect: each for each in standing_in(fitted, noise.scattering(1.0), trials)}
    assert set(looks) == {"softer"}, "what does something else has another look"
    first, back = fitted.x[0], 0.3 * share * WRONG / 0.05
    assert looks["softer"].gain == pytest.approx(first**2 - (first + back) ** 2, rel=0.1)
    if share == 1.0:  # what it leaves of a line is larger than what the deviations say
        by_rows = {each.suspect.effect: each for each in rated(fitted, noise.scattering(1.0), trials)}
        assert by_rows["softer"].gain < 0.5 * looks["softer"].gain
