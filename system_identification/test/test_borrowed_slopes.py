"""A fit beside an effect that turns every slope round does not take those of the system without it for its own."""

import numpy as np
from spring import recorded

from system_identification.fitting import fit
from system_identification.noise import whitener
from system_identification.system import SizeSlot

REVERSED = SizeSlot("scale", "share", -2.5, 0.0, "1")


def test_beside_a_reversed_reading_parameters_are_re_tuned_from_borrowed_slopes_too():
    system = recorded(61, push=0.2, scale=-2.0)
    nothing, turned = np.zeros(2), np.array([0.0, 0.0, -2.0 / REVERSED.width])
    posed = system.with_effects((REVERSED,))
    noise = whitener(posed, turned)
    near = fit(system, noise, nothing, iterations=0)
    borrowed, own = fit(posed, noise, turned, near=near, polish=False), fit(posed, noise, turned)
    assert abs(borrowed.cost - own.cost) < 1.0
    assert np.all(np.abs(borrowed.x - own.x) < 0.1)
    assert own.x[0] > 0.3  # the spring is 3 % stiffer than stated, and a deviation is 5 %
