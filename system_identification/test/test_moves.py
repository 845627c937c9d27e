"""Moves that are kept by run are what their whole matrix does."""

import numpy as np
import pytest

from system_identification.moves import Moves, TakenOff

RUNS = [slice(0, 7), slice(7, 12)]


def _moves():
    rng = np.random.default_rng(0)
    mixed = rng.standard_normal((2, 3, 4)) * (rng.random((2, 3, 4)) < 0.6)
    return Moves(RUNS, rng.standard_normal((12, 3)), mixed)


def _whole(moves):
    return np.vstack([moves.columns[run] @ mixed for run, mixed in zip(moves.runs, moves.mixed, strict=True)])


def test_products_are_those_of_the_whole_matrix():
    moves, rows = _moves(), np.random.default_rng(1).standard_normal((12, 2))
    whole = _whole(moves)
    assert moves.gram == pytest.approx(whole.T @ whole)
    assert moves.onto(rows) == pytest.approx(whole.T @ rows)
    assert moves.along(np.array([1.0, -2.0, 0.5, 3.0])) == pytest.approx(whole @ [1.0, -2.0, 0.5, 3.0])


def test_what_is_taken_off_leaves_white_rows():
    moves = _moves()
    whole = _whole(moves)
    taken = TakenOff.of(moves)
    root = taken(np.eye(12))
    assert root @ (np.eye(12) + whole @ whole.T) @ root.T == pytest.approx(np.eye(12), abs=1e-9)
    assert taken.log_det == pytest.approx(np.linalg.slogdet(np.eye(12) + whole @ whole.T)[1])


def test_moves_of_no_size_are_left_out():
    scaled = _moves().scaled(np.array([1.0, 0.0, 2.0, 0.0]))
    assert scaled.mixed.shape == (2, 3, 2)
    assert _whole(scaled) == pytest.approx(_whole(_moves())[:, [0, 2]] * [1.0, 2.0])
