"""One experiment: a strategy, a set point and a seed; what came of it as numbers.

The seed decides on the plant's factors and on all noise, in the same way for every strategy: strategies with one seed
meet the same thruster, the same noise, the same spikes.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rov_sim.bench_study.controllers import controller, reads_load_cell
from rov_sim.bench_study.plants import drawn_plant
from rov_sim.closed_loop import CALM, LoopRun, ProcessNoise, Timing, simulate_loop
from rov_sim.rig_sensors import Rig
from rov_sim.study.statistics import rms
from thruster_control.references import DURATION, REFERENCES
from thruster_control.scores import overshoot, settling_time, tracking_scores
from thruster_model.parameter_set import ParameterSet

__all__ = ["KINDS", "SCORES", "Conditions", "Experiment", "run_experiment", "score", "set_point"]

Array = NDArray[np.float64]

KINDS: Mapping[str, str] = {"step": "step", "triangle": "ramp", "sine": "sine"}
"""Names of the thesis' set points and what `references` calls them."""
SCORES = (
    "rmse", "rmse_true", "largest", "overshoot", "settling", "chatter", "n_hat", "v_hat", "U_hat", "v_spread", "speed",
)  # fmt: skip
"""rmse: tracking error as the load cell tells it [N]; rmse_true: of the true thrust [N]; largest: |error| of the true
thrust [N]; overshoot [1]: beyond the mean of the last second after the step, over the step's height;
settling [s]: after the step into 5 % about that mean; both NaN but for the step; chatter [V]; n_hat [rad/s], v_hat,
U_hat [m/s]: root mean square errors of the estimates against the truth, from 1 s on; v_spread [m/s]: root mean square
change of v_hat from sample to sample less that of the truth, in squares, negative as 0; speed [rad/s]: rotor speed
against n_d. Thrusts are means over a period; the set point's windows are left out, but for overshoot and settling."""
_SETTLED = 1.0  # s
_STEP_AT = 5.0  # s


class Experiment(NamedTuple):
    """A strategy's name, a set point of `KINDS`, and a seed."""

    strategy: str
    reference: str
    seed: int


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """What all experiments of a study share.

    Attributes:
        truth: the plant's set; `deviation`: of its factors, see `plants.drawn_plant`; process_noise: what pushes it.
        believed: the controllers' sets by strategy; form, beliefs, input_map, table: see `controllers`.
        rig: sensors; timing: instants of sampling and acting.
        seed: of the study.
    """

    truth: ParameterSet
    deviation: float
    believed: Mapping[str, ParameterSet]
    form: str = "bench"
    beliefs: str = "bench"
    input_map: Any = None
    table: Any = None
    rig: Rig = field(default_factory=Rig)
    timing: Timing = field(default_factory=Timing)
    seed: int = 0
    process_noise: ProcessNoise = CALM


def set_point(reference: str, period: float) -> Array:
    """Return the wanted thrust [N] of each period of a run, (N,)."""
    time = period * np.arange(round(DURATION / period) + 1)
    return REFERENCES[KINDS[reference]].thrust(time)


def run_experiment(experiment: Experiment, given: Conditions, flow: Array | None = None) -> LoopRun:
    """Run one experiment; `flow`: readings [m/s] in the place of the velocimeter's, see `simulate_loop`."""
    name, reference, seed = experiment
    p = given.believed[name].coefficients
    control = controller(name, p, form=given.form, beliefs=given.beliefs, input_map=given.input_map, table=given.table)
    drawn = drawn_plant(given.truth, given.deviation, np.random.default_rng((given.seed, seed, 0)))
    plant = replace(drawn, process_noise=given.process_noise)
    rig = given.rig
    if reads_load_cell(control):
        rig = Rig(**{**vars(rig), "load_cell_in_loop": True})
    entropy = (given.seed, seed, 1 + list(KINDS).index(reference))
    wanted = set_point(reference, given.timing.period)
    return simulate_loop(wanted, plant, control, rig=rig, timing=given.timing, seed=entropy, flow=flow)


def score(run: LoopRun, reference: str) -> dict[str, float]:
    """Return the `SCORES` of a run."""
    scored = REFERENCES[KINDS[reference]]
    told = tracking_scores(run.time, run.load, run.of("u"), scored)
    true = tracking_scores(run.time, run.force, run.of("u"), scored)
    after = run.time >= _STEP_AT
    is_step = reference == "step"
    late = run.time >= _SETTLED
    before, end = (float(np.mean(run.force[(run.time >= t - 1.0) & (run.time < t)])) for t in (_STEP_AT, DURATION))
    found = {
        "rmse": told.rmse,
        "rmse_true": true.rmse,
        "largest": true.largest,
        "overshoot": overshoot(run.force[after], before, end) if is_step else np.nan,
        "settling": settling_time(run.time[after], run.force[after], before, end) if is_step else np.nan,
        "chatter": told.chatter,
        "speed": rms((run.true("speed") - run.of("n_d"))[late]),
    }
    for name, output in (("n", "speed"), ("v", "axial"), ("U", "ambient")):
        found[f"{name}_hat"] = rms((run.of(name) - run.true(output))[late])
    jumps = float(np.mean(np.diff(run.of("v")[late]) ** 2) - np.mean(np.diff(run.true("axial")[late]) ** 2))
    found["v_spread"] = max(jumps, 0.0) ** 0.5
    return {name: float(found[name]) for name in SCORES}
