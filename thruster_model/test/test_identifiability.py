"""What is said of a parameter that the data leave open: each status with its sentence, from given numbers."""

import numpy as np
import pytest

from thruster_model.identification.identifiability import determinations
from thruster_model.models import MODELS

HL = MODELS["hl"]
NAMES = ("k_n", "c_n_T", "c_nv_T")


def judge(names=NAMES, values=(13.66, 1.2e-3, 0.41), deviations=(0.1, 1e-5, 4e-3), **given):
    size = len(names)
    correlation = given.pop("correlation", np.eye(size))
    influence = np.asarray(given.pop("influence", [100.0] * size))
    prior = np.asarray(given.pop("prior", [13.66, 1.5e-3, 0.4][:size]))
    found = determinations(
        HL, names, np.asarray(values), np.asarray(deviations), correlation, influence, prior, **given
    )
    assert tuple(d.name for d in found) == tuple(names)
    return found


def tied(first, second, rho):
    matrix = np.eye(3)
    matrix[first, second] = matrix[second, first] = rho
    return matrix


def test_what_the_data_determine_is_stated_with_its_deviation_and_unit():
    first, second, _ = judge()
    assert (first.status, first.sentence) == ("determined", "13.66 ± 0.1 1/s")
    assert (second.status, second.sentence) == ("determined", "0.0012 ± 1e-05 N s^2")


def test_a_pure_number_is_stated_without_unit():
    (found,) = judge(names=("k_w",), values=(0.8,), deviations=(0.05,), prior=(1.0,))
    assert found.sentence == "0.8 ± 0.05"


def test_what_does_not_move_the_predictions_is_not_excited():
    found = judge(influence=[100.0, 0.9, 100.0])[1]
    assert found.status == "not excited"
    assert found.sentence == "the data do not respond to it; it stays at 0.0012 N s^2"
    assert judge(influence=[100.0, 1.1, 100.0])[1].status == "determined"


@pytest.mark.parametrize(("deviation", "status"), [(0.06, "at a bound"), (0.04, "determined")])
def test_what_lies_within_its_deviation_of_zero_is_at_its_bound(deviation, status):
    found = judge(values=(13.66, 1.2e-3, 0.05), deviations=(0.1, 1e-5, deviation))[2]
    assert found.status == status
    if status == "at a bound":
        assert found.sentence == "0.05 ± 0.06 N s^2/m: cannot be told from its bound, 0 N s^2/m"


def test_a_negative_parameter_has_its_bound_above():
    (found,) = judge(names=("delta_u1",), values=(-0.001,), deviations=(0.01,), prior=(0.9,))
    assert found.status == "at a bound"
    assert found.sentence.endswith("cannot be told from its bound, 0 V")


def test_a_value_on_the_bound_itself_is_at_it_however_sure():
    found = judge(values=(13.66, 1.2e-3, 0.0), deviations=(0.1, 1e-5, 0.0))[2]
    assert found.status == "at a bound"


@pytest.mark.parametrize(
    ("value", "deviation", "settled"),
    [(1e-9, 0.01, True), (3e-5, 0.01, True), (1e-9, 0.3, False), (0.05, 0.06, False), (0.05, 0.01, False)],
)
def test_what_lies_on_its_bound_is_settled_there_where_the_data_keep_it_near(value, deviation, settled):
    found = judge(values=(13.66, 1.2e-3, value), deviations=(0.1, 1e-5, deviation))[2]
    assert found.settled is settled


@pytest.mark.parametrize(("deviation", "status"), [(7.0, "flat"), (6.5, "determined")])
def test_a_deviation_above_half_the_priors_is_flat(deviation, status):
    found = judge(deviations=(deviation, 1e-5, 4e-3))[0]
    assert found.status == status
    if status == "flat":
        assert found.sentence == "13.66 ± 7 1/s: hardly narrower than before the fit (± 14 1/s)"


@pytest.mark.parametrize("rho", [0.97, -0.97])
def test_a_pair_that_moves_together_is_traded_off_and_names_its_partner(rho):
    first, second, third = judge(correlation=tied(1, 2, rho))
    assert first.status == "determined"
    assert (second.status, second.partners) == ("traded off", ("c_nv_T",))
    assert (third.status, third.partners) == ("traded off", ("c_n_T",))
    expected = f"0.0012 ± 1e-05 N s^2, but only together with c_nv_T (correlation {rho:+.3f} with c_nv_T)"
    assert second.sentence == expected
    assert judge(correlation=tied(1, 2, 0.9 * np.sign(rho)))[1].status == "determined"


def test_of_several_partners_the_strongest_is_quoted():
    correlation = tied(0, 1, 0.96) + tied(0, 2, -0.99) - np.eye(3)
    found = judge(correlation=correlation)[0]
    assert found.partners == ("c_n_T", "c_nv_T")
    assert found.sentence.endswith("together with c_n_T, c_nv_T (correlation -0.990 with c_nv_T)")


def test_the_graver_status_is_the_one_that_is_said():
    correlation = tied(1, 2, 0.99)
    assert judge(correlation=correlation, influence=[100.0, 0.5, 100.0])[1].status == "not excited"
    assert judge(correlation=correlation, values=(13.66, 0.0, 0.41))[1].status == "at a bound"
    assert judge(correlation=correlation, deviations=(0.1, 1e-3, 4e-3))[1].status == "flat"


def test_the_thresholds_are_arguments():
    assert judge(influence=[5.0] * 3, least_influence=10.0)[0].status == "not excited"
    assert judge(flat_share=1e-3)[0].status == "flat"
    assert judge(correlation=tied(0, 1, 0.6), strong_correlation=0.5)[0].status == "traded off"
