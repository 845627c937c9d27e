"""Attitude: values by hand, the printed matrices, scipy's rotations and finite differences; kernels as in Python."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from thruster_model.compilation import compiled
from thruster_model.equations import attitude as a

turns = st.floats(-np.pi, np.pi)
tilts = st.floats(-1.5, 1.5)
vectors = st.tuples(*(st.floats(-10, 10) for _ in range(3)))
ANGLES = (0.4, -0.9, 2.5)
RATES = (0.3, -0.2, 0.7)


def printed_j_1(phi, theta, psi):
    """(2.4) as the thesis prints it."""
    c, s = np.cos, np.sin
    return np.array(
        [
            [
                c(psi) * c(theta),
                -s(psi) * c(phi) + c(psi) * s(theta) * s(phi),
                s(psi) * s(phi) + c(psi) * c(phi) * s(theta),
            ],
            [
                s(psi) * c(theta),
                c(psi) * c(phi) + s(phi) * s(theta) * s(psi),
                -c(psi) * s(phi) + s(theta) * s(psi) * c(phi),
            ],
            [-s(theta), c(theta) * s(phi), c(theta) * c(phi)],
        ]
    )


def test_a_bow_turned_up_by_ninety_degrees_points_up() -> None:
    q = a.quaternion_from_euler((0.0, np.pi / 2, 0.0))
    np.testing.assert_allclose(a.rotated(q, (1.0, 0.0, 0.0)), (0.0, 0.0, -1.0), atol=1e-15)
    np.testing.assert_allclose(q, (np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0))


@given(turns, tilts, turns, vectors)
def test_a_vector_turns_as_by_the_printed_matrix_and_by_scipy(phi, theta, psi, x) -> None:
    q = a.quaternion_from_euler((phi, theta, psi))
    np.testing.assert_allclose(a.rotated(q, x), printed_j_1(phi, theta, psi) @ x, atol=1e-13)
    w, *xyz = q
    np.testing.assert_allclose(a.rotated(q, x), Rotation.from_quat([*xyz, w]).apply(x), atol=1e-13)
    np.testing.assert_allclose(a.rotated_back(q, a.rotated(q, x)), x, atol=1e-13)


@given(turns, tilts, turns)
def test_angles_come_back_from_their_quaternion(phi, theta, psi) -> None:
    back = a.euler_from_quaternion(a.quaternion_from_euler((phi, theta, psi)))
    np.testing.assert_allclose(a.wrapped(np.array(back) - (phi, theta, psi)), 0.0, atol=1e-12)


@pytest.mark.parametrize("theta", [np.pi / 2, -np.pi / 2])
@pytest.mark.parametrize("psi", [0.0, 1.0, -3.0])
@pytest.mark.parametrize("phi", [0.0, 0.3])
def test_angles_of_a_vertical_body_describe_the_same_attitude(phi, theta, psi) -> None:
    q = a.quaternion_from_euler((phi, theta, psi))
    found = a.euler_from_quaternion(q)
    assert found[0] == 0.0
    np.testing.assert_allclose(printed_j_1(*found), printed_j_1(phi, theta, psi), atol=2e-8)


@given(turns, tilts, turns, turns, tilts, turns, vectors)
def test_a_product_is_one_turn_after_the_other(phi, theta, psi, phi_2, theta_2, psi_2, x) -> None:
    first, second = a.quaternion_from_euler((phi, theta, psi)), a.quaternion_from_euler((phi_2, theta_2, psi_2))
    np.testing.assert_allclose(
        a.rotated(a.quaternion_product(first, second), x), a.rotated(first, a.rotated(second, x)), atol=1e-12
    )
    identity = a.quaternion_product(first, a.conjugate(first))
    np.testing.assert_allclose(identity, (1.0, 0.0, 0.0, 0.0), atol=1e-14)


def test_a_body_that_turns_steadily_follows_scipys_rotation_vector() -> None:
    q, dt = np.array(a.quaternion_from_euler(ANGLES)), 1e-6
    w, *xyz = q
    later = (Rotation.from_quat([*xyz, w]) * Rotation.from_rotvec(np.array(RATES) * dt)).as_quat()
    expected = (np.array([later[3], *later[:3]]) - q) / dt
    np.testing.assert_allclose(a.quaternion_rate(q, RATES), expected, atol=1e-6)


def test_rates_of_the_angles_are_those_of_the_quaternion() -> None:
    q, dt = np.array(a.quaternion_from_euler(ANGLES)), 1e-6
    ahead = a.euler_from_quaternion(q + dt * np.array(a.quaternion_rate(q, RATES)))
    behind = a.euler_from_quaternion(q - dt * np.array(a.quaternion_rate(q, RATES)))
    expected = (np.array(ahead) - behind) / (2 * dt)
    np.testing.assert_allclose(a.matrix_times(a.euler_rate_matrix(ANGLES), RATES), expected, atol=1e-9)


@given(turns, tilts, turns)
def test_the_inverse_of_the_rate_matrix_is_its_inverse(phi, theta, psi) -> None:
    found = np.array(a.euler_rate_matrix((phi, theta, psi))) @ np.array(a.euler_rate_matrix_inverse((phi, theta, psi)))
    np.testing.assert_allclose(found, np.eye(3), atol=1e-12)


def test_the_derivative_of_the_rate_matrix_is_its_slope() -> None:
    angles, rates, dt = np.array(ANGLES), np.array(RATES), 1e-6
    ahead, behind = a.euler_rate_matrix(angles + dt * rates), a.euler_rate_matrix(angles - dt * rates)
    expected = (np.array(ahead) - behind) / (2 * dt)
    np.testing.assert_allclose(a.euler_rate_matrix_derivative(ANGLES, RATES), expected, atol=1e-8)


@pytest.mark.parametrize(("angle", "expected"), [(0.5, 0.5), (np.pi, -np.pi), (-np.pi, -np.pi), (6.0, 6 - 2 * np.pi)])
def test_angles_are_wrapped_to_half_a_turn_on_either_side(angle, expected) -> None:
    assert a.wrapped(angle) == pytest.approx(expected, abs=1e-15)


@compiled
def in_a_kernel(angles, rates):
    q = a.normalised(a.quaternion_from_euler(angles))
    back = a.euler_from_quaternion(a.quaternion_product(q, a.conjugate(q)))
    turned = a.rotated_back(q, a.rotated(q, rates))
    j, j_inverse = a.euler_rate_matrix(angles), a.euler_rate_matrix_inverse(angles)
    euler = a.matrix_times(j_inverse, a.matrix_times(j, rates))
    slope = a.matrix_times(a.euler_rate_matrix_derivative(angles, rates), rates)
    return q, back, turned, euler, slope, a.quaternion_rate(q, rates), a.wrapped(angles[2])


def test_kernels_give_what_python_gives_and_batches_what_scalars_give() -> None:
    for found, expected in zip(in_a_kernel(ANGLES, RATES), in_a_kernel.py_func(ANGLES, RATES), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-15)
    batch = np.array([ANGLES, RATES, (0.0, np.pi / 2, 1.0)]).T
    many = np.array(a.euler_from_quaternion(a.quaternion_from_euler(tuple(batch))))
    for column, angles in zip(many.T, batch.T, strict=True):
        np.testing.assert_array_equal(column, a.euler_from_quaternion(a.quaternion_from_euler(tuple(angles))))
