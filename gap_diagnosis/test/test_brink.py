"""Water that rests in an idle propeller beside a flow: nothing foretells when it leaves, and it tells of no effect."""

from dataclasses import replace

import numpy as np
import pytest

from gap_diagnosis import linear
from gap_diagnosis.preparing import recording_of
from gap_diagnosis.problem import Problem, deviations_of
from system_identification.levels import plain_levels
from system_identification.noise import whitener
from thruster_model.parameter_set_io import load_parameter_set

HL = load_parameter_set("hl")
DT = 0.04
TIME: np.ndarray = DT * np.arange(400)
IDLE = (TIME > 11.6) & (TIME < 13.4)
THROTTLE = np.select([TIME < 1.0, TIME < 10.0, TIME < 10.7], [0.0, 4.5, -4.5], 0.0)
NOISE = {"speed": 0.5, "axial": 0.003, "ambient": 0.01}


def problem_of(axial: np.ndarray | None = None) -> Problem:
    """Return a thruster that drives water forward, brakes it, and idles in what still flows; `axial` [m/s] as read."""
    rng = np.random.default_rng(4)

    def of(read: dict[str, np.ndarray]) -> Problem:
        recording = recording_of("idle", (TIME, THROTTLE), {name: (TIME, y) for name, y in read.items()})
        return Problem(recordings=(recording,), parameter_set=HL, deviations=deviations_of(HL))

    noise = {name: deviation * rng.standard_normal(TIME.size) for name, deviation in NOISE.items()}
    blank = of(noise)
    truth = blank.predicted(blank.start())
    read = {each.signal: truth[each.first : each.last] for each in blank.series}
    if axial is not None:
        read["axial"] = np.where(IDLE, axial, read["axial"])
    return of({name: read[name] + noise[name] for name in NOISE})


def rows_of(problem: Problem, signal: str) -> slice:
    return next(slice(each.first, each.last) for each in problem.series if each.signal == signal)


@pytest.fixture(scope="module")
def resting() -> Problem:
    return problem_of()


def test_water_rests_in_an_idle_propeller_though_it_flows_outside(resting: Problem) -> None:
    read = resting.predicted(resting.start())
    assert np.all(np.abs(read[rows_of(resting, "axial")][IDLE]) < 2e-3)
    assert np.all(read[rows_of(resting, "ambient")][IDLE] > 0.02)


def test_only_where_it_rests_there_is_something_that_nothing_foretells(resting: Problem) -> None:
    (run,) = resting.linear(resting.start())
    at = run.dt * np.arange(run.unforeseen.shape[0])
    shocks = run.unforeseen[:, 1] / run.dt
    assert np.all(shocks[(at > 11.6) & (at < 13.4)] > 1e-5)
    assert np.all(shocks[(at > 2.0) & (at < 9.9)] < 1e-6) and np.all(run.unforeseen[:, [0, 2]] == 0.0)


def test_water_that_has_left_is_not_much_less_likely_than_water_that_has_not(
    resting: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    ambient = resting.predicted(resting.start())[rows_of(resting, "ambient")]
    on = HL.values["k_w"] * ambient - HL.values["k_v"] / HL.values["k_Uv"]  # where (4.4) rests too
    left = problem_of(on)

    def dearer() -> float:
        costs = []
        for problem in (resting, left):
            calm = replace(plain_levels(problem, 3, 0.5), pushes=(0.5, 0.0, 0.5))  # no turbulence at the propeller
            noise = whitener(problem, problem.start(), calm)
            white = noise.whiten(problem.residuals(problem.start()))
            costs.append(float(white @ white) + noise.log_det)
        return costs[1] - costs[0]

    foretold = float(np.sum((on[IDLE] / NOISE["axial"]) ** 2))
    assert dearer() < 0.15 * foretold
    monkeypatch.setattr(linear, "_brink", lambda rate, v, step: np.zeros_like(v))
    assert dearer() > 0.5 * foretold > 300.0
