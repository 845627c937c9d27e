"""A mass on a spring is fitted and diagnosed: what is hidden is named with its size, and nothing else is."""

import numpy as np
import pytest
from spring import recorded, suspects

from system_identification.budget import PARAMETERS, budget_of
from system_identification.fitting import fit
from system_identification.left_out import folds_of, left_out
from system_identification.noise import whitener
from system_identification.search import searched


@pytest.mark.parametrize("seed", [11, 12, 13, 14])
def test_a_disturbed_system_without_effect_has_none(seed):
    found = searched(recorded(seed, push=2.0), suspects)
    assert found.best.keys == ()


@pytest.mark.parametrize(
    ("effects", "seed"),
    [({"cubic": 1.0}, 21), ({"friction": 0.8}, 22), ({"friction": 0.8, "scale": 0.2}, 23), ({"scale": 0.2}, 24)],
)
def test_effects_are_named_with_their_sizes_beside_disturbances(effects, seed):
    found = searched(recorded(seed, push=1.0, **effects), suspects).best
    assert set(found.keys) == set(effects)
    for suspect in found.suspects:
        (place,) = found.sizes_of(suspect)
        width = suspect.slots[0].width
        deviation = float(np.sqrt(found.fitted.covariance[place, place])) * width
        assert abs(found.fitted.x[place] * width - effects[suspect.effect]) < 4.0 * deviation + 0.02


def test_parameters_come_out_within_their_deviations():
    system = recorded(31, push=0.5)
    noise = whitener(system, np.zeros(2))
    found = fit(system, noise, np.zeros(2))
    truth = np.array([0.03 * 30.0 / 1.5, -0.04 * 1.5 / 0.075])
    deviations = np.sqrt(np.diag(found.covariance))
    assert np.all(np.abs(found.x - truth) < 4.0 * deviations)


def test_a_budget_adds_up_and_gives_the_gap_to_what_makes_it():
    system = recorded(21, push=0.5, cubic=1.0)
    best = searched(system, suspects).best
    budget = budget_of(best, system.predicted(np.zeros(2)), np.zeros(system.known.size))
    total = sum(share.value for share in budget.shares.values()) + budget.unexplained.value
    assert total == pytest.approx(1.0)
    assert set(budget.shares) == {PARAMETERS, "cubic"}
    assert budget.shares["cubic"].value > 0.2
    assert abs(budget.unexplained.value) < 0.1


def test_a_run_is_predicted_by_a_fit_to_the_others():
    system = recorded(41, push=0.0)
    noise = whitener(system, np.zeros(2))
    found = fit(system, noise, np.zeros(2))
    assert set(folds_of(system)) == {0, 1, 2}
    out = left_out(found, noise, np.zeros(2, dtype=bool))
    assert out.unknowns.shape == (3, 2)
    assert np.std(system.measured - out.predicted) == pytest.approx(0.01, rel=0.1)
