"""An effect whose size is one size is told from one that comes and goes."""

from dataclasses import replace

import numpy as np
import pytest
from spring import SLOTS, recorded, suspects

from system_identification.hypothesis import weighed
from system_identification.loose import unsteady
from system_identification.noise import whitener


def _found(system):
    suspect = next(each for each in suspects() if each.effect == "friction")
    posed, x = system.with_effects((SLOTS["friction"],)), np.array([0.0, 0.0, 0.3])
    return weighed(posed, (suspect,), x, whitener(posed, x))


def _evidence(system):
    found = _found(system)
    return unsteady(found.fitted, found.noise, found.loose, found.suspects)["friction"]


@pytest.mark.parametrize("seed", [51, 52])
def test_a_friction_that_is_always_there_is_steady(seed):
    assert _evidence(recorded(seed, push=0.5, friction=0.8)) < 0.0


@pytest.mark.parametrize("seed", [53, 54])
def test_a_friction_of_one_run_alone_is_not(seed):
    rubs, runs = recorded(seed, push=0.5, friction=1.2), recorded(seed, push=0.5)
    assert _evidence(replace(runs, readings=(rubs.readings[0], *runs.readings[1:]))) > 6.0


def test_a_size_that_differs_from_run_to_run_is_known_no_better_than_its_mean():
    sizes = (0.68, 0.8, 0.92)
    rubs = [recorded(55, push=0.5, friction=size) for size in sizes]
    mixed = replace(rubs[0], readings=tuple(each.readings[run] for run, each in enumerate(rubs)))
    found = _found(mixed)
    (place,) = found.sizes_of(found.suspects[0])
    deviation = np.sqrt(found.fitted.covariance[place, place]) * SLOTS["friction"].width
    assert found.loose.levels["shape"] > 0.03
    assert deviation > 0.8 * np.std(sizes) / np.sqrt(3)
    assert deviation > 0.8 * found.loose.levels["shape"] * np.mean(sizes) / np.sqrt(3)
