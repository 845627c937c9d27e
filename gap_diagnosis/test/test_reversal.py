"""A loss of thrust against the flow ends as the thrust says, where random pushes decide when the flow turns."""

from dataclasses import replace

import numpy as np
import pytest
from generated import campaign, noise_of

from gap_diagnosis.problem import Problem, deviations_of
from gap_diagnosis.reversal import REVERSAL, turns_beside
from gap_diagnosis.suspects import slots_of
from system_identification.fitting import fit
from system_identification.hypothesis import Hypothesis
from system_identification.loose import Loose
from thruster_model.effects.effect import AGAINST, WITH
from thruster_model.effects.library.flow_reversal_loss import loads
from thruster_model.effects.stages import effect_values

SHARE = 0.5
(SLOT,) = slots_of(REVERSAL)


@pytest.fixture(scope="module")
def healthy():
    """Return a problem with recordings of what its own model does, 30 s of each."""
    stated, recordings = campaign(seed=5, spread=0.0, duration=30.0, runs=3)
    return Problem(recordings=tuple(recordings), parameter_set=stated, deviations=deviations_of(stated))


def turned_late(problem, seed):
    """Return gates under which each loss ends at random up to 0.3 s before or after the simulated flow has turned."""
    rng, gates = np.random.default_rng(seed), []
    for recording, happened in zip(problem.recordings, problem.happened(problem.start()), strict=True):
        n, v = (happened.outputs[name][: recording.experiment.throttle.size] for name in ("speed", "axial"))
        against = n * v < 0.0
        begins, ends = (np.flatnonzero(np.diff(np.concatenate(([0], against, [0]))) == sign) for sign in (1, -1))
        turns = np.flatnonzero(np.diff(np.sign(n)) != 0.0) + 1
        gate = np.full(n.size, WITH)
        for begin, end in zip(begins, ends, strict=True):
            last = min((turn for turn in turns if turn > begin), default=n.size)
            moved = end + round(rng.uniform(-0.3, 0.3) / recording.experiment.dt)
            gate[begin : min(max(moved, begin), last)] = AGAINST
        gates.append(gate)
    return tuple(gates)


def recorded(problem, gates, share=SHARE, seed=1):
    """Return the problem with readings of a plant that loses a share of its thrust while gates say so."""
    posed = problem.with_effects((SLOT,), gates)
    noise = noise_of(problem).deviations * np.random.default_rng(seed).standard_normal(problem.known.size)
    true = posed.predicted(posed.start([share / SLOT.width]))
    return replace(problem, observed=np.where(problem.known, true + noise, np.nan))


def beside(problem):
    noise = noise_of(problem)
    fitted = fit(problem, noise, problem.start())
    return Hypothesis(suspects=(), fitted=fitted, noise=noise, loose=Loose({}, np.zeros(problem.known.size)))


@pytest.mark.parametrize("seed", [2, 3])
def test_ends_that_pushes_have_moved_are_read_from_the_thrust(healthy, seed):
    true = turned_late(healthy, seed)
    problem = recorded(healthy, true, seed=seed)
    found = turns_beside(beside(problem))
    assert found.grid[0, 0] * SLOT.width == pytest.approx(SHARE, abs=0.03)
    assert found.price > 10.0
    thrust = [happened.outputs["thrust"] for happened in problem.happened(problem.start())]
    for read, gate, force in zip(found.gates, true, thrust, strict=True):
        strong = np.abs(force[: gate.size]) > 2.0
        assert np.mean(read[strong] == gate[strong]) > 0.97


def test_a_flow_that_turns_as_simulated_needs_no_ends_of_its_own(healthy):
    assert turns_beside(beside(recorded(healthy, ()))) is None


def test_a_healthy_thruster_loses_nothing(healthy):
    assert turns_beside(beside(healthy)) is None


def test_without_a_load_cell_nothing_tells(healthy):
    bare = [
        replace(
            each, experiment=replace(each.experiment, measurements={"speed": each.experiment.measurements["speed"]})
        )
        for each in healthy.recordings
    ]
    assert turns_beside(beside(replace(healthy, recordings=tuple(bare)))) is None


def test_where_ends_are_known_nothing_jumps_as_the_flow_turns(healthy):
    posed = healthy.with_effects((SLOT,), turned_late(healthy, 1))
    assert not posed.jumps
    assert posed.with_effects(()).gates == ()
    assert healthy.with_effects((SLOT,)).jumps


@pytest.mark.parametrize(("gate", "left"), [(1.0, (0.5, 1.0)), (WITH, (1.0, 1.0)), (AGAINST, (0.5, 0.5))])
def test_a_gate_that_tells_the_way_stands_over_the_flow(gate, left):
    e = effect_values({REVERSAL: {"share": 0.5}})
    for v, share in zip((-0.1, 0.1), left, strict=True):
        assert loads((4.0, 0.1), 50.0, v, 0.0, gate, None, e) == (4.0 * share, 0.1)
