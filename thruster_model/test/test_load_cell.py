"""The load cell's geometry and calibration: by hand, by virtual work, by two optimisers, on data that cannot tell."""

import numpy as np
import pytest

from thruster_model.errors import UnfitDataError
from thruster_model.load_cell.calibration import LoadData, calibrate, wrench
from thruster_model.load_cell.geometry import Hexapod, HexapodError, leg_lines
from thruster_model.load_cell.population_search import searched


def platform(radius=0.1, height=0.2, twist=0.4):
    around = np.repeat(2 * np.pi * np.arange(3) / 3, 2)
    base = np.stack(
        [radius * np.cos(around + [0.1, -0.1] * 3), radius * np.sin(around + [0.1, -0.1] * 3), 0 * around], 1
    )
    turned = around + np.tile([twist, -twist], 3) + np.pi / 3 * np.tile([1, -1], 3)
    top = np.stack([radius * np.cos(turned), radius * np.sin(turned), np.full(6, height)], 1)
    return base, top


def box():
    """Three pairs of legs along x, y, z at unit offsets: H by hand."""
    base = np.array([[0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1], [1, 0, 0], [-1, 0, 0]], float)
    return Hexapod(base=base, platform=base + np.repeat(np.eye(3), 2, axis=0) * 2.0)


def test_the_matrix_of_a_box_is_the_one_computed_by_hand():
    by_hand = [
        [1, 1, 0, 0, 0, 0],
        [0, 0, 1, 1, 0, 0],
        [0, 0, 0, 0, 1, 1],
        [0, 0, -1, 1, 0, 0],
        [0, 0, 0, 0, -1, 1],
        [-1, 1, 0, 0, 0, 0],
    ]
    np.testing.assert_allclose(box().matrix, by_hand, atol=1e-15)


def test_the_wrench_is_the_sum_of_the_legs_forces_and_moments_at_either_end():
    base, top = platform()
    legs = np.random.default_rng(1).normal(size=(4, 6))
    found = Hexapod(base=base, platform=top).wrench(legs)
    for f, w in zip(legs, found, strict=True):
        force, moment = np.zeros(3), np.zeros(3)
        for i in range(6):
            s = (top[i] - base[i]) / np.linalg.norm(top[i] - base[i])
            force += f[i] * s
            moment += np.cross(top[i], f[i] * s)  # the force acts along the leg: either end will do
        np.testing.assert_allclose(w, [*force, *moment], atol=1e-14)


def test_the_matrix_is_the_transpose_of_how_legs_lengthen_when_the_plate_moves():
    base, top = platform()
    H, step = Hexapod(base=base, platform=top).matrix, 1e-7
    rates = np.empty((6, 6))
    for k in range(6):
        shift, turn = np.eye(6)[k, :3], np.eye(6)[k, 3:]
        moved = [top + sign * step * (shift + np.cross(turn, top)) for sign in (1, -1)]
        lengths = [np.linalg.norm(m - base, axis=1) for m in moved]
        rates[:, k] = (lengths[0] - lengths[1]) / (2 * step)
    np.testing.assert_allclose(H.T, rates, atol=1e-7)


@pytest.mark.parametrize(
    ("base", "top", "text"),
    [
        (platform()[0], platform()[0] + [0, 0, 0.2], "condition number of H is inf"),
        (platform()[0], np.tile([0.0, 0.0, 0.3], (6, 1)), "hardly feel"),
        (platform()[0], np.vstack([platform()[0][:1], platform()[1][1:]]), "leg 1: both ends are at"),
        (platform()[0][:5], platform()[1], r"base: expected 6 points .* found shape \(5, 3\)"),
        (np.full((6, 3), np.nan), platform()[1], "base: expected finite"),
    ],
)
def test_a_geometry_that_measures_no_wrench_is_refused_with_the_reason(base, top, text):
    with pytest.raises(HexapodError, match=text):
        Hexapod(base=base, platform=top)


def test_the_condition_does_not_depend_on_the_unit_of_length():
    base, top = platform()
    assert Hexapod(base=base, platform=top).condition == pytest.approx(
        Hexapod(base=1e3 * base, platform=1e3 * top).condition
    )


def test_columns_of_a_matrix_are_read_back_as_legs():
    base, top = platform()
    cell = Hexapod(base=base, platform=top)
    directions, gain, foot = leg_lines(cell.matrix * 1.04)
    np.testing.assert_allclose(directions, cell.directions, atol=1e-12)
    np.testing.assert_allclose(gain, 1.04)
    np.testing.assert_allclose(np.cross(foot - base, directions), 0.0, atol=1e-12)


def loads(seed=1, count=60, noise=0.05):
    rng = np.random.default_rng(seed)
    base, top = platform()
    H = Hexapod(base=base, platform=top).matrix
    H_A = H + 0.03 * rng.normal(size=(6, 6))
    legs = 10 * rng.normal(size=(count, 6))
    return H, H_A, legs, legs @ H_A.T + noise * rng.normal(size=(count, 6))


def test_least_squares_finds_the_matrix_within_its_stated_deviations():
    scores = []
    for seed in range(30):
        _, H_A, legs, W = loads(seed)
        found = calibrate(LoadData.of(legs, W))
        assert found.complete and not found.missing
        scores.append((found.matrix - H_A) / found.deviation)
    assert np.std(scores) == pytest.approx(1.0, abs=0.06)


@pytest.mark.parametrize("known", [True, False])
def test_a_search_by_a_population_agrees_with_least_squares_and_is_that_of_its_seed(known):
    H, _, legs, W = loads()
    data, nominal, bound = LoadData.of(legs, W), H if known else None, 0.3 if known else 2.0
    found = searched(data, nominal, bound=bound)
    np.testing.assert_allclose(found, calibrate(data).matrix, atol=1e-9)
    np.testing.assert_array_equal(searched(data, nominal, bound=bound), found)


def test_pooled_data_give_what_all_loads_at_once_give():
    _, _, legs, W = loads()
    parts = [LoadData.of(legs[:20], W[:20]), LoadData.of(legs[20:], W[20:])]
    once, pooled = calibrate(LoadData.of(legs, W)), calibrate(LoadData.pooled(parts))
    np.testing.assert_allclose(pooled.matrix, once.matrix, atol=1e-12)
    np.testing.assert_allclose(pooled.deviation, once.deviation, rtol=1e-9)
    direct = np.sqrt(np.mean((W - wrench(once.matrix, legs)) ** 2, axis=0))
    np.testing.assert_allclose(pooled.residual, direct, rtol=1e-9)


def test_loads_that_leave_a_leg_out_say_so_and_leave_its_column_as_it_was():
    H, H_A, legs, _ = loads()
    legs[:, 3] = 0.0
    found = calibrate(LoadData.of(legs, legs @ H_A.T), H)
    assert found.rank == 5 and not found.complete
    assert "f_4" in found.missing[0] and "not determined" in found.missing[0]
    np.testing.assert_allclose(found.matrix[:, 3], H[:, 3], atol=1e-12)
    assert np.all(np.isinf(found.deviation[:, 3])) and np.all(np.isfinite(found.deviation[:, [0, 1, 2, 4, 5]]))


def test_two_legs_that_only_ever_moved_together_are_not_told_apart():
    _, H_A, legs, _ = loads()
    legs[:, 1] = legs[:, 0]
    found = calibrate(LoadData.of(legs, legs @ H_A.T))
    assert "f_1" in found.missing[0] and "f_2" in found.missing[0]
    assert np.all(np.isinf(found.deviation[:, :2])) and np.all(np.isfinite(found.deviation[:, 2:]))


def test_fewer_loads_than_legs_are_no_calibration():
    _, H_A, legs, _ = loads(count=4)
    found = calibrate(LoadData.of(legs, legs @ H_A.T))
    assert found.rank == 4 and len(found.missing) == 2 and np.all(np.isinf(found.deviation))


@pytest.mark.parametrize(
    ("legs", "W", "text"),
    [
        (np.ones((3, 5)), np.ones((3, 6)), r"expected legs and wrenches \(N, 6\); found \(3, 5\)"),
        (np.full((3, 6), np.nan), np.ones((3, 6)), "at least one load"),
    ],
)
def test_loads_of_the_wrong_kind_are_refused(legs, W, text):
    with pytest.raises(UnfitDataError, match=text):
        LoadData.of(legs, W)
