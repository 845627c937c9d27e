"""What random pushes do to readings, against draws of them."""

from dataclasses import replace

import numpy as np
import pytest
from generated import campaign, noise_of

from gap_diagnosis.problem import Problem, deviations_of
from gap_diagnosis.waterfall import moved_by_pushes
from system_identification.noise import whitener


def drawn(noise, run, rng):
    """Return what one draw of the pushes does to the readings of a run, (M,)."""
    keep = np.exp(-run.dt / noise.levels.memory)
    size = np.array(noise.levels.pushes) * noise.units
    push, state, readings = size * rng.standard_normal(size.size), np.zeros(run.transition.shape[1]), []
    at = 0
    for k in range(run.transition.shape[0]):
        while at < run.places.size and run.places[at] <= k:
            readings.append(run.readings[at, : state.size] @ state)
            at += 1
        state = run.transition[k] @ state + run.push[k] @ push
        push = keep * push + np.sqrt(1.0 - keep**2) * size * rng.standard_normal(size.size)
    return np.array(readings)


def test_pushes_move_readings_as_far_as_draws_of_them_do():
    stated, recordings = campaign(seed=4, spread=0.0, duration=10.0, runs=1)
    problem = Problem(recordings=tuple(recordings), parameter_set=stated, deviations=deviations_of(stated))
    levels = replace(noise_of(problem).levels, pushes=(3.0, 1.5, 2.0), memory=0.8)
    noise = whitener(problem, problem.start(), levels)
    (run,) = noise.linear
    rng = np.random.default_rng(2)
    draws = np.array([drawn(noise, run, rng) for _ in range(200)])
    moved = moved_by_pushes(noise)
    assert set(moved) == {"speed", "ambient", "thrust", "torque"}
    for signal, found in moved.items():
        own = problem.known[run.rows] & (run.signals == list(problem.signal_names).index(signal))
        assert found == pytest.approx(np.sqrt(np.mean(draws[:, own] ** 2)), rel=0.1), signal


def test_nothing_moves_what_is_not_pushed():
    stated, recordings = campaign(seed=4, spread=0.0, duration=10.0, runs=1)
    problem = Problem(recordings=tuple(recordings), parameter_set=stated, deviations=deviations_of(stated))
    noise = whitener(problem, problem.start(), replace(noise_of(problem).levels, pushes=(0.0, 0.0, 0.0)))
    assert set(moved_by_pushes(noise).values()) == {0.0}
