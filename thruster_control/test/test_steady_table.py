"""Lookup tables from parameter sets, and what is refused."""

import pytest
from scipy.optimize import brentq

from thruster_control.errors import SteadyStatesError
from thruster_control.inner_loop import AT_REST, inner_loop_step
from thruster_control.settings import Limits, TableLaw, checked
from thruster_control.steady_table import lookup_of_set
from thruster_model.equations.thruster import input_map, rotor_acceleration, thrust, torque
from thruster_model.parameter_set_io import load_parameter_set


def test_a_dead_zone_beyond_the_largest_throttle_is_refused() -> None:
    with pytest.raises(SteadyStatesError, match=r"expected a dead zone within 0.5 V; found -0\.\d+ to 0\.\d+ V"):
        lookup_of_set(load_parameter_set("hl").coefficients, u_max=0.5)


def test_a_parameter_set_s_table_is_its_own_steady_state() -> None:
    """Against the root of (3.8), which the table does not solve but simulate."""
    p = load_parameter_set("simplified").coefficients
    found = checked(TableLaw(lookup_of_set(p))).table
    assert found[0, [0, -1]].tolist() == [-3.0, 3.0]
    assert sorted(found[0, found[1] == 0.0]) == [p.delta_u1, p.delta_u2]
    for u, force, n in found.T:
        if n != 0.0:
            root = brentq(
                lambda x, u=u: float(rotor_acceleration(x, torque(x, 0.0, p), input_map(u, p), p)), -200.0, 200.0
            )
            assert (n, force) == pytest.approx((root, float(thrust(root, 0.0, p))), rel=1e-6, abs=1e-9)


def test_over_thrust_or_over_speed_the_simplified_set_gives_the_same_throttle() -> None:
    p = load_parameter_set("simplified").coefficients
    lookup, free = lookup_of_set(p), Limits(u_dot_max=1e9)
    for T_d in (-12.0, -3.0, -0.5, 0.5, 3.0, 12.0):
        by = [
            inner_loop_step(AT_REST, T_d, 0.0, 0.0, 0.0, False, 1.0, TableLaw(lookup, free, by_thrust=each), p)[1].u
            for each in (0, 1)
        ]
        assert by[0] == pytest.approx(by[1], abs=0.035)
