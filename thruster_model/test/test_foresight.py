"""What recordings would determine, said before a fit: as much as a fit then does, and nothing that is not excited."""

import numpy as np
import pytest

from thruster_model.errors import UnfitDataError
from thruster_model.identification.fit import fit
from thruster_model.identification.foresight import foreseen
from thruster_model.parameter_set_io import load_parameter_set

SIMPLIFIED = load_parameter_set("simplified")
ODD = {"k_n": 13.66, "k_Q": 1856.0, "c_u1": 725.5, "c_u2": 737.2, "delta_u1": -0.83, "delta_u2": 0.86, "c_n_T": 9.5e-4,
       "c_nv_T": 0.0, "c_n_Q": 4e-6, "c_nv_Q": 0.0, "k_v": 1.0, "k_Uv": 60.0, "k_w": 1.0, "k_Tv": 0.0, "k_U": 0.2,
       "k_UU": 1.2, "k_TU": 0.0}  # fmt: skip


def status(found):
    return {each.name: each.status for each in found}


def forward(t):
    return 0.0 if t < 1.0 else 1.8 + 0.9 * np.sin(1.5 * t) + 0.4 * np.sin(5.1 * t)


def both(t):
    return 2.6 * np.sin(1.5 * t) + 0.4 * np.sin(5.1 * t)


def test_a_direction_that_was_not_driven_is_not_excited(independent_bench):
    recorded = independent_bench("one", forward, 16.0, ODD, np.random.default_rng(1), ("speed", "thrust", "torque"))
    found = status(foreseen(SIMPLIFIED, [recorded]))
    assert {found[name] for name in ("c_u1", "delta_u1", "c_T1", "c_Q1")} == {"not excited"}
    assert found["c_T2"] != "not excited"
    assert "u_dot_max" not in found, "it is given, not fitted"


def test_without_torque_nothing_is_said_of_it(independent_bench):
    recorded = independent_bench("one", both, 16.0, ODD, np.random.default_rng(1), ("speed", "thrust"))
    found = status(foreseen(SIMPLIFIED, [recorded]))
    assert found["c_T1"] == "determined"
    assert found["c_Q1"] in ("flat", "traded off", "not excited")


def test_deviations_foreseen_are_those_that_a_fit_of_a_right_model_finds(independent_bench):
    start = load_parameter_set("first_order")
    values = {"g_1": 51.0, "g_2": 52.0, "delta_u1": -0.83, "delta_u2": 0.86, "rate": 13.66, "c_T": 1e-3, "c_Q": 4e-6}
    start = start.with_values(values, source="truth")
    slopes = {"c_u1": 51.0 * 13.66, "c_u2": 52.0 * 13.66, "k_Q": 0.0, "c_n_T": 1e-3}
    recorded = independent_bench(
        "one", both, 16.0, {**ODD, **slopes}, np.random.default_rng(1), ("speed", "thrust", "torque")
    )
    ahead = {
        each.name: float(each.sentence.split("±")[1].split()[0].rstrip(",:")) for each in foreseen(start, [recorded])
    }
    fitted = fit(start, [recorded]).parameter_set.parameters
    for name in ("g_1", "g_2", "delta_u1", "rate", "c_T", "c_Q"):
        after = fitted[name].standard_deviation
        assert 0.5 < ahead[name] / after < 2.0, (name, ahead[name], after)


def test_what_a_fit_refuses_is_refused(independent_bench):
    still = independent_bench("still", lambda t: 0.0, 6.0, ODD, np.random.default_rng(1), ("speed",))
    with pytest.raises(UnfitDataError, match="nothing is excited"):
        foreseen(SIMPLIFIED, [still])
