"""The plant linearised along a recording: for what disturbs rotor and water, and for what a block may be missing."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.prediction import Happened, taken
from system_identification.system import Linear
from thruster_model.effects.active import ActiveEffects
from thruster_model.effects.chains import SENSED
from thruster_model.effects.stages import LIBRARY, NO_EFFECTS, effect_values
from thruster_model.equations.classes import axial_rate, rotor_rate
from thruster_model.equations.thruster import ambient_acceleration
from thruster_model.pipeline import pipeline
from thruster_model.whole_run import readings

if TYPE_CHECKING:
    from gap_diagnosis.problem import Problem

__all__ = ["PUSHED", "Slopes", "linear_run", "linearised"]

Array = NDArray[np.float64]
_PERIOD = 0.02
"""Of the linearised model [s]; disturbances last much longer."""
_SPREAD = 1.5
"""Noises of a single reading by which a state may lie to either side of its path: slopes are means over that."""
_UNREAD, _MOST = 0.005, 0.02
"""The same over a state's largest value: where it is not read, and at most."""
_LEAST = (1e-2, 1e-4, 1e-4)
"""In n [rad/s], v and U [m/s], however quiet a sensor is."""
_SMALL = 1e-3
_THROTTLE_STEPS = (1e-3, 0.4)  # [V]: a large one reaches out of the dead zone
_READINGS = {"speed": 3, "axial": 4, "ambient": 5, "thrust": 6, "torque": 7}  # places in the pipeline's result
PUSHED = {"rotor": "speed", "axial_flow": "axial", "flow": "ambient"}
"""What is pushed by a disturbance of its own, in the order of the states (n, v, U), and the signal that reads it.

Turbulence moves the water at the propeller and not that around it, or both; left out, it is taken for an effect.
"""


class Slopes(NamedTuple):
    """The model along a run of N instants: transitions (N, 3, 3), their integrals, d readings / d state by signal
    (N, 3), d rates and d readings / d throttle by each of the steps, and what a force or a moment does to the rates
    (N, 3). `unforeseen`: variances that states gain from one instant to the next by what nothing foretells (N, 3).
    """

    transition: Array
    gain: Array
    unforeseen: Array
    readings: dict[str, Array]
    by_throttle: list[Array]
    readings_by_throttle: list[dict[str, Array]]
    by_force: Array
    by_moment: Array


def _as_read(
    slopes: Array, outputs: dict[str, Array], every: int, dt: float, sizes: dict[str, dict[str, float]]
) -> dict[str, Array]:
    """Return by signal what its sensor reads of slopes (3, 5, N) of what there is to be sensed, (N, 3).

    Scales and cross-talk act on what pushes do as well. What a sensor remembers is shorter than pushes last, and a
    converter's steps have no slope.
    """
    static = {
        name: own
        for name, own in sizes.items()
        if LIBRARY[name].block == "sensor" and LIBRARY[name].floats is None and not LIBRARY[name].trace
    }
    if static:
        sensors = ActiveEffects(sizes=static).sensors
        rows = np.array([outputs[name][::every] for name in SENSED])
        base = readings(rows, dt, sensors)
        slopes = np.array([(readings(rows + _SMALL * each, dt, sensors) - base) / _SMALL for each in slopes])
    return {name: np.ascontiguousarray(slopes[:, k].T) for k, name in enumerate(_READINGS)}


def _steps(problem: "Problem", most: Sequence[float]) -> list[float]:
    """Return how far n [rad/s], v and U [m/s] may lie to either side of their paths; `most`: their largest values."""
    read = [problem.single.get(signal) for signal in ("speed", "axial", "ambient")]
    spread = [
        _UNREAD * m if noise is None else min(_SPREAD * noise, _MOST * m) for noise, m in zip(read, most, strict=True)
    ]
    return [max(step, least) for step, least in zip(spread, _LEAST, strict=True)]


def _rates(columns: Sequence[Sequence[Array]]) -> Array:
    """Return d rates / d states, (N, 3, 3), of slopes by state."""
    return np.array([[columns[k][row] for k in range(3)] for row in range(3)]).transpose(2, 0, 1)


def linear_run(problem: "Problem", x: Array, index: int, happened: Happened, apart: Array | None = None) -> Linear:
    """Return a recording linearised for disturbances of rotor and water; `apart`: see `linearised`."""
    recording = problem.recordings[index]
    dt = recording.experiment.dt
    every = max(1, round(_PERIOD / dt))
    slopes = linearised(problem, x, index, happened, every, apart)
    shifts, sizes = problem.situation(x, index).shifts, problem.sizes(x)
    rows, places, readings, signals = [], [], [], []
    for each in problem.series:
        if each.recording != index:
            continue
        at = taken(each.signal, recording, sizes, shifts) / every
        rows.append(np.arange(each.first, each.last))
        places.append(_before(at, slopes))
        readings.append(_between(slopes, slopes.readings[each.signal], at))
        signals.append(np.full(at.size, problem.signal_names.index(each.signal)))
    order = np.argsort(np.concatenate(places), kind="stable")
    return Linear(
        dt=dt * every,
        transition=np.ascontiguousarray(slopes.transition),
        push=np.ascontiguousarray(slopes.gain),
        unforeseen=slopes.unforeseen,
        rows=np.concatenate(rows)[order],
        places=np.concatenate(places)[order],
        readings=np.ascontiguousarray(np.concatenate(readings)[order]),
        signals=np.concatenate(signals)[order],
    )


def _before(at: Array, slopes: Slopes) -> NDArray[np.int64]:
    """Return the places of the last instants that are not after those, (M,)."""
    return np.minimum(at.astype(np.int64), len(slopes.transition) - 1)


def _between(slopes: Slopes, readings: Array, at: Array) -> Array:
    """Return d reading / d state and push, as of the instant before, of samples taken at instants `at`, (M, 6).

    In straight lines from one instant to the next: what a sample tells must not jump as its clock moves past one.
    """
    places = _before(at, slopes)
    share = np.minimum(at - places, 1.0)[:, None]
    then = np.minimum(places + 1, len(readings) - 1)
    slope = (1.0 - share) * readings[places] + share * readings[then]
    moved = np.einsum("ij,ijk->ik", slope, slopes.transition[places] - np.eye(3))
    pushed = np.einsum("ij,ijk->ik", slope, slopes.gain[places])
    return np.hstack((slope + share * moved, share * pushed))


def _brink(rate: Callable[[Array], Array], v: Array, step: float) -> tuple[Array, Array]:
    """Return how fast an axial flow v (N,) that rests leaves by itself [1/s], and how far it rests, 0 to 1.

    An idle propeller's water rests beside a passing flow U: at v = 0 by (4.4), which it leaves to one side, for U, as
    soon as anything moves it that way. Nothing foretells whether it comes to rest there, nor when it leaves.
    """
    here = rate(v)
    growth = np.maximum(np.maximum(rate(v + step) - here, here - rate(v - step)) / step, 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return growth, np.nan_to_num(1.0 / (1.0 + (here / (growth * step)) ** 2))


def linearised(
    problem: "Problem", x: Array, index: int, happened: Happened, every: int = 1, apart: Array | None = None
) -> Slopes:
    """Return the model at x, linearised along what happened in one recording, at every so many steps of that.

    Statistically: slopes are means over as far as pushes may have moved a state. Where friction turns round or a dead
    zone ends, the slope at a point is that of either side.

    `apart`: along states (n, v, U) that differ by so much from those, (N, 3); by no more than the run itself goes, as
    what no sensor reads a filter may see anywhere.
    """
    dt = problem.recordings[index].experiment.dt * every
    p = problem.parameter_set.model.coefficients(problem.values(x))
    sizes = problem.sizes(x)
    e = effect_values(sizes) if sizes else NO_EFFECTS
    u = happened.throttle[::every]
    gates = problem.gates[index] if problem.gates else np.ones(1)
    gate = gates[np.minimum(every * np.arange(u.size), gates.size - 1)]
    outputs = happened.outputs
    state = [outputs[name][::every] for name in ("speed", "axial", "ambient")]
    most = [float(np.max(np.abs(each))) for each in state]
    if apart is not None:
        state = [s + np.clip(np.nan_to_num(a), -m, m) for s, a, m in zip(state, apart.T, most, strict=True)]

    def at(states: Sequence[Array], throttle: Array) -> list[Array]:
        n, v, ambient = states
        found = pipeline(n, v, ambient, throttle, 0.0, 0.0, gate, 1.0, p, e)
        return [np.broadcast_to(np.asarray(value, dtype=np.float64), u.shape) for value in found]

    def slopes_over(steps: Sequence[float]) -> list[list[Array]]:
        """Return slopes by each state, means over a step to either side."""
        columns = []
        for k, step in enumerate(steps):
            above = [each + step * (j == k) for j, each in enumerate(state)]
            below = [each - step * (j == k) for j, each in enumerate(state)]
            columns.append([(a - b) / (2.0 * step) for a, b in zip(at(above, u), at(below, u), strict=True)])
        return columns

    n, v, ambient = state
    steps = _steps(problem, most)
    columns = slopes_over(steps)
    by_throttle = [
        [(a - b) / (2.0 * step) for a, b in zip(at(state, u + step), at(state, u - step), strict=True)]
        for step in _THROTTLE_STEPS
    ]
    rates, own = _rates(columns), np.arange(3)
    by_itself = rates[:, 1, 1].copy()
    growing = np.any(rates[:, own, own] > 0.0, axis=1)
    if np.any(growing):
        # Each state by itself dies away: a rotor that a larger push would start rests under smaller ones, by the slopes
        # at the point itself. Where a jump between two steps looks like growth even there, none goes on.
        rates[growing] = _rates(slopes_over(_LEAST))[growing]
        rates[:, own, own] = np.minimum(rates[:, own, own], 0.0)
    growth, rests = _brink(lambda v: at([state[0], v, state[2]], u)[1], state[1], steps[1])
    if apart is not None and any(each.recording == index and each.signal == "axial" for each in problem.series):
        # A sensor sees whether it comes to rest, and how it leaves: from too little to be read, by the growth there.
        _, rests = _brink(lambda v: at([state[0], v, ambient], u)[1], outputs["axial"][::every], steps[1])
        rates[:, 1, 1] += rests * (np.maximum(by_itself, growth) - rates[:, 1, 1])
        unforeseen = ambient**2 * (np.diff(rests > 0.5, prepend=False) & (rests > 0.5))
    else:
        leaves = growth * rests  # It is forgotten at this rate that it was there.
        rates[:, 1, 1] -= leaves
        unforeseen = ambient**2 * -np.expm1(-2.0 * leaves * dt)
    step = np.clip(rates, -0.9 / dt, 0.9 / dt) * dt
    square = step @ step
    eye = np.eye(3)
    cube = square @ step
    zero, one = np.zeros_like(u), np.ones_like(u)

    def slope(rate: Any, *arguments: Any) -> Array:
        """Return by how much a rate, linear in its last argument before the coefficients, moves for a unit of it."""
        return np.asarray(rate(*arguments, one, p)) - np.asarray(rate(*arguments, zero, p)) + zero

    by_moment = np.asarray(rotor_rate(n, one, zero, 1.0, p)) - np.asarray(rotor_rate(n, zero, zero, 1.0, p)) + zero
    by_force = np.stack((zero, slope(axial_rate, v, ambient), slope(ambient_acceleration, ambient)), axis=1)
    return Slopes(
        transition=eye + step + square / 2.0 + cube / 6.0 + square @ square / 24.0,
        gain=dt * (eye + step / 2.0 + square / 6.0 + cube / 24.0),
        unforeseen=np.stack((zero, unforeseen, zero), axis=1),
        readings=_as_read(
            np.array([[c[row] for row in _READINGS.values()] for c in columns]), outputs, every, dt, sizes
        ),
        by_throttle=[np.stack(slopes[:3], axis=1) for slopes in by_throttle],
        readings_by_throttle=[{name: slopes[row] for name, row in _READINGS.items()} for slopes in by_throttle],
        by_force=by_force,
        by_moment=np.stack((by_moment, zero, zero), axis=1),
    )
