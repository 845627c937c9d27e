"""Equations of a body in water: the printed matrices, point masses, another origin, energy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thruster_model.equations.attitude import normalised, quaternion_from_euler, quaternion_rate, rotated, rotated_back
from thruster_model.equations.hydrodynamics import current_in_body, drag, restoring
from thruster_model.equations.rigid_body import coriolis, coriolis_matrix, moved_mass, rigid_body_mass, skew

R_G = np.array([0.1, -0.05, 0.2])
I_G = np.array([[0.9, -0.1, 0.05], [-0.1, 0.8, 0.02], [0.05, 0.02, 1.4]])
MASS = 12.0
NU = np.array([0.4, -0.2, 0.1, 0.5, -0.3, 0.7])
velocities = st.lists(st.floats(-2, 2), min_size=6, max_size=6).map(np.array)


def printed_c_rb(nu):
    """(2.12) with the inertia about the origin, as a matrix."""
    I_O = I_G - MASS * skew(R_G) @ skew(R_G)
    turn = skew(nu[3:])
    return np.block([[MASS * turn, -MASS * turn @ skew(R_G)], [MASS * skew(R_G) @ turn, -skew(I_O @ nu[3:])]])


def test_mass_and_inertia_are_those_of_point_masses() -> None:
    rng = np.random.default_rng(1)
    masses, places = rng.uniform(0.5, 2.0, 7), rng.normal(size=(7, 3))
    r_G = masses @ places / masses.sum()
    about_centre = -sum(m * skew(r - r_G) @ skew(r - r_G) for m, r in zip(masses, places, strict=True))
    M = rigid_body_mass(masses.sum(), r_G, about_centre)
    speeds = NU[:3] + np.cross(NU[3:], places)
    energy = 0.5 * masses @ np.sum(speeds**2, axis=1)
    assert pytest.approx(energy, rel=1e-13) == 0.5 * NU @ M @ NU
    momentum = masses @ speeds
    np.testing.assert_allclose((M @ NU)[:3], momentum, rtol=1e-12)
    np.testing.assert_allclose((M @ NU)[3:], masses @ np.cross(places, speeds), rtol=1e-12)


def test_a_moved_centre_of_mass_keeps_the_inertia_about_it() -> None:
    M = moved_mass(rigid_body_mass(MASS, R_G, I_G), R_G, (0.0, 0.3, -0.1))
    np.testing.assert_allclose(M, rigid_body_mass(MASS, (0.0, 0.3, -0.1), I_G), atol=1e-14)


@given(velocities)
def test_the_form_of_the_momentum_is_that_of_the_printed_matrix(nu) -> None:
    M = rigid_body_mass(MASS, R_G, I_G)
    np.testing.assert_allclose(coriolis_matrix(M, nu) @ nu, printed_c_rb(nu) @ nu, atol=1e-12)
    a, b = np.split(M @ nu, 2)
    found = np.concatenate(coriolis(tuple(a), tuple(b), tuple(nu[:3]), tuple(nu[3:])))
    np.testing.assert_allclose(found, printed_c_rb(nu) @ nu, atol=1e-12)


def test_turning_costs_no_power() -> None:
    M = rigid_body_mass(MASS, R_G, I_G) + np.diag([5.0, 7.0, 20.0, 0.2, 0.1, 0.3])
    assert NU @ coriolis_matrix(M, NU) @ NU == pytest.approx(0.0, abs=1e-14)


def test_a_steady_current_may_enter_the_rigid_bodys_part_as_it_enters_the_waters() -> None:
    """M_RB dnu/dt + C_RB(nu) nu is M_RB dnu_r/dt + C_RB(nu_r) nu_r with dnu_c/dt = -nu_2 x nu_c."""
    M, nu_c = rigid_body_mass(MASS, R_G, I_G), np.array([0.4, -0.1, 0.2, 0.0, 0.0, 0.0])
    rate = np.array([0.1, 0.2, -0.3, 0.2, 0.4, 0.1])
    nu_c_rate = np.concatenate((-np.cross(NU[3:], nu_c[:3]), np.zeros(3)))
    absolute = M @ rate + coriolis_matrix(M, NU) @ NU
    relative = M @ (rate - nu_c_rate) + coriolis_matrix(M, NU - nu_c) @ (NU - nu_c)
    np.testing.assert_allclose(relative, absolute, atol=1e-12)


def test_the_current_seen_by_the_body_changes_as_the_body_turns() -> None:
    q, v_c, dt = quaternion_from_euler((0.3, -0.5, 1.0)), (0.4, 0.1, -0.2), 1e-6
    seen = np.array(current_in_body(q, v_c))
    later = normalised(tuple(np.add(q, dt * np.array(quaternion_rate(q, tuple(NU[3:]))))))
    slope = (np.array(current_in_body(later, v_c)) - seen) / dt
    np.testing.assert_allclose(slope, -np.cross(NU[3:], seen), atol=1e-6)


def test_drag_by_hand() -> None:
    found = drag(np.diag([1.0, 2, 3, 4, 5, 6]), np.diag([10.0, 0, 0, 0, 0, 1]), [0.5, -1, 0, 0, 0, -2])
    np.testing.assert_allclose(found, [0.5 + 2.5, -2.0, 0.0, 0.0, 0.0, -12.0 - 4.0])
    coupled = np.zeros((6, 6))
    coupled[1, 5] = 2.0
    np.testing.assert_allclose(drag(np.zeros((6, 6)), coupled, [0, 0, 0, 0, 0, -3.0]), [0, -18.0, 0, 0, 0, 0])


@given(st.floats(-3, 3), st.floats(-1.5, 1.5), st.floats(-3, 3))
def test_weight_and_buoyancy_are_two_forces_at_two_points(phi, theta, psi) -> None:
    q = quaternion_from_euler((phi, theta, psi))
    W, B, r_B = 120.0, 130.0, np.array([0.01, 0.02, -0.1])
    f_G, f_B = rotated_back(q, (0.0, 0.0, W)), rotated_back(q, (0.0, 0.0, -B))
    force, moment = restoring(q, W, B, tuple(R_G), tuple(r_B))
    np.testing.assert_allclose(force, -np.add(f_G, f_B), atol=1e-11)
    np.testing.assert_allclose(moment, -(np.cross(R_G, f_G) + np.cross(r_B, f_B)), atol=1e-11)
    np.testing.assert_allclose(rotated(q, force), (0.0, 0.0, B - W), atol=1e-11)


def test_a_body_heavier_below_rights_itself() -> None:
    _, moment = restoring(quaternion_from_euler((0.2, 0.0, 0.0)), 100.0, 100.0, (0.0, 0.0, 0.0), (0.0, 0.0, -0.05))
    assert moment[0] == pytest.approx(100.0 * 0.05 * np.sin(0.2))  # g stands on the left: positive turns back
