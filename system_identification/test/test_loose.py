"""An effect whose size is one size is told from one that comes and goes."""

from dataclasses import replace

import numpy as np
import pytest
from spring import SLOTS, Spring, recorded, suspects

from system_identification.hypothesis import weighed
from system_identification.loose import CAPS, rests_of, unsteady
from system_identification.noise import whitener
from system_identification.suspects import Suspect
from system_identification.system import SizeSlot

OFFSET = SizeSlot("offset", "length", -0.3, 0.3, "m")


class Untared(Spring):
    """A spring whose sensor may have an offset, as an effect."""

    def _states(self, x):
        return Spring._states(replace(self, slots=()), x[:2])

    def predicted(self, x):
        return super().predicted(x) + (x[2] * OFFSET.width if self.slots else 0.0)


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


def _run_off_by(share, seed):
    """Return one run whose sensor rests at so many deviations of its noise."""
    plain = recorded(seed, push=0.0, runs=1)
    return Untared(forces=plain.forces, readings=(plain.readings[0] + share * plain.noise,), noise=plain.noise)


def _evidence_for_an_offset(system):
    offset, x = Suspect(effect="offset", channel="", slots=(OFFSET,), grid=np.array([[0.1]])), np.zeros(3)
    posed = system.with_effects((OFFSET,))
    none = weighed(system, (), x[:2], whitener(system, x[:2]))
    return weighed(posed, (offset,), x, whitener(posed, x)).evidence - none.evidence


@pytest.mark.parametrize(("share", "seed"), [(0.5, 58), (-0.7, 57), (0.9, 58)])
def test_a_rest_value_of_a_single_run_is_no_effect(share, seed):
    assert _evidence_for_an_offset(_run_off_by(share, seed)) < 0.0


@pytest.mark.parametrize(("share", "seed"), [(2.0, 56), (-4.0, 57)])
def test_an_offset_beyond_rest_values_is_one_of_a_single_run_too(share, seed):
    assert _evidence_for_an_offset(_run_off_by(share, seed)) > 6.0


def test_where_a_single_run_rests_is_told_at_the_level_that_rest_values_have_before_any_run():
    system = _run_off_by(0.5, 58)
    found = weighed(system, (), np.zeros(2), whitener(system, np.zeros(2)))
    assert found.loose.levels == {"rest": CAPS["rest"] / 3.0}
    assert np.mean(found.loose.explained) == pytest.approx(0.5 * system.noise, abs=0.15 * system.noise)


def test_where_a_sensor_rests_hangs_on_the_noise_of_its_readings_not_on_how_many_are_averaged():
    class Averaged(Spring):
        @property
        def single(self):
            return {"position": 0.03}

    plain = recorded(59)
    averaged = Averaged(forces=plain.forces, readings=plain.readings, noise=plain.noise)
    assert np.array_equal(rests_of(averaged), np.full((plain.measured.size, 1), 0.03))
