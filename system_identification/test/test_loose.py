"""An effect whose size is one size is told from one that comes and goes."""

from dataclasses import replace

import numpy as np
import pytest
from spring import SLOTS, recorded, suspects

from system_identification.hypothesis import traces_of, weighed
from system_identification.loose import unsteady
from system_identification.noise import whitener


def _evidence(system):
    suspect = next(each for each in suspects() if each.effect == "friction")
    posed, x = system.with_effects((SLOTS["friction"],)), np.array([0.0, 0.0, 0.3])
    found = weighed(posed, (suspect,), x, whitener(posed, x))
    return unsteady(found.fitted, found.noise, found.loose, traces_of(found.fitted, found.suspects))["friction"]


@pytest.mark.parametrize("seed", [51, 52])
def test_a_friction_that_is_always_there_is_steady(seed):
    assert _evidence(recorded(seed, push=0.5, friction=0.8)) < 0.0


@pytest.mark.parametrize("seed", [53, 54])
def test_a_friction_of_one_run_alone_is_not(seed):
    rubs, runs = recorded(seed, push=0.5, friction=1.2), recorded(seed, push=0.5)
    assert _evidence(replace(runs, readings=(rubs.readings[0], *runs.readings[1:]))) > 6.0
