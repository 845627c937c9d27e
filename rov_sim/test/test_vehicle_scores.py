"""Scores of a vehicle's run: by hand, without what is unknown, by the thesis' normalisation."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rov_sim.vehicle.poses import at_instants, attitudes_at, body_rates, euler_angles, rotated, upright
from rov_sim.vehicle.scores import DEGREES_OF_FREEDOM, flow_score, score, vehicle_scores


def quaternion(rotation: Rotation) -> np.ndarray:
    return np.roll(rotation.as_quat(), 1, axis=-1)


def test_the_error_is_the_root_mean_square_over_the_mean_absolute_set_point() -> None:
    found = score([1.5, -1.0, 2.0, np.nan], [1.0, -1.0, 2.5, 9.0])
    assert found.rmse == pytest.approx(np.sqrt(0.5 / 3))
    assert found.set_point == pytest.approx(1.5) and found.normalised == pytest.approx(found.rmse / 1.5)
    assert (found.largest, found.samples) == (0.5, 3)


def test_a_set_point_of_mean_zero_has_a_relative_error_and_one_that_is_zero_has_none() -> None:
    wanted = np.sin(np.linspace(0.0, 2.0 * np.pi, 1000, endpoint=False))
    assert score(wanted + 0.1, wanted).normalised == pytest.approx(0.1 * np.pi / 2.0, rel=1e-4)
    assert np.isnan(score([0.1, 0.1], [0.0, 1e-17]).normalised)


def test_errors_of_angles_are_wrapped() -> None:
    assert score([np.pi - 0.01], [-np.pi + 0.01], angle=True).rmse == pytest.approx(0.02)
    assert score([np.pi - 0.01], [-np.pi + 0.01]).rmse > 6.0


def test_nothing_known_gives_no_score_and_unequal_shapes_are_refused() -> None:
    assert score([np.nan], [1.0]).samples == 0 and np.isnan(score([], []).rmse)
    with pytest.raises(ValueError, match="of one shape"):
        score([1.0], [1.0, 2.0])


def test_each_degree_of_freedom_is_scored_on_its_own() -> None:
    rng = np.random.default_rng(1)
    eta = rng.uniform(-1.0, 1.0, (50, 3))
    rates, velocity = rng.normal(size=(50, 3)), rng.normal(size=(50, 3))
    off = 0.01 * np.arange(1, 10)
    nu = np.hstack([velocity, body_rates(eta, rates)]) + off[:6]
    found = vehicle_scores(eta, nu, eta - off[6:], rates, velocity)
    assert list(found) == [each.id for each in DEGREES_OF_FREEDOM]
    assert [one.rmse for one in found.values()] == pytest.approx(off)


def test_of_a_rate_that_comes_of_errors_of_attitude_alone_nothing_was_wanted() -> None:
    pitch = 0.5 * np.sin(np.linspace(0.0, 6.0, 60))
    wanted_angles, wanted_rates = np.zeros((60, 3)), np.zeros((60, 3))
    wanted_angles[:, 1], wanted_rates[:, 1] = pitch, np.gradient(pitch)
    eta = wanted_angles + np.array([0.01, 0.0, 0.0])  # a little roll turns a wanted pitch rate into one of yaw
    nu = np.hstack([np.zeros((60, 3)), body_rates(eta, wanted_rates) + 0.02])
    found = vehicle_scores(eta, nu, wanted_angles, wanted_rates, np.zeros((60, 3)))
    assert found["yaw_rate"].set_point > 0.0 and np.isnan(found["yaw_rate"].normalised)
    assert found["yaw_rate"].rmse == pytest.approx(0.02)
    assert found["pitch_rate"].normalised == pytest.approx(0.02 / np.mean(np.abs(wanted_rates[:, 1])), rel=1e-3)


def test_the_flow_is_scored_over_all_thrusters_at_once() -> None:
    v = np.array([[0.2, -0.4], [0.2, -0.4]])
    found = flow_score(v + np.array([0.03, 0.0]), v)
    assert found.normalised == pytest.approx(0.03 / np.sqrt(2.0) / 0.3)


def test_attitudes_are_those_of_scipy() -> None:
    many = Rotation.random(50, rng=np.random.default_rng(2))
    angles = many.as_euler("ZYX")[:, ::-1]
    assert euler_angles(quaternion(many)) == pytest.approx(angles)
    axis = np.array([0.3, -0.2, 0.9])
    assert rotated(quaternion(many), np.broadcast_to(axis, (50, 3))) == pytest.approx(many.apply(axis))


def test_body_rates_turn_the_attitude_as_the_angles_say() -> None:
    angles, rates, step = np.array([0.4, -0.9, 2.0]), np.array([0.3, -0.2, 0.5]), 1e-6
    before, after = (Rotation.from_euler("ZYX", (angles + k * rates)[::-1]) for k in (-step, step))
    turned = (before.inv() * after).as_rotvec() / (2.0 * step)
    assert body_rates(angles, rates) == pytest.approx(turned, abs=1e-7)


def test_values_are_taken_at_their_own_instants_on_lines_between_and_nowhere_else() -> None:
    found = at_instants([-1.0, 0.0, 0.5, 2.0, 2.1], [0.0, 1.0, 2.0], [[0.0, 3.0], [1.0, 4.0], [5.0, 6.0]])
    assert found[1:4].tolist() == [[0.0, 3.0], [0.5, 3.5], [5.0, 6.0]]
    assert np.isnan(found[[0, 4]]).all()


def test_attitudes_between_samples_do_not_jump_where_the_quaternion_changes_its_sign() -> None:
    turns = Rotation.from_euler("z", np.array([[0.0], [0.2], [0.4]]))
    q = quaternion(turns) * np.array([[1.0], [-1.0], [1.0]])
    found = euler_angles(attitudes_at([0.5, 1.5], [0.0, 1.0, 2.0], q))
    assert found[:, 2] == pytest.approx([0.1, 0.3], abs=1e-4)


def test_a_level_vehicle_to_the_north_is_upright_for_viewers_that_hold_z_for_up() -> None:
    position, q = upright([1.0, 2.0, 3.0], [1.0, 0.0, 0.0, 0.0])
    assert position.tolist() == [2.0, 1.0, -3.0]
    forward, left, up = (rotated(q, axis) for axis in np.eye(3))
    assert forward == pytest.approx([0.0, 1.0, 0.0])  # north
    assert left == pytest.approx([-1.0, 0.0, 0.0])  # west
    assert up == pytest.approx([0.0, 0.0, 1.0])


def test_a_vector_is_the_same_arrow_in_both_kinds_of_frames() -> None:
    q = quaternion(Rotation.random(20, rng=np.random.default_rng(4)))
    _, turned = upright(np.zeros((20, 3)), q)
    frd = np.array([0.5, -0.3, 0.8])
    north, east, down = rotated(q, np.broadcast_to(frd, (20, 3))).T
    flu = np.broadcast_to(frd * [1.0, -1.0, -1.0], (20, 3))
    assert rotated(turned, flu) == pytest.approx(np.stack([east, north, -down], axis=1))
