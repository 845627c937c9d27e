"""A mass on a spring is fitted and diagnosed: what is hidden is named with its size, and nothing else is."""

import numpy as np
import pytest
from spring import SLOTS, recorded, suspects

from system_identification.budget import PARAMETERS, budget_of
from system_identification.earning import earned
from system_identification.fitting import fit
from system_identification.left_out import fit_to_free_runs, folds_of, left_out
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


def test_a_search_that_is_in_vain_ends_with_what_it_has():
    system = recorded(23, push=1.0, friction=0.8, scale=0.2)
    asked = []

    def in_vain(before, found):
        asked.append((before.keys, found.keys))
        return True

    found = searched(system, suspects, in_vain=in_vain)
    (added,) = found.best.keys
    assert asked == [((), (added,))]
    assert set(found.weighed) >= {frozenset(), frozenset((added,))}
    assert max(map(len, found.weighed)) == 1


def test_parameters_come_out_within_their_deviations():
    system = recorded(31, push=0.5)
    noise = whitener(system, np.zeros(2))
    found = fit(system, noise, np.zeros(2))
    truth = np.array([0.03 * 30.0 / 1.5, -0.04 * 1.5 / 0.075])
    deviations = np.sqrt(np.diag(found.covariance))
    assert np.all(np.abs(found.x - truth) < 4.0 * deviations)


def test_a_budget_gives_each_cause_its_shapley_value():
    system = recorded(123, push=0.5, cubic=1.0)
    search = searched(system, suspects)
    budget = budget_of([(search.best, 1.0)], np.zeros(system.known.size))
    assert sum(share.value for share in budget.shares.values()) + budget.unexplained.value == pytest.approx(1.0)
    assert set(budget.shares) == {PARAMETERS, "cubic"}
    assert budget.unexplained.value == pytest.approx(0.0)
    # The same from what was hidden: each cause first, and each cause last.
    posed, parameters = system.with_effects((SLOTS["cubic"],)), np.array([0.03 * 30.0 / 1.5, -0.04 * 1.5 / 0.075])
    size = 1.0 / SLOTS["cubic"].width

    def off(x, cubic):
        return (posed.predicted(np.array([*x, cubic])) - posed.predicted(np.zeros(3)))[system.known]

    gap = off(parameters, size)
    removed = [
        (gap @ gap - np.sum((gap - alone) ** 2) + np.sum((gap - other) ** 2)) / (2.0 * gap @ gap)
        for alone, other in (
            (off(parameters, 0.0), off((0.0, 0.0), size)),
            (off((0.0, 0.0), size), off(parameters, 0.0)),
        )
    ]
    for name, true in zip((PARAMETERS, "cubic"), removed, strict=True):
        assert budget.shares[name].value == pytest.approx(true, abs=0.06)
        assert budget.shares[name].low < true < budget.shares[name].high


def test_other_sets_about_as_likely_widen_the_intervals():
    system = recorded(21, push=0.5, cubic=1.0)
    search = searched(system, suspects)
    nothing = np.zeros(system.known.size)
    alone, beside = (
        budget_of(sets, nothing) for sets in ([(search.best, 1.0)], [(search.best, 0.6), (search.none, 0.4)])
    )
    assert alone.shares["cubic"].low > 0.1
    assert beside.shares["cubic"].low < 0.0
    assert beside.shares["cubic"].value == alone.shares["cubic"].value


def test_a_run_is_predicted_by_a_fit_to_the_others():
    system = recorded(41, push=0.0)
    noise = whitener(system, np.zeros(2))
    found = fit(system, noise, np.zeros(2))
    assert set(folds_of(system)) == {0, 1, 2}
    out = left_out(found, noise)
    assert out.unknowns.shape == (3, 2)
    assert np.std(system.measured - out.predicted) == pytest.approx(0.01, rel=0.1)


@pytest.mark.parametrize(("stiffness", "damping", "seed"), [(1.3, 0.7, 71), (0.75, 1.3, 72)])
def test_parameters_that_are_farther_off_than_stated_are_no_effect(stiffness, damping, seed):
    found = searched(recorded(seed, push=0.5, stiffness=stiffness, damping=damping), suspects)
    assert found.best.keys == ()
    assert found.best.noise.levels.parameters > 2.0
    values = [30.0 + 1.5 * found.best.fitted.x[0], 1.5 + 0.075 * found.best.fitted.x[1]]
    assert values == pytest.approx([30.0 * stiffness, 1.5 * damping], rel=0.02)


def test_parameters_as_stated_scatter_no_more_widely():
    found = searched(recorded(73, push=0.5, friction=0.8), suspects).best
    assert found.keys == ("friction",)
    assert found.noise.levels.parameters == 1.0


@pytest.mark.parametrize("seed", [81, 82, 83])
def test_a_wrong_model_is_fitted_to_free_runs_by_what_lasts(seed):
    system = recorded(seed, push=0.5, cubic=1.2)
    found = searched(system, lambda _: ()).best  # what is at work has no name here
    free, noise = fit_to_free_runs(found.fitted, found.noise)

    def squares(x):
        return float(np.sum(system.residuals(x) ** 2))

    best = min(squares(free.x + np.array([a, b])) for a in (-0.3, 0.0, 0.3) for b in (-0.3, 0.0, 0.3))
    assert squares(free.x) == pytest.approx(best, rel=0.02)
    assert squares(free.x) < 0.98 * squares(found.fitted.x)
    assert noise.levels.sensors["position"] == pytest.approx(np.sqrt(squares(free.x) / system.known.size), rel=0.1)


@pytest.mark.parametrize("seed", [91, 92])
def test_what_has_a_name_earns_its_place_beside_what_has_none(seed):
    system = recorded(seed, push=0.5, runs=4, friction=1.6, cubic=1.0)

    def offered(_):
        return [each for each in suspects() if each.effect != "cubic"]

    none = searched(system, lambda _: ()).none
    chain = earned(none, offered)
    assert chain[0].found.keys == () and chain[0].helps is None
    assert "friction" in chain[-1].found.keys
    (named,) = (each for each in chain if each.found.keys[-1:] == ("friction",))
    assert named.helps > 0.9 and 0.0 <= named.chosen <= 1.0
    left = [np.std(system.measured - each.out.predicted) for each in chain]
    assert left[-1] < left[0]


@pytest.mark.parametrize("seed", [93, 94])
def test_nothing_earns_a_place_beside_a_model_that_is_right(seed):
    none = searched(recorded(seed, push=1.0, runs=4), lambda _: ()).none
    assert len(earned(none, suspects)) == 1
