"""Where the gap lies: which block, and in which regime of operation its residuals are large.

Three views. `block_shares` weighs the blocks by the hypotheses found, the known ones by their own block and the unknown
by the block in which a nameless disturbance explains most. `block_checks` feeds single equations with measurements.
`excess_by_regime` tells when the re-tuned model is wrong beyond its noise.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.problem import Problem
from system_identification.fitting import Fitted
from system_identification.noise import Whitener
from thruster_model.effects.stages import LIBRARY
from thruster_model.equations.classes import loads
from thruster_model.equations.thruster import ambient_acceleration

__all__ = ["BLOCKS", "BlockCheck", "block_checks", "block_shares", "excess_by_regime", "regimes", "worst_regime"]

Array = NDArray[np.float64]
TEMPERATURE = 10.0
BLOCKS = ("log", "command", "rotor", "thrust", "flow", "sensor")


@dataclass(frozen=True, kw_only=True)
class BlockCheck:
    """One block fed with measured inputs: what it should yield, and its error over the sensor's noise (1: as noise)."""

    block: str
    output: str
    inputs: str
    error: float


def block_checks(fitted: Fitted, noise: Whitener) -> list[BlockCheck]:
    """Return how well single equations do when fed with measurements: thrust and torque by measured speed, and so on.

    Beside the free run's own errors, which carry every upstream error downstream.
    """
    problem = fitted.problem
    coefficients = problem.parameter_set.model.coefficients(problem.values(fitted.x))
    sums: dict[tuple[str, str, str], list[Array]] = {}
    for index, happened in enumerate(problem.happened(fitted.x)):
        experiment = problem.recordings[index].experiment
        measured = {name: experiment.measurements[name] for name in problem.signals(index)}
        grid = experiment.dt * np.arange(happened.throttle.size)

        def on_grid(name: str) -> Array:
            m = measured[name]  # noqa: B023 (used within this turn of the loop only)
            known = m.usable
            return np.asarray(np.interp(grid, m.time[known], m.values[known]))  # noqa: B023

        def compare(block: str, name: str, inputs: str, predicted: Array) -> None:
            m = measured[name]  # noqa: B023
            error = (m.values - np.interp(m.time, grid, predicted)) / noise.level(name)  # noqa: B023
            sums.setdefault((block, name, inputs), []).append(error[np.isfinite(error)])

        if "speed" in measured:
            by_speed = loads(on_grid("speed"), happened.outputs["axial"], happened.throttle, 1.0, coefficients)
            for name, predicted in zip(("thrust", "torque"), by_speed, strict=True):
                if name in measured:
                    compare("thrust", name, "measured rotor speed", np.broadcast_to(predicted, grid.shape))
        if "ambient" in measured and "thrust" in measured and coefficients.k_U > 0.0:
            compare("flow", "ambient", "measured thrust", _driven_flow(on_grid("thrust"), coefficients, experiment.dt))
        if "speed" in measured:
            compare("rotor", "speed", "throttle", happened.outputs["speed"])
    return [
        BlockCheck(block=b, output=o, inputs=i, error=float(np.sqrt(np.mean(np.concatenate(e) ** 2))))
        for (b, o, i), e in sums.items()
        if sum(x.size for x in e)
    ]


def _driven_flow(thrust: Array, p: object, dt: float) -> Array:
    """Return the ambient flow [m/s] of (4.5) driven by a measured thrust [N] (Heun, steps of `dt`)."""
    flow = np.zeros(thrust.size)
    for k in range(thrust.size - 1):
        first = ambient_acceleration(flow[k], thrust[k], p)
        second = ambient_acceleration(flow[k] + dt * first, thrust[k + 1], p)
        flow[k + 1] = flow[k] + 0.5 * dt * (first + second)
    return flow


def block_shares(
    marginal: Mapping[str, float], unknown: float, evidence: Mapping[str, float], in_logs: Sequence[str] = ()
) -> list[tuple[str, float]]:
    """Return (block, share), largest first; shares sum to one, and are empty where there is no gap.

    Args:
        marginal: probability of each suspect by key.
        unknown: probability of something else.
        evidence: logarithm of evidence for a nameless disturbance by block (`disturbances.block_evidence`); it is
            tempered, since a disturbance is told by a handful of functions of which none is the true one.
        in_logs: block of each finding in the samples themselves that is not among the suspects.
    """
    shares = dict.fromkeys(BLOCKS, 0.0)
    for block in in_logs:
        shares[block] += 1.0
    for key, probability in marginal.items():
        shares[LIBRARY[key.split(":")[0]].block] += probability
    if unknown > 0.0 and evidence:
        most = max(evidence.values())
        weights = {block: float(np.exp((found - most) / TEMPERATURE)) for block, found in evidence.items()}
        total = sum(weights.values())
        for block, weight in weights.items():
            shares[block] += unknown * weight / total
    kept = {block: share for block, share in shares.items() if share > 1e-3 * sum(shares.values())}
    whole = sum(kept.values())
    return sorted(((block, share / whole) for block, share in kept.items()), key=lambda each: -each[1])


def excess_by_regime(problem: Problem, noise: Whitener, fitted: Fitted) -> dict[str, dict[str, float]]:
    """Return by regime and signal the mean square of residuals over that of the noise, less one."""
    result: dict[str, dict[str, float]] = {}
    sums: dict[tuple[str, str], tuple[float, int]] = {}
    values = problem.parameter_set.values
    inner = min(abs(values.get("delta_u1", 0.0)), abs(values.get("delta_u2", 0.0)))
    for index, happened in enumerate(problem.happened(fitted.x)):
        experiment = problem.recordings[index].experiment
        grid = np.asarray(experiment.dt * np.arange(happened.throttle.size), dtype=np.float64)
        for each in problem.series:
            if each.recording != index:
                continue
            at = experiment.measurements[each.signal].time
            square = (fitted.residuals[each.rows] / noise.level(each.signal)) ** 2
            for regime, mask in regimes(happened.outputs["speed"], happened.throttle, grid, inner).items():
                here = np.interp(at, grid, mask) > 0.5
                inside = square[here & np.isfinite(square)]
                total, count = sums.get((regime, each.signal), (0.0, 0))
                sums[regime, each.signal] = (total + float(np.sum(inside)), count + inside.size)
    for (regime, signal), (total, count) in sums.items():
        if count >= 20:
            result.setdefault(regime, {})[signal] = total / count - 1.0
    return result


def worst_regime(excess: Mapping[str, Mapping[str, float]]) -> str:
    """Return the regime of largest mean excess; "" where none stands out."""
    means = {regime: float(np.mean(list(signals.values()))) for regime, signals in excess.items()}
    if not means:
        return ""
    best = max(means, key=lambda regime: means[regime])
    return best if means[best] > max(0.1, 1.3 * float(np.median(list(means.values())))) else "all alike"


def regimes(n: Array, u: Array, grid: Array, inner: float) -> dict[str, Array]:
    """Return where each regime of operation is (1, else 0), shape (N,).

    Args:
        n: rotor speed [rad/s], (N,).
        u: throttle [V], (N,).
        grid: instants, evenly apart [s], (N,).
        inner: edge of the dead zone [V].
    """
    largest = max(float(np.max(np.abs(n))), 1e-6)
    changing = np.abs(np.gradient(u, grid)) > 0.0
    window = max(1, round(0.5 / (grid[1] - grid[0])))
    transient = np.convolve(changing, np.ones(window), "full")[: n.size] > 0
    turned = np.zeros(n.size)
    turned[1:] = np.signbit(n[1:]) != np.signbit(n[:-1])
    reversal = np.convolve(turned, np.ones(2 * window), "full")[: n.size] > 0
    fast = np.abs(n) > 0.75 * largest
    third = grid / max(grid[-1], 1e-9)
    masks: dict[str, Any] = {
        "dead zone": np.abs(u) <= 1.15 * inner,
        "after reversals": reversal,
        "transients": transient,
        "high speed": fast,
        "forward": n > 0.05 * largest,
        "reverse": n < -0.05 * largest,
        "steady": ~transient & ~fast,
        "first third": third < 1 / 3,
        "last third": third > 2 / 3,
    }
    return {name: mask.astype(np.float64) for name, mask in masks.items()}
