"""Random pushes of the rotor, drawn on the model linearised: even ones, some that grow with its speed, and bursts."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from generated import campaign
from scipy.signal import lfilter

from gap_diagnosis.bursts import bursts_of, evidence_for_bursts
from gap_diagnosis.problem import Problem, deviations_of
from gap_diagnosis.uneven_push import evidence_for_uneven_push
from system_identification.fitting import Fitted, fit
from system_identification.kalman import driven_by
from system_identification.levels import plain_levels
from system_identification.noise import Whitener, whitener

LEVEL = 3.0


@pytest.fixture(scope="module")
def fitted() -> tuple[Fitted, Whitener]:
    stated, recordings = campaign(seed=4, spread=0.0, duration=30.0, runs=2)
    problem = Problem(recordings=tuple(recordings), parameter_set=stated, deviations=deviations_of(stated))
    noise = whitener(problem, problem.start(), plain_levels(problem, 3, 0.1))
    return fit(problem, noise, problem.start(), iterations=0), noise


def driven(fitted: Fitted, noise: Whitener, walk: Callable[[int, np.ndarray], np.ndarray]) -> np.ndarray:
    """Return what a push of the rotor does to the rows, (R,); walk: of a run, by its number and its speeds (N,), in
    root mean squares of these.
    """
    problem = fitted.problem
    moved = np.zeros(problem.known.size)
    for k, (run, happened, recording) in enumerate(
        zip(noise.linear, problem.happened(fitted.x), problem.recordings, strict=True)
    ):
        count, _, q = run.push.shape
        n = happened.outputs["speed"]
        at = np.interp(run.dt * np.arange(count), recording.experiment.dt * np.arange(n.size), n)
        walks = np.zeros((q, count))
        walks[0] = noise.units[0] * walk(k, at / np.sqrt(np.mean(at**2)))
        states = np.zeros((count, run.transition.shape[1], q))
        driven_by(run.transition, run.push, walks, states)
        there = states.sum(axis=2)[np.minimum(run.places, count - 1)]
        moved[run.rows] = np.einsum("km,km->k", run.readings[:, : run.transition.shape[1]], there)
    return moved


def pushed(
    fitted: Fitted, noise: Whitener, *, level: float, seed: int, by_speed: bool = False, burst: float = 1.0
) -> Fitted:
    """Return a fit that leaves noise and what a push of the rotor makes of readings, in place of its own residuals.

    `burst`: times that level, for two seconds of each run.
    """
    rng, problem = np.random.default_rng(seed), fitted.problem
    left = rng.standard_normal(problem.known.size)
    for each in problem.series:
        left[each.rows] *= noise.levels.sensors[each.signal]

    def walk(k: int, speeds: np.ndarray) -> np.ndarray:
        keep = np.exp(-noise.linear[k].dt / noise.levels.memory)
        drawn = lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], rng.standard_normal(speeds.size))
        when = noise.linear[k].dt * np.arange(speeds.size)
        drawn *= np.where((when > 5.0) & (when < 7.0), burst, 1.0)
        return np.asarray(level * drawn * (np.abs(speeds) if by_speed else 1.0))

    return replace(fitted, residuals=left + driven(fitted, noise, walk))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_push_that_grows_with_speed_is_told_from_one_that_does_not(
    fitted: tuple[Fitted, Whitener], seed: int
) -> None:
    uneven = pushed(*fitted, by_speed=True, level=LEVEL, seed=seed)
    even = pushed(*fitted, level=LEVEL, seed=seed)
    learned = replace(fitted[1], levels=replace(fitted[1].levels, pushes=(2.0, 0.1, 0.1)))
    none = np.zeros(even.residuals.size)
    assert evidence_for_uneven_push(uneven, learned, none) > 20.0
    assert evidence_for_uneven_push(even, learned, none) < 0.0


def test_a_coefficient_that_is_another_in_each_run_is_no_push(fitted: tuple[Fitted, Whitener]) -> None:
    even = pushed(*fitted, level=LEVEL, seed=1)
    loose = driven(*fitted, lambda k, speeds: 3.0 * LEVEL * (1.0, -1.0)[k] * speeds)
    other = replace(even, residuals=even.residuals + loose)
    learned = replace(fitted[1], levels=replace(fitted[1].levels, pushes=(2.0, 0.1, 0.1)))
    assert evidence_for_uneven_push(other, learned, np.zeros(loose.size)) > 20.0
    assert evidence_for_uneven_push(other, learned, loose) < 0.0


def test_a_push_that_hardly_moves_the_rotor_is_none(fitted: tuple[Fitted, Whitener]) -> None:
    small = pushed(*fitted, by_speed=True, level=0.3, seed=1)
    assert evidence_for_uneven_push(small, fitted[1], np.zeros(small.residuals.size)) == -np.inf


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_bursts_are_told_from_a_push_that_is_as_hard_at_any_time(fitted: tuple[Fitted, Whitener], seed: int) -> None:
    even = pushed(*fitted, level=LEVEL, seed=seed)
    learned = replace(fitted[1], levels=replace(fitted[1].levels, pushes=(LEVEL, 0.1, 0.1)))
    none = np.zeros(even.residuals.size)
    assert bursts_of(even, learned, none)["speed"] < 3.0
    assert bursts_of(pushed(*fitted, level=LEVEL, burst=5.0, seed=seed), learned, none)["speed"] > 20.0


def test_bursts_that_move_the_rotor_by_less_than_its_reading_scatters_are_none(
    fitted: tuple[Fitted, Whitener],
) -> None:
    small = pushed(*fitted, level=0.02, burst=5.0, seed=1)
    learned = replace(fitted[1], levels=replace(fitted[1].levels, pushes=(0.02, 0.02, 0.02)))
    assert bursts_of(small, learned, np.zeros(small.residuals.size))["speed"] == -np.inf


@pytest.mark.parametrize(("share", "told"), [(0.0, False), (0.1, True), (0.5, True)])
def test_variances_of_two_kinds_of_windows_are_told_from_one(share: float, told: bool) -> None:
    rng = np.random.default_rng(7)
    levels, count = np.geomspace(1 / 16, 16, 9), 100
    deviation = np.where(np.arange(count) < share * count, 4.0, 1.0)
    squares = np.sum((deviation[:, None] * rng.standard_normal((count, 20))) ** 2, axis=1)
    evidence, highest = evidence_for_bursts(-0.5 * squares[:, None] / levels**2 - 20 * np.log(levels))
    assert evidence > 20.0 if told else evidence < 1.0
    assert levels[highest] == pytest.approx(4.0 if told else 1.0)
