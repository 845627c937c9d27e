r"""In which block something without a name is at work: what disturbance, entering there, the residuals ask for.

Each block is disturbed by functions of states, inputs, their past and time (`discrepancy.basis_of`), where its equation
stands:

command   d u             acting throttle [V]
rotor     d (dn/dt)       [rad/s^2]
thrust    d T, d Q        [N], [N m], with what they do to rotor and flow
flow      d (dv/dt), d (dU/dt)   [m/s^2]
sensor    d y             one reading alone, its unit
log       d t             time of one reading alone or of all, constant, growing, or from an eighth of the run on [s],
                          and the likeliest jump of all of them in each recording, too long for a slope

The answer of all readings follows from the model linearised along the simulated run,
        x_{k+1} = exp(A_k h) x_k + (int_0^h exp(A_k s) ds) b_k w_k,      x = (dn, dv, dU).
A few disturbances of a block are chosen greedily, nuisances re-tuned beside them; the evidence is that of
`discrepancy`. It is the process noise that the data demand, by equation (Kristensen, Madsen and Jorgensen 2004,
Automatica 40, 225), with a basis in place of a random walk.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.discrepancy import MOST_FEATURES, basis_of, chosen_greedily
from gap_diagnosis.linear import linearised
from gap_diagnosis.prediction import Happened, nearest
from system_identification.fitting import Fitted
from system_identification.noise import Whitener
from thruster_model.compilation import compiled
from thruster_model.identification.prediction import seen

__all__ = ["block_evidence"]

Array = NDArray[np.float64]
_JUMPS = (-0.4, -0.2, -0.1, 0.1, 0.2, 0.4)  # of a clock [s]: too far for a slope, and for what a lag makes


def block_evidence(fitted: Fitted, noise: Whitener) -> dict[str, float]:
    """Return for each block the logarithm of evidence for a disturbance there, above that of none."""
    problem = fitted.problem
    blocks: dict[str, list[list[Array]]] = {}
    for index, happened in enumerate(problem.happened(fitted.x)):
        for block, columns in _answers(fitted, noise, index, happened):
            blocks.setdefault(block, []).append(columns)
    evidence: dict[str, float] = {}
    for block, pieces in blocks.items():
        raw = sum(np.asarray(piece) for piece in pieces)  # each recording fills its own rows
        white = _whitened(fitted, noise, np.asarray(raw))
        size = np.sqrt(np.sum(white**2, axis=0))
        white = white[:, size > 1e-9] / size[size > 1e-9]
        cross = fitted.jacobian.T @ white
        gram = white.T @ white
        power = np.diag(gram).copy()
        retuning = fitted.retuning(cross)
        gram -= cross.T @ retuning
        slope = white.T @ fitted.white - retuning.T @ fitted.pull
        # Columns have unit length: what is left of one beside the nuisances is compared with that.
        _, _, evidence[block] = chosen_greedily(1e6 * gram, 1e3 * slope, 1e6 * power, MOST_FEATURES)
    return evidence


def _answers(fitted: Fitted, noise: Whitener, index: int, happened: Happened) -> Iterator[tuple[str, Any]]:
    """Yield (block, answers of all readings (R, K)) of one recording; rows of others are zero."""
    problem = fitted.problem
    recording = problem.recordings[index]
    dt = recording.experiment.dt
    linear = linearised(problem, fitted.x, index, happened)
    basis = basis_of(happened.outputs, happened.throttle, dt)[1]
    size = np.sqrt(np.mean(basis**2, axis=1, keepdims=True))
    basis = basis / np.where(size > 0.0, size, 1.0)
    shifts, sizes = problem.situation(fitted.x, index).shifts, problem.sizes(fitted.x)
    series = [each for each in problem.series if each.recording == index and each.signal not in problem.opaque]
    places = {each.signal: nearest(each.signal, recording, sizes, shifts) for each in series}

    def rows(answers: dict[str, Array]) -> Array:
        """Return answers by signal, each (K, N), as rows (R, K); zero for signals that this recording does not have."""
        out = np.zeros((problem.series[-1].last, next(iter(answers.values())).shape[0]))
        for each in series:
            if each.signal in answers:
                out[each.rows] = answers[each.signal][:, places[each.signal]].T
        return out

    def through(push: Array, direct: dict[str, Array]) -> Array:
        """Return the readings' answers (R, K) to the basis, pushing the rates by `push` (N, 3) for each unit."""
        states = np.zeros((basis.shape[0], basis.shape[1], 3))
        _driven(linear.transition, linear.gain, push, basis, states)
        answers = {
            each.signal: np.einsum("knj,nj->kn", states, linear.readings[each.signal])
            + basis * direct.get(each.signal, 0.0)
            for each in series
        }
        return rows(answers)

    ones = np.ones((basis.shape[1], 1))
    pushes = zip(linear.by_throttle, linear.readings_by_throttle, strict=True)
    yield "command", np.hstack([through(push, direct) for push, direct in pushes])
    yield "rotor", through(ones * np.array([1.0, 0.0, 0.0]), {})
    force = through(linear.by_force, {"thrust": ones[:, 0]})
    moment = through(linear.by_moment, {"torque": ones[:, 0]})
    yield "thrust", np.hstack((force, moment))
    axial, ambient = (through(ones * np.array(unit), {}) for unit in ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]))
    yield "flow", np.hstack((axial, ambient))
    names = [name for name in problem.signal_rows if name not in problem.opaque]
    yield "sensor", np.hstack([rows({name: basis}) for name in names])
    time = np.linspace(0.0, 1.0, basis.shape[1])
    when = np.array([np.ones_like(time), time, *(time >= k / 8.0 for k in range(1, 8))], dtype=np.float64)
    late = {name: np.gradient(happened.outputs[name], dt) * when for name in names}
    jumped = {name: np.vstack([_shifted(happened.outputs[name], dt, by) * when[2:] for by in _JUMPS]) for name in names}
    jumps = np.zeros((problem.series[-1].last, len(problem.recordings)))
    jumps[:, index] = _likeliest(fitted, noise, rows(jumped))  # a clock that jumps does so in a recording of its own
    yield "log", np.hstack([rows(late), *(rows({name: late[name]}) for name in names), jumps])


def _whitened(fitted: Fitted, noise: Whitener, columns: Array) -> Array:
    """Return columns (R, K) whitened where samples are known."""
    return noise.whiten(np.where(fitted.problem.known[:, None], columns, np.nan))


def _likeliest(fitted: Fitted, noise: Whitener, columns: Array) -> Array:
    """Return that column (R,) of several (R, K) which explains most of the residuals by itself."""
    white = _whitened(fitted, noise, columns)
    explained = (white.T @ fitted.white) ** 2 / np.maximum(np.sum(white**2, axis=0), 1e-12)
    return np.asarray(columns[:, int(np.argmax(explained))])


def _shifted(values: Array, dt: float, by: float) -> Array:
    """Return by how much values every `dt` [s] differ from those of `by` [s] before."""
    return seen(values, dt, dt * np.arange(values.size, dtype=np.float64) - by, 0.0) - values


@compiled
def _driven(transition, gain, push, basis, out):  # type: ignore[no-untyped-def]
    """Fill `out` (K, N, 3) with the state's answers to each row of `basis` (K, N), held over a step."""
    for k in range(basis.shape[0]):
        x0, x1, x2 = 0.0, 0.0, 0.0
        for i in range(basis.shape[1] - 1):
            w = basis[k, i]
            a, g = transition[i], gain[i]
            b0, b1, b2 = push[i, 0] * w, push[i, 1] * w, push[i, 2] * w
            y0 = a[0, 0] * x0 + a[0, 1] * x1 + a[0, 2] * x2 + g[0, 0] * b0 + g[0, 1] * b1 + g[0, 2] * b2
            y1 = a[1, 0] * x0 + a[1, 1] * x1 + a[1, 2] * x2 + g[1, 0] * b0 + g[1, 1] * b1 + g[1, 2] * b2
            y2 = a[2, 0] * x0 + a[2, 1] * x1 + a[2, 2] * x2 + g[2, 0] * b0 + g[2, 1] * b1 + g[2, 2] * b2
            x0, x1, x2 = y0, y1, y2
            out[k, i + 1, 0], out[k, i + 1, 1], out[k, i + 1, 2] = x0, x1, x2
