"""Whitening by a Kalman filter is the inverse of the covariance, and its levels are those of the recording."""

from dataclasses import replace

import numpy as np
import pytest
from spring import DT, Spring, recorded

from system_identification.learning import Caps, learned
from system_identification.levels import Levels
from system_identification.moves import Moves, TakenOff
from system_identification.noise import white_noise, whitener


def small(kind=Spring):
    readings = (np.array([0.01, -0.02, np.nan, 0.015, 0.0, 0.03]), np.array([0.02, 0.01, -0.01, 0.0]))
    return kind(forces=(np.zeros(12), np.zeros(8)), readings=readings)


class Between(Spring):
    """Each position read a third of the time to the next instant later: in part what pushes have done since."""

    def linear(self, x, apart=None):
        return [
            run._replace(
                readings=np.array(
                    [
                        np.concatenate((c + c @ (a - np.eye(2)) / 3.0, c @ g / 3.0))
                        for c, a, g in zip(run.readings, run.transition[run.places], run.push[run.places], strict=True)
                    ]
                )
            )
            for run in super().linear(x, apart)
        ]


class Shocked(Spring):
    """Its states move on by themselves at two instants, nobody knows which way."""

    def linear(self, x, apart=None):
        runs = super().linear(x, apart)
        for run in runs:
            run.unforeseen[[2, 5]] = (3e-4, 1e-3)
        return runs


KINDS = pytest.mark.parametrize("kind", [Spring, Between, Shocked])


def levels(push=2.0):
    return Levels(
        sensors={"position": 0.012}, colours={"position": 0.7}, colour_memory={"position": 0.8}, pushes=(push,),
        memory=1.1,
    )  # fmt: skip


def dense(system, found):
    """Return for each run what counts, its covariance and that of the states with it, built sample by sample from the
    state-space model itself.
    """
    blocks = []
    for run in system.linear(np.zeros(2)):
        count = run.transition.shape[0]
        keep = np.exp(-run.dt / found.memory)
        deviation = found.pushes[0] * whitener(system, np.zeros(2), found).units[0]
        shocks = np.zeros((count, count))  # what shock j does to the push at instant k
        for j in range(count):
            size = deviation if j == 0 else deviation * np.sqrt(1.0 - keep**2)
            shocks[j:, j] = size * keep ** np.arange(count - j)
        shocks = np.hstack((shocks, np.zeros((count, 2 * count))))
        state = np.zeros((count, 2, 3 * count))
        for k in range(count - 1):
            state[k + 1] = run.transition[k] @ state[k] + run.push[k] * shocks[k]
            state[k + 1, [0, 1], [count + 2 * k, count + 2 * k + 1]] += np.sqrt(run.unforeseen[k])
        rows = np.einsum("im,imj->ij", run.readings[:, :2], state[run.places])
        rows += run.readings[:, 2:].sum(axis=1)[:, None] * shocks[run.places]
        colour = found.colours["position"] * found.sensors["position"]
        apart = np.abs(np.subtract.outer(run.places, run.places)) * run.dt
        own = found.sensors["position"] ** 2 * np.eye(run.places.size)
        block = rows @ rows.T + colour**2 * np.exp(-apart / found.colour_memory["position"]) + own
        known = system.known[run.rows]
        blocks.append((run.rows[known], block[np.ix_(known, known)], np.einsum("kmj,ij->kmi", state, rows[known])))
    return blocks


@KINDS
def test_whitened_rows_have_the_length_that_the_covariance_gives_them(kind):
    system, found = small(kind), levels()
    noise = whitener(system, np.zeros(2), found)
    values, blocks = system.measured, dense(system, found)
    length = sum(values[rows] @ np.linalg.solve(block, values[rows]) for rows, block, _ in blocks)
    white = noise.whiten(np.nan_to_num(values))
    assert white @ white == pytest.approx(length, rel=1e-9)
    assert noise.log_det == pytest.approx(sum(np.linalg.slogdet(block)[1] for _, block, _ in blocks), rel=1e-9)


@KINDS
def test_states_are_followed_to_where_they_most_probably_were(kind):
    system, found = small(kind), levels()
    values = system.measured
    followed = whitener(system, np.zeros(2), found).followed(values)
    for states, (rows, block, with_rows) in zip(followed, dense(system, found), strict=True):
        assert np.max(np.abs(states)) > 0.01
        assert states == pytest.approx(with_rows @ np.linalg.solve(block, values[rows]), rel=1e-9, abs=1e-12)


def test_columns_pass_through_the_same_map_as_residuals():
    system = small()
    noise = whitener(system, np.zeros(2), levels())
    rows = np.random.default_rng(1).standard_normal((system.measured.size, 3))
    assert noise.whiten(rows) @ [1.0, -2.0, 0.5] == pytest.approx(noise.whiten(rows @ [1.0, -2.0, 0.5]))


def test_what_is_loose_adds_its_covariance():
    system = small()
    bare = whitener(system, np.zeros(2), levels())
    columns = np.random.default_rng(2).standard_normal((system.measured.size, 2)) * 0.05
    moves = Moves([slice(0, 6), slice(6, 10)], bare.filtered(columns), np.tile(np.eye(2), (2, 1, 1)))
    loose = replace(bare, loose=TakenOff.of(moves))
    values = np.nan_to_num(system.measured)
    plain, moved = bare.whiten(values), bare.whiten(columns)
    whole = np.eye(plain.size) + moved @ moved.T
    white = loose.whiten(values)
    assert white @ white == pytest.approx(plain @ np.linalg.solve(whole, plain), rel=1e-6)
    assert loose.log_det - bare.log_det == pytest.approx(np.linalg.slogdet(whole)[1], rel=1e-6)


@pytest.mark.parametrize("push", [0.5, 2.0])
def test_levels_are_those_of_the_recording(push):
    system = recorded(3, push=push, stiffness=1.0, damping=1.0)
    base = whitener(system, np.zeros(2))
    found = learned(base, system.residuals(np.zeros(2)), Caps(pushes=50.0), steps=15)
    assert found.levels.pushes[0] * found.units[0] == pytest.approx(push, rel=0.3)
    assert found.levels.sensors["position"] == pytest.approx(0.01, rel=0.05)
    white = found.whiten(system.residuals(np.zeros(2)))
    assert np.mean(white**2) == pytest.approx(1.0, abs=0.08)
    assert abs(np.mean(white[1:] * white[:-1])) < 0.08


@pytest.mark.parametrize("at", [0, 100])
def test_a_row_that_stands_out_counts_by_what_it_tells(at):
    system = recorded(4, push=0.0, stiffness=1.0, damping=1.0)
    residuals = system.residuals(np.zeros(2))
    residuals[at] += 1.0
    tame = white_noise(system).tamed(residuals)
    assert np.argmax(tame.wild) == at and np.sum(tame.wild > 1.0) <= 3
    assert abs(tame.whiten(residuals)[at]) == pytest.approx(4.0, rel=1e-6)


def test_the_run_is_sampled_as_the_system_says():
    run = small().linear(np.zeros(2))[0]
    assert run.dt == DT and run.places.tolist() == [0, 2, 4, 6, 8, 10]


def test_rows_that_stand_out_together_tell_of_the_system():
    system = recorded(5, push=0.0, stiffness=1.0, damping=1.0)
    residuals = system.residuals(np.zeros(2))
    residuals[100:120] += 1.0
    tame = white_noise(system).tamed(residuals)
    assert tame.wild is None or not np.any(tame.wild[103:117] > 1.0)
    assert np.all(np.abs(tame.whiten(residuals)[103:117]) > 90.0)
