"""What no known effect explains: residuals regressed on a flexible basis of states, inputs, their past and time.

A few features are chosen greedily out of some hundred. Each pays for having been chosen (the logarithm of how many
there are) and for its size (half the logarithm of its gain), so that the sum is a logarithm of evidence like that of
an effect. Nuisances are re-tuned to first order beside every feature.
"""

from collections.abc import Sequence
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from gap_diagnosis.lines import Line, lines_of
from gap_diagnosis.prediction import Happened, nearest
from gap_diagnosis.problem import Problem
from system_identification.fitting import Fitted
from system_identification.noise import Whitener

__all__ = ["Discrepancy", "Feature", "basis_of", "chosen_greedily", "discrepancy"]

Array = NDArray[np.float64]
MOST_FEATURES = 12
_FREQUENCIES = np.geomspace(0.15, 6.4, 6)  # of modes [Hz]
_DAMPINGS = (0.1,)  # over critical
_HUM = 0.1
"""Power of a line over that of the noise up to which it is listed, but says nothing against a model."""
_THE_SAME = 0.8
"""Share of a function's power that lies along an effect's trace from which on they are the same."""


class Feature(NamedTuple):
    """One function that residuals of a signal depend on, and how much cost it takes off."""

    signal: str
    name: str
    gain: float


class Discrepancy(NamedTuple):
    """Chosen features, the logarithm of evidence for them, and what they explain of the raw residuals, shape (R,)."""

    features: tuple[Feature, ...]
    evidence: float
    explained: Array


def discrepancy(fitted: Fitted, noise: Whitener, unlike: Array | None = None) -> Discrepancy:
    """Return what the residuals of a fit under a noise depend on.

    `unlike`: what an effect does to the rows (R,). A function that is that effect, as a constant is the bias of a
    sensor, is left out: it is no rival of that name.
    """
    problem = fitted.problem
    happened = problem.happened(fitted.x)
    names, blocks = _features(fitted, happened)
    lines, left = _that_take_off(lines_of(fitted, happened), fitted.white, noise)
    waves = sum((line.explained for line in lines), start=np.zeros(problem.known.size))
    pull = fitted.pull - fitted.jacobian.T @ (fitted.white - left)
    white = np.hstack([noise.whiten(_in_rows(problem, signal, block)) for signal, block in blocks])
    gram, slope = white.T @ white, white.T @ left
    power = np.diag(gram).copy()
    cross = fitted.jacobian.T @ white
    retuning = fitted.retuning(cross)
    gram -= cross.T @ retuning
    slope -= retuning.T @ pull
    if unlike is not None:
        trace = noise.whiten(unlike)
        aside = fitted.jacobian.T @ trace
        along = white.T @ trace - cross.T @ fitted.retuning(aside)
        whole = float(trace @ trace - aside @ fitted.retuning(aside))
        power = np.where(along**2 > _THE_SAME * np.diag(gram) * whole, np.inf, power)
    chosen, gains, evidence = chosen_greedily(gram, slope, power, MOST_FEATURES)
    labelled = [(signal, name) for signal, _ in blocks for name in names]
    features = [Feature(*labelled[k], gain) for k, gain in zip(chosen, gains, strict=True)]
    features += [Feature(signal, line.name, 2.0 * odds) for line in lines for signal, odds in line.odds.items()]
    features.sort(key=lambda feature: -feature.gain)
    weights = np.zeros(slope.size)
    if chosen:
        weights[chosen] = np.linalg.lstsq(gram[np.ix_(chosen, chosen)], slope[chosen], rcond=None)[0]
    # Beside the features the nuisances are re-tuned.
    explained = waves - fitted.sensitivities @ (retuning @ weights)
    for place, (signal, block) in enumerate(blocks):
        explained[problem.signal_rows[signal]] += block @ weights[place * len(names) : (place + 1) * len(names)]
    evidence += sum(line.evidence for line in lines if _matters(fitted, noise, line))
    return Discrepancy(tuple(features), evidence, explained)


def _in_rows(problem: Problem, signal: str, block: Array) -> Array:
    """Return columns at the samples of one signal (M, K) among all rows, (R, K)."""
    rows = np.zeros((problem.known.size, block.shape[1]))
    rows[problem.signal_rows[signal]] = block
    return rows


def _that_take_off(lines: Sequence[Line], white: Array, noise: Whitener) -> tuple[list[Line], Array]:
    """Return the lines whose waves, whitened, take something off white rows (R,), and what these leave.

    Spectra are those of residuals as they are: what pushes and re-tuned parameters explain may look like a line there.
    """
    kept = []
    for line in lines:
        less = white - noise.whiten(line.explained)
        if less @ less < white @ white:
            kept.append(line)
            white = less
    return kept, white


def _matters(fitted: Fitted, noise: Whitener, line: Line) -> bool:
    """Tell whether a line is a noteworthy part of what is left of a signal: every machine hums a little."""
    places = fitted.problem.signal_rows
    powers = [float(np.mean(line.explained[places[n]] ** 2)) / noise.level(n) ** 2 for n in line.odds]
    return max(powers) > _HUM


def chosen_greedily(gram: Array, slope: Array, power: Array, most: int) -> tuple[list[int], list[float], float]:
    """Return the columns chosen, the cost that each takes off and the logarithm of evidence for all of them.

    Args:
        gram: products of the whitened columns once the nuisances are re-tuned, shape (K, K).
        slope: their products with the whitened residuals, shape (K,).
        power: squares of the columns as they are, shape (K,).
        most: at most so many.
    """
    usable = np.diag(gram) > np.maximum(1e-3 * power, 1e-6)
    occam = np.log(max(int(np.sum(usable)), 1))
    whole = np.diag(gram).copy()
    chosen: list[int] = []
    gains: list[float] = []
    evidence = 0.0
    for _ in range(min(most, slope.size)):
        diagonal = np.where(usable, np.diag(gram), np.inf)
        possible = np.where(usable & (diagonal > 1e-3 * whole), slope**2 / np.maximum(diagonal, 1e-12), 0.0)
        k = int(np.argmax(possible))
        worth = 0.5 * possible[k] - occam - 0.5 * np.log(max(possible[k], 1.0))
        if worth <= 0.0:
            break
        evidence += float(worth)
        chosen.append(k)
        gains.append(float(possible[k]))
        row = gram[k] / gram[k, k]
        slope = slope - row * slope[k]
        gram = gram - np.outer(gram[:, k], row)
        usable[k] = False
    return chosen, gains, evidence


def _features(fitted: Fitted, everything: Sequence[Happened]) -> tuple[list[str], list[tuple[str, Array]]]:
    """Return names, and for each signal the basis at its samples in all recordings (M, K), columns of unit size."""
    problem = fitted.problem
    sizes = problem.sizes(fitted.x)
    found: dict[str, list[Array]] = {s: [] for s in problem.signal_rows if s not in problem.opaque}
    names: list[str] = []
    for index, happened in enumerate(everything):
        recording = problem.recordings[index]
        shifts = problem.situation(fitted.x, index).shifts
        names, basis = basis_of(happened.outputs, happened.throttle, recording.experiment.dt)
        for each in problem.series:
            if each.recording == index and each.signal in found:
                found[each.signal].append(basis[:, nearest(each.signal, recording, sizes, shifts)].T)
    blocks = []
    for signal, pieces in found.items():
        columns = np.vstack(pieces)
        scale = np.sqrt(np.mean(columns**2, axis=0))
        blocks.append((signal, columns / np.where(scale > 0.0, scale, 1.0)))
    return names, blocks


def basis_of(outputs: dict[str, Array], u: Array, dt: float) -> tuple[list[str], Array]:
    """Return names and rows (K, N): functions of rotor speed, flows, throttle, their rates, their past and time."""
    n, v, ambient, force = outputs["speed"], outputs["axial"], outputs["ambient"], outputs["thrust"]
    time: Array = dt * np.arange(n.size, dtype=np.float64)
    n_dot, u_dot = _rate(n, dt), _rate(u, dt)
    named: dict[str, Array] = {
        "constant": np.ones_like(n),
        "time": time,
        "n": n,
        "|n|": np.abs(n),
        "n|n|": n * np.abs(n),
        "n^2": n**2,
        "n^3": n**3,
        "u": u,
        "|u|": np.abs(u),
        "u|u|": u * np.abs(u),
        "u^3": u**3,
        "T": force,
        "|T|": np.abs(force),
        "dn/dt": n_dot,
        "|dn/dt|": np.abs(n_dot),
        "dn/dt|dn/dt|": n_dot * np.abs(n_dot),
        "n while |n| falls": n * (n * n_dot < 0.0),
        "|n| dn/dt": np.abs(n) * n_dot,
        "du/dt": u_dot,
        "dT/dt": _rate(force, dt),
        "U": ambient,
        "U|U|": ambient * np.abs(ambient),
        "|U|": np.abs(ambient),
        "dU/dt": _rate(ambient, dt),
        "v": v,
        "v|v|": v * np.abs(v),
        "|n|v": np.abs(n) * v,
        "|n|U": np.abs(n) * ambient,
        "T against the flow": force * (n * v < 0.0),
        "u time": u * time,
        "n time": n * time,
        "T time": force * time,
        "sgn n": np.tanh(n / 5.0),
        "sgn n near rest": np.tanh(n / 2.0) * np.exp(-0.5 * (n / 10.0) ** 2),
        "sgn u": np.tanh(u / 0.05),
        "sin n/10": np.sin(n / 10.0),
        "sin n/5": np.sin(n / 5.0),
    }
    for level in (0.6, 0.8, 0.9):
        top = level * max(float(np.max(np.abs(n))), 1.0)
        named[f"|n| beyond {100 * level:.0f} % of its largest"] = np.sign(n) * np.maximum(np.abs(n) - top, 0.0)
        named[f"n within {100 * (1 - level):.0f} % of its largest"] = n * np.exp(-0.5 * (n / ((1 - level) * top)) ** 2)
    for constant in (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0):
        keep = np.exp(-dt / constant)
        for label, driver in (("u", u), ("n", n), ("T", force), ("|u|", np.abs(u)), ("U", ambient)):
            named[f"{label} behind {constant:g} s"] = lfilter([1.0 - keep], [1.0, -keep], driver)
    warm = lfilter([dt / 60.0], [1.0, -np.exp(-dt / 60.0)], np.abs(u))
    named["n after warming up"] = n * warm
    for frequency, damping in product(_FREQUENCIES, _DAMPINGS):
        for label, driver in (("u", u), ("T", force)):
            answer = _mode(driver, frequency, damping, dt)
            what = f"{label} through a mode at {frequency:.2g} Hz, damping {damping:g}"
            named[what] = answer
            named[f"rate of {what}"] = _rate(answer, dt)
    for part, (start, end) in enumerate(pairwise(np.linspace(0.0, time[-1], 4))):
        during = (time >= start) & (time < end)
        named[f"n in third {part + 1} of the run"] = n * during
        named[f"T in third {part + 1} of the run"] = force * during
    return list(named), np.array(list(named.values()))


def _rate(values: Array, dt: float) -> Array:
    """Return backward differences: in closed loop the next command knows this sample's noise."""
    return np.asarray(np.diff(values, prepend=values[:1]) / dt)


def _mode(driver: Array, frequency: float, damping: float, dt: float) -> Array:
    omega = 2.0 * np.pi * frequency
    radius = np.exp(-damping * omega * dt)
    turned = np.cos(omega * np.sqrt(1.0 - damping**2) * dt)
    poles = [1.0, -2.0 * radius * turned, radius**2]
    return np.asarray(lfilter([sum(poles)], poles, driver))
