"""Rotation vectors and REP 103's frames against SciPy's rotations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from thruster_model.equations.rep103 import (
    in_body_flu,
    in_map,
    pose_covariance_in_map,
    turned_attitude,
    velocity_covariance_in_body_flu,
)
from thruster_model.equations.rotation_vector import rotation, rotation_vector


def wxyz(turn: Rotation) -> np.ndarray:
    return np.roll(turn.as_quat(), 1)


@pytest.mark.parametrize("vector", [(0.0, 0.0, 0.0), (1e-12, 0.0, 2e-12), (0.3, -0.2, 0.9), (0.0, 3.1, 0.0)])
def test_a_rotation_vector_is_scipys_and_comes_back(vector: tuple[float, float, float]) -> None:
    q = rotation(vector)
    np.testing.assert_allclose(q, wxyz(Rotation.from_rotvec(vector)), atol=1e-15)
    np.testing.assert_allclose(rotation_vector(q), vector, atol=1e-14)
    np.testing.assert_allclose(rotation_vector(tuple(-x for x in q)), vector, atol=1e-14)


def test_no_turn_is_exactly_none() -> None:
    assert rotation((0.0, 0.0, 0.0)) == (1.0, 0.0, 0.0, 0.0)
    assert rotation_vector((1.0, 0.0, 0.0, 0.0)) == (0.0, 0.0, 0.0)


def test_level_and_heading_north_is_north_and_level_in_the_primary_frames_too() -> None:
    """North is +y of the map: a yaw of 90 degrees to the left of east."""
    np.testing.assert_allclose(turned_attitude((1.0, 0.0, 0.0, 0.0)), [np.sqrt(0.5), 0, 0, np.sqrt(0.5)], atol=1e-15)
    np.testing.assert_array_equal(in_map([1.0, 2.0, 3.0]), [2.0, 1.0, -3.0])
    np.testing.assert_array_equal(in_body_flu([1.0, 2, 3, 4, 5, 6]), [1, -2, -3, 4, -5, -6])


def test_a_point_of_the_body_is_at_the_same_place_in_both_pairs_of_frames() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        q, x = rng.standard_normal(4), rng.standard_normal(3)
        q /= np.linalg.norm(q)
        earth = Rotation.from_quat(np.roll(q, -1)).apply(x)
        flu = Rotation.from_quat(np.roll(turned_attitude(q), -1)).apply(x * [1, -1, -1])
        np.testing.assert_allclose(flu, in_map(earth), atol=1e-14)


def test_covariances_turn_with_their_vectors() -> None:
    draws = np.random.default_rng(1).standard_normal((50, 6)) @ np.random.default_rng(2).standard_normal((6, 6))
    P = draws.T @ draws
    turned = np.concatenate([np.apply_along_axis(in_map, 1, draws[:, i : i + 3]) for i in (0, 3)], axis=1)
    np.testing.assert_allclose(pose_covariance_in_map(P), turned.T @ turned, rtol=1e-12, atol=1e-12)
    moved = np.apply_along_axis(in_body_flu, 1, draws)
    np.testing.assert_allclose(velocity_covariance_in_body_flu(P), moved.T @ moved, rtol=1e-12, atol=1e-12)
