"""What innovations are worth: whitened, and how likely they are."""

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.filtering import Filtered, Prepared
from gap_diagnosis.vehicle.instants import counted, first_instant
from thruster_model.compilation import compiled

__all__ = ["LOST", "log_determinant", "log_likelihood", "whitened"]

Array = NDArray[np.float64]
LOST = 50.0
"""Deviations of a whitened reading beyond which a model is wrong, not more or less so."""


def whitened(prepared: Prepared, result: Filtered) -> Array:
    """Return innovations as independent numbers of deviation 1 where all is right, (K, 13 + N + 2); 0: nothing told."""
    K, N = result.rotor.shape
    r, first = np.zeros((K, 13 + N + 2)), counted(prepared.log, prepared.late)
    first = np.concatenate((first, np.full(N + 2, first.max())))
    _whitened(
        result.body, result.rotor, result.battery, result.states, prepared.base.body, prepared.gains.whitener,
        prepared.spread, prepared.noises.battery, first, prepared.weights, r,
    )  # fmt: skip
    return r


@compiled
def _whitened(body, rotor, battery, states, base, whitener, spread, deviations, first, weights, out):  # type: ignore[no-untyped-def]
    """Fill rows of `out` that count; a filter that is lost foresees nothing.

    A reading that is no longer there counts as one that is as far off as chance has it: without any it would be a gain.
    """
    N = rotor.shape[1]
    for k in range(first.min(), out.shape[0]):
        lost = False
        for j in range(states.shape[1]):
            lost = lost or not np.isfinite(states[k, j])
        for i in range(out.shape[1]):
            told = 0.0
            if k < first[i]:
                pass
            elif lost:
                told = LOST
            elif i >= 13 + N:
                told = battery[k, i - 13 - N] / deviations[i - 13 - N]
            elif i >= 13:
                told = rotor[k, i - 13] / spread[k, i - 13]
            elif np.isfinite(base[k, i]) and np.isnan(body[k, i]):
                told = 1.0
            elif np.isfinite(base[k, i]):
                for j in range(i + 1):  # the inverse of a factor is lower triangular
                    if not np.isnan(body[k, j]):
                        told += whitener[k, i, j] * body[k, j]
            if not np.isnan(told):
                weight = weights[k, i] if weights.size else 1.0
                out[k, i] = weight * min(max(told, -LOST), LOST)


def log_determinant(prepared: Prepared) -> float:
    """Return log |S| of all innovations that count, those of body, rotors and battery."""
    first, base = first_instant(prepared.log), prepared.base
    rotors = np.log(prepared.spread[first:])[np.isfinite(base.rotor[first:])].sum()
    battery = np.isfinite(base.battery[first:]).sum(axis=0) @ np.log(prepared.noises.battery)
    return prepared.gains.log_determinant + 2.0 * float(rotors + battery)


def log_likelihood(prepared: Prepared) -> float:
    """Return that of the body's innovations at the point for which the gains were made; outliers count as the bound."""
    if not prepared.base.done:
        return -np.inf
    body = np.einsum("kij,kj->ki", prepared.gains.whitener, np.nan_to_num(prepared.base.body))
    body[~np.isfinite(prepared.base.body)] = 0.0
    body[np.arange(len(body))[:, None] < counted(prepared.log, prepared.late)] = 0.0
    return -0.5 * float(np.sum(np.minimum(body**2, rules.MOST_DEVIATIONS**2))) - 0.5 * prepared.gains.log_determinant
