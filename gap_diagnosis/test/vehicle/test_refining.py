"""Fits of nuisances and effects together, on innovations whose answer is known without a vehicle."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap_diagnosis.vehicle.descent import _corrected, normal
from gap_diagnosis.vehicle.hypotheses import Hypothesis
from gap_diagnosis.vehicle.refining import Problem, Refined
from gap_diagnosis.vehicle.verdict import Claim, _claim

RNG = np.random.default_rng(3)
BASIS, NOISE = RNG.normal(size=(4000, 1)), RNG.normal(size=(4000, 1))
LOSS = Hypothesis(
    effect="thrust_loss", thruster=0, parameters=("share",), scale=(0.3,), probe=(0.05,), lower=(-0.3,), upper=(1.0,)
)
THRUST = ("own", "thrust", 0)


class Bilinear:
    """In place of a `Screen`: thrust (1 + own) (1 - loss) against what a loss of 0.4 left, in 20ths of the noise."""

    runs = (SimpleNamespace(log=SimpleNamespace(period=0.04)),)

    def residual(self, k: int) -> Any:
        return NOISE

    def at(self, k: int, values: Any, effects: Any, *, coarse: bool = False) -> Any:
        left = 1.0 + values[THRUST]
        for effect in effects:
            left *= 1.0 - effect.sizes["share"]
        return NOISE + 20.0 * (0.6 - left) * BASIS


def problem() -> Problem:
    return Problem(screen=Bilinear(), nuisances={THRUST: 0.02}, effects=(LOSS,))  # type: ignore[arg-type]


def test_a_nuisance_gives_back_what_it_took_over_before_the_effect_was_there() -> None:
    fit = problem().fit(np.array([-20.0]), [(0.0,)])
    # by hand: of 0.4 lost, with deviations of 0.6 * 0.02 and 0.3, all but 1 part in 600 is the effect's
    assert fit.effects[0].sizes[0] == pytest.approx(0.4, abs=2e-3)
    assert abs(fit.moved[0]) < 0.2
    assert fit.effects[0].deviations[0] == pytest.approx(0.6 * 0.02, rel=0.05)


def test_the_evidence_is_that_of_where_the_fit_ends_wherever_it_began() -> None:
    ends = [problem().fit(np.array([m]), [(s,)]).log_evidence for m, s in ((-20.0, 0.0), (0.0, 0.4), (5.0, 0.8))]
    assert max(ends) - min(ends) < 0.05


def test_where_whole_steps_lead_away_damped_ones_lead_home() -> None:
    class Bent(Bilinear):
        def at(self, k: int, values: Any, effects: Any, *, coarse: bool = False) -> Any:
            return NOISE + 20.0 * np.arctan(values[THRUST] / 0.02) * BASIS

    one = Problem(screen=Bent(), nuisances={THRUST: 0.02}, effects=())  # type: ignore[arg-type]
    assert abs(one.most_likely(np.array([4.0]), [])[0][0]) < 0.01


def test_a_size_does_not_leave_its_range() -> None:
    narrow = Hypothesis(
        effect="thrust_loss",
        thruster=0,
        parameters=("share",),
        scale=(0.3,),
        probe=(0.05,),
        lower=(0.0,),
        upper=(0.25,),
    )
    one = Problem(screen=Bilinear(), nuisances={THRUST: 0.02}, effects=(narrow,))  # type: ignore[arg-type]
    assert one.fit(np.zeros(1), [(0.1,)]).effects[0].sizes[0] <= 0.25


def test_scores_of_a_true_effect_scatter_by_chance_once_it_is_on() -> None:
    assert problem().fit(np.zeros(1), [(0.3,)]).scatter < 1.6


def test_a_limit_that_is_never_reached_stays_where_it_was_tried() -> None:
    limit = Hypothesis(
        effect="throttle_saturation", thruster=0, parameters=("limit",), scale=(1.0,), probe=(2.0,), lower=(0.5,),
        upper=(5.0,), grid=(4.0, 2.0),
    )  # fmt: skip

    class Unreached(Bilinear):
        def at(self, k: int, values: Any, effects: Any, *, coarse: bool = False) -> Any:
            return super().at(k, values, ())

    one = Problem(screen=Unreached(), nuisances={THRUST: 0.02}, effects=(limit,))  # type: ignore[arg-type]
    assert one.fit(np.zeros(1), [(4.0,)]).effects[0].sizes == (4.0,)


def test_where_a_fit_ends_is_the_same_without_how_sure_it_is() -> None:
    fit = problem().fit(np.array([-20.0]), [(0.0,)])
    moved, sizes, _ = problem().most_likely(np.array([-20.0]), [(0.0,)])
    assert np.array_equal(moved, fit.moved)
    assert sizes == [fit.effects[0].sizes]


def test_a_fit_that_begins_where_the_last_one_ended_makes_no_columns_again(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = problem()
    moved, sizes, _ = asked.most_likely(np.array([-20.0]), [(0.0,)])
    first = asked.fit(moved, sizes, exact=True)
    monkeypatch.setattr(Bilinear, "at", None)
    again = asked.fit(moved, sizes, exact=True)
    assert again.log_evidence == first.log_evidence


def test_columns_from_nearby_that_lead_nowhere_are_made_anew() -> None:
    one = problem()
    away = [-10.0 * each for each in one.columns(np.array([-20.0]), [(0.0,)])]
    moved, sizes, _ = one.most_likely(np.array([-20.0]), [(0.0,)], away)
    expected = problem().most_likely(np.array([-20.0]), [(0.0,)])
    assert sizes[0][0] == pytest.approx(expected[1][0][0], abs=1e-4)
    assert moved == pytest.approx(expected[0], abs=1e-3)


def test_columns_from_nearby_that_lead_on_spare_new_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    one, start = problem(), (np.array([0.1]), [(0.38,)])
    nearby = list(one.columns(*start))
    monkeypatch.setattr(Problem, "made", None)
    assert one.most_likely(*start, nearby)[1][0][0] == pytest.approx(0.4, abs=2e-3)


def test_damped_steps_that_creep_towards_a_wall_end() -> None:
    asked = []

    class Walled(Bilinear):
        def at(self, k: int, values: Any, effects: Any, *, coarse: bool = False) -> Any:
            x = values[THRUST] / 0.02
            asked.append(x)
            return NOISE + 20.0 * (10.0 - x) * BASIS + (1e3 * np.roll(BASIS, 1) if x > 1.0 else 0.0)

    one = Problem(screen=Walled(), nuisances={THRUST: 0.02}, effects=())  # type: ignore[arg-type]
    assert 0.5 < one.most_likely(np.array([0.5]), [])[0][0] < 0.7
    assert len(asked) < 20


def test_what_a_sensor_is_off_is_all_the_effects_where_that_is_on() -> None:
    key = ("sensor", "imu_misalignment", None, "y")
    askew = Hypothesis(
        effect="imu_misalignment", axis="y", parameters=("angle",), scale=(0.1,), probe=(0.01,), lower=(-0.3,),
        upper=(0.3,),
    )  # fmt: skip
    beside = replace(askew, axis="z")
    for effects, left in (((), 2.0), ((beside,), 2.0), ((askew,), 0.0)):
        problem = Problem(screen=Bilinear(), nuisances={key: 0.0075}, effects=effects)  # type: ignore[arg-type]
        assert problem.held(np.array([2.0, *(0.5 for _ in effects)]))[0] == left


@pytest.mark.parametrize(("size", "pressed", "told"), [(0.8, 5.0, True), (0.8, 1.0, False), (1.0, 5.0, False)])
def test_a_size_beyond_its_range_is_said_to_be_there(size: float, pressed: float, told: bool) -> None:
    found = Refined(hypothesis=LOSS, sizes=(size,), deviations=(0.01,), pressed=pressed)
    words = Claim(refined=found, probability=0.996, group=1.0, rivals=()).words
    assert words.startswith(f"Loss of thrust at all speeds of thruster 0: share {size:.3g} ± 0.01 (p 1.00).")
    assert ("That share is the end of the range that is searched" in words) == told
    assert (_claim(found, 100.0, (), None).probability < 0.5) == told


@pytest.mark.parametrize(("most", "beyond"), [(0.25, True), (0.39, False), (0.45, False)])
def test_recordings_ask_for_a_size_beyond_its_range_by_so_many_deviations(most: float, beyond: bool) -> None:
    wide = problem().fit(np.zeros(1), [(0.1,)]).effects[0]
    one = Problem(screen=Bilinear(), nuisances={THRUST: 0.02}, effects=(replace(LOSS, upper=(most,)),))  # type: ignore[arg-type]
    found = one.fit(np.zeros(1), [(0.1,)]).effects[0]
    assert found.pressed == pytest.approx(max(wide.sizes[0] - most, 0.0) / found.deviations[0], rel=0.3)
    assert found.at_the_end == beyond


def test_columns_that_a_step_corrected_have_the_product_that_goes_with_them() -> None:
    rng = np.random.default_rng(7)
    J = [rng.normal(size=(rows, 5)).astype(np.float32) for rows in (30, 50)]
    r, x, weight = [rng.normal(size=len(each)) for each in J], rng.normal(size=5), np.ones(5)
    step, change = rng.normal(size=5), [rng.normal(size=len(each)) for each in J]
    corrected, product = _corrected(J, normal(J, r, x, weight)[0], step, change)
    assert np.concatenate([each @ step for each in corrected]) == pytest.approx(np.concatenate(change), abs=1e-5)
    np.testing.assert_allclose(product, normal(corrected, r, x, weight)[0], rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize(("left", "probability"), [(-3.0, 0.5), (98.0, 1.0)])
def test_what_explains_no_less_beside_an_effect_is_no_rival_of_it(left: float, probability: float) -> None:
    found = Refined(hypothesis=LOSS, sizes=(0.5,), deviations=(0.01,))
    key = ("nameless", "roll angle", "time")
    stages: Any = (SimpleNamespace(offered=((90.0, LOSS),), odds={key: 100.0}), SimpleNamespace(odds={key: left}))
    claim = _claim(found, 100.0, (), stages)
    assert claim.probability == pytest.approx(probability, abs=1e-3)
    assert bool(claim.nameless) == (probability < 1.0)
