"""Water that rests in an idle propeller beside a flow: nothing foretells when it leaves, and it tells of no effect."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from gap_diagnosis import linear
from gap_diagnosis.preparing import recording_of
from gap_diagnosis.problem import Problem, deviations_of
from system_identification.levels import plain_levels
from system_identification.noise import whitener
from thruster_model.equations.thruster import axial_acceleration
from thruster_model.parameter_set_io import load_parameter_set

HL = load_parameter_set("hl")
DT = 0.04
TIME: np.ndarray = DT * np.arange(400)
IDLE = (TIME > 11.7) & (TIME < 15.9)
THROTTLE = np.select([TIME < 1.0, TIME < 10.0, TIME < 10.7], [0.0, 4.5, -4.5], 0.0)
NOISE = {"speed": 0.5, "axial": 0.003, "ambient": 0.01}


def problem_of(axial: np.ndarray | None = None, read: Sequence[str] = tuple(NOISE)) -> Problem:
    """Return a thruster that drives water forward, brakes it, and idles in what still flows; `axial` [m/s] as it is
    there, with what is `read`.
    """
    rng = np.random.default_rng(4)

    def of(read: dict[str, np.ndarray]) -> Problem:
        recording = recording_of("idle", (TIME, THROTTLE), {name: (TIME, y) for name, y in read.items()})
        return Problem(recordings=(recording,), parameter_set=HL, deviations=deviations_of(HL))

    noise = {name: deviation * rng.standard_normal(TIME.size) for name, deviation in NOISE.items()}
    blank = of(noise)
    truth = blank.predicted(blank.start())
    told = {each.signal: truth[each.first : each.last] for each in blank.series}
    if axial is not None:
        told["axial"] = np.where(IDLE, axial, told["axial"])
    return of({name: told[name] + noise[name] for name in read})


def rows_of(problem: Problem, signal: str) -> slice:
    return next(slice(each.first, each.last) for each in problem.series if each.signal == signal)


@pytest.fixture(scope="module")
def resting() -> Problem:
    return problem_of()


def test_water_rests_in_an_idle_propeller_though_it_flows_outside(resting: Problem) -> None:
    read = resting.predicted(resting.start())
    assert np.all(np.abs(read[rows_of(resting, "axial")][IDLE]) < 2e-3)
    assert np.all(read[rows_of(resting, "ambient")][(TIME > 11.6) & (TIME < 13.4)] > 0.02)


def shocks(problem: Problem, *, again: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return times, and what nothing foretells there of the axial flow; again: as the filter is linearised anew."""
    (run,) = problem.linear(problem.start())
    if again:
        (run,) = problem.linear(problem.start(), [np.zeros_like(run.transition[:, 0])])
    assert np.all(run.unforeseen[:, [0, 2]] == 0.0)
    return run.dt * np.arange(run.unforeseen.shape[0]), run.unforeseen[:, 1] / run.dt


def test_only_where_it_rests_there_is_something_that_nothing_foretells(resting: Problem) -> None:
    at, found = shocks(resting, again=False)
    assert np.all(found[(at > 11.6) & (at < 13.4)] > 1e-5)
    assert np.all(found[(at > 2.0) & (at < 9.9)] < 1e-6)


def test_where_nothing_reads_it_it_may_leave_at_any_moment() -> None:
    at, found = shocks(problem_of(read=("speed", "ambient")), again=True)
    assert np.all(found[(at > 12.4) & (at < 13.4)] > 1e-5)
    assert np.all(found[(at > 2.0) & (at < 9.9)] < 1e-6)


def test_where_a_sensor_reads_it_only_its_coming_to_rest_is_not_foretold(resting: Problem) -> None:
    at, found = shocks(resting, again=True)
    assert np.flatnonzero(found > 1e-6).size == 1 and 11.5 < at[np.argmax(found)] < 12.0


def leaving() -> Problem:
    """Return a thruster whose water came to rest at 5 mm/s, and leaves by (4.4)."""
    resting = problem_of()
    ambient = resting.predicted(resting.start())[rows_of(resting, "ambient")]
    p, axial, v = HL.model.coefficients(HL.values), np.zeros(TIME.size), 5e-3
    for k in np.flatnonzero(IDLE):
        axial[k] = v
        for _ in range(10):
            v += 0.1 * DT * axial_acceleration(v, ambient[k], 0.0, p)
    return problem_of(axial)


def evidence(problem: Problem) -> float:
    """Return twice the negative logarithm of the readings' density, without turbulence at the propeller."""
    calm = replace(plain_levels(problem, 3, 0.5), pushes=(0.5, 0.0, 0.5))
    noise = whitener(problem, problem.start(), calm)
    white = noise.whiten(problem.residuals(problem.start()))
    return float(white @ white) + noise.log_det


def test_water_may_rest_or_leave_where_a_sensor_reads_it(resting: Problem, monkeypatch: pytest.MonkeyPatch) -> None:
    rests, leaves = evidence(resting), evidence(leaving())
    monkeypatch.setattr(linear, "_brink", lambda rate, v, step: (np.zeros_like(v), np.zeros_like(v)))
    assert rests < evidence(resting) + 15.0
    assert leaves - rests < 50.0 < 250.0 < evidence(leaving()) - evidence(resting)
