"""Fit of a hypothesis by Levenberg and Marquardt, and its evidence by Laplace's method."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, solve_triangular

from system_identification.noise import Whitener, white_noise
from system_identification.ranges import within_ranges
from system_identification.system import System

__all__ = ["Fitted", "fit", "fit_past_jumps", "reweighed", "sharpened", "zooming"]

Array = NDArray[np.float64]
_DONE = 0.02  # gain of a step, in cost, at which a fit has converged
_DONE_AT_JUMPS = 0.5  # the same where a reading jumps as a state passes a threshold, and each step finds a little
_BORROWED_IS_DONE = 2.0
_AS_PROMISED = 0.3
"""Share of what a step promises to gain from which on sensitivities are near enough to be corrected by it alone."""
_STILL, _STILL_SIZE = 0.1, 0.02
"""By how much nuisances, in deviations, and sizes, in shares of them, may have moved from where slopes were found."""
_SLACK = 1e-3  # share of the excess of cost over the number of rows that counts as converged too
_ROUNDS = 6
_FINER = 6
"""Rounds of a finer search about a size, each about three times as fine."""
_TRIES = 8  # dampings tried for a step, each ten times the one before


@dataclass(frozen=True, kw_only=True)
class Fitted:
    """A hypothesis at its most probable unknowns.

    Attributes:
        problem: the hypothesis, a `System`.
        x: unknowns, shape (K,).
        residuals: measured less predicted in the signals' units, NaN = missing, shape (R,).
        white: the same whitened, shape (R,).
        sensitivities: d predicted / d unknowns in the signals' units, 0 where nothing counts, shape (R, K).
        jacobian: the same whitened, shape (R, K).
        prior: inverse variances of the nuisances, shape (nuisances,).
        anchor: unknowns at which the sensitivities were last found, rather than corrected, shape (K,); NaN: those to
            the nuisances are another set's.
        cost: sum of squares of `white` and of the nuisances over their deviations.
        evidence: logarithm of the probability of the data, less what all hypotheses share.
    """

    problem: Any
    x: Array
    residuals: Array
    white: Array
    sensitivities: Array
    jacobian: Array
    prior: Array
    anchor: Array
    cost: float
    evidence: float

    @property
    def covariance(self) -> Array:
        """Of the unknowns, shape (K, K)."""
        return np.asarray(np.linalg.inv(_information(self.jacobian.T @ self.jacobian, self.prior)))

    def retuning(self, columns: Array) -> Array:
        """Return by how much the unknowns move, to first order, beside further columns with these products.

        `columns`: jacobian' times whitened columns, shape (K, C); sizes are free.
        """
        information = _with_priors(self.jacobian.T @ self.jacobian, self.prior)
        return np.asarray(np.linalg.solve(information + 1e-9 * np.eye(information.shape[0]), columns))

    @property
    def pull(self) -> Array:
        """Half the downward slope of the cost over the unknowns, shape (K,); zero at the very minimum."""
        return _pull(self.jacobian, self.white, self.x, self.prior)


def fit(
    problem: System,
    noise: Whitener,
    x: Array,
    *,
    iterations: int = 8,
    rows: NDArray[np.bool_] | None = None,
    near: Fitted | None = None,
    polish: bool = True,
    anew: bool = True,
) -> Fitted:
    """Return the fit from a start `x`.

    Args:
        problem: what is fitted.
        noise: by which residuals are whitened.
        x: unknowns to start from, shape (K,).
        iterations: at most so many.
        rows: those that count (all, where not given).
        near: a fit with the same nuisances: its sensitivities to them serve until the cost no longer falls much.
        polish: end with the fit's own sensitivities, although borrowed ones have converged.
        anew: find sensitivities anew where corrected ones promise what they do not hold.
    """
    x = problem.bounded(x)
    residuals, white, cost = _cost(problem, noise, x, rows)
    sensitivities, anchor = (_own(problem, x), x) if near is None else _borrowed(problem, x, near)
    own = _close(problem, x, anchor)
    jacobian = _counted(noise.whiten(sensitivities), rows)
    rows_known = int(np.sum(problem.known if rows is None else problem.known & rows))
    prior, damping, movable = noise.prior(problem), 1e-6, problem.movable()
    for _ in range(iterations):
        pull = np.where(movable, _pull(jacobian, white, x, prior), 0.0)
        # At an end of its range none follows a pull outwards.
        free = movable & ((pull == 0.0) | (problem.bounded(x + 1e-9 * np.sign(pull)) != x))
        gradient = np.where(free, pull, 0.0)
        information = _information((jacobian.T @ jacobian) * (free[:, None] & free), prior)
        # Where the model is wrong as such, its last thousandth is not worth the time.
        done = max(_DONE_AT_JUMPS if problem.jumps else _DONE, _SLACK * (cost - rows_known))
        # What a whole step would gain, were the predictions linear.
        promised = float(gradient @ cho_solve(cho_factor(information), gradient))
        gain = 0.0
        for _ in range(_TRIES if promised > done else 0):
            damped = information + damping * np.diag(np.diag(information))
            factor = cho_factor(damped)
            step = cho_solve(factor, gradient)
            turn = np.zeros_like(step)
            if own:
                bend = _bend(problem, noise, x, white, step, jacobian, rows)
                turn = -cho_solve(factor, np.where(free, jacobian.T @ bend, 0.0))
                turn *= min(1.0, 1.5 * float(np.linalg.norm(step)) / max(float(np.linalg.norm(turn)), 1e-300))
            tried = within_ranges(problem.bounded, x, step + 0.5 * turn, damped, gradient)
            at = _cost(problem, noise, tried, rows)
            if at[2] < cost:
                gain, moved_by = cost - at[2], tried - x
                changed, changed_white = np.nan_to_num(residuals - at[0]), white - at[1]
                x, (residuals, white, cost) = tried, at
                damping = max(damping * 0.1, 1e-9)
                break
            damping = max(damping * 10.0, 1e-5)
        enough = done if own or polish else max(done, _BORROWED_IS_DONE)
        if gain < enough and (own or (not polish and not (anew and promised > enough))):
            break  # borrowed slopes that promise more than they hold are found anew
        if not anew or gain >= max(done, _BORROWED_IS_DONE, _AS_PROMISED * promised):
            sensitivities = _updated(sensitivities, moved_by, changed)
            jacobian = _updated(jacobian, moved_by, changed_white)
            own = _close(problem, x, anchor)
        else:
            own, anchor = True, x
            sensitivities = _own(problem, x)
            jacobian = _counted(noise.whiten(sensitivities), rows)
    return Fitted(
        problem=problem,
        x=x,
        residuals=residuals,
        white=white,
        sensitivities=sensitivities,
        jacobian=jacobian,
        prior=prior,
        anchor=anchor,
        cost=cost,
        evidence=_evidence(problem, noise, cost, jacobian),
    )


def reweighed(fitted: Fitted, noise: Whitener, filtered: Array) -> Fitted:
    """Return a fit as it is, under another noise; `filtered`: its sensitivities, filtered by that, (R, K)."""
    problem = fitted.problem
    jacobian = filtered if noise.loose is None else noise.loose(filtered)
    white, prior = noise.whiten(fitted.residuals), noise.prior(problem)
    cost = float(white @ white + prior @ fitted.x[: prior.size] ** 2)
    evidence = _evidence(problem, noise, cost, jacobian)
    return replace(fitted, white=white, jacobian=jacobian, prior=prior, cost=cost, evidence=evidence)


def _counted(white: Array, rows: NDArray[np.bool_] | None) -> Array:
    """Return white rows (R, K) with those that do not count at 0."""
    return white if rows is None else np.where(rows[:, None], white, 0.0)


_OUTLYING = 6.0
"""Standard deviations from which a sample tells of a jump that is predicted at another instant."""


def _outlying(problem: System, residuals: Array) -> NDArray[np.bool_]:
    """Return which samples stand out of their own noise, and of what most of the others leave, shape (R,)."""
    white = np.abs(white_noise(problem).whiten(residuals))
    return np.asarray(white >= _OUTLYING * max(1.4826 * float(np.median(white[problem.known])), 1.0))


def fit_past_jumps(problem: System, noise: Whitener, x: Array) -> Fitted:
    """Return the fit of predictions that jump where a state passes a threshold, from a start `x`.

    A sample that passes it on the other side than predicted costs more than all the others gain by a step, and holds
    the fit where it is: such samples are left out until the others have put the threshold right. They stand out of
    the noise of the samples themselves, not of one that had to make room for them.
    """
    own = white_noise(problem)
    rows: NDArray[np.bool_] | None = None
    for _ in range(_ROUNDS):
        kept = ~_outlying(problem, problem.residuals(x))
        if rows is not None and np.array_equal(kept, rows):
            break
        rows = kept
        x = fit(problem, own, x, iterations=5, rows=rows).x
    return fit(problem, noise, x, iterations=8)


def zooming(spacing: float) -> Iterator[Array]:
    """Yield factors about 1, (9,), to try on the best so far: within `spacing`, and ever more narrowly."""
    for _ in range(_FINER):
        yield np.exp(spacing * np.linspace(-1.0, 1.0, 9))
        spacing *= 0.3


def sharpened(fitted: Fitted, noise: Whitener, spacings: Mapping[int, float]) -> Array:
    """Return unknowns (K,) with those whose traces are sharp each at the likeliest of ever finer values, the rest kept.

    `noise`: of the fit; `spacings`: by place of an unknown, how far about its value to look at first, as a share of it.
    """
    x, cost = fitted.x, fitted.cost
    for place, spacing in spacings.items():
        for factors in zooming(spacing):
            for value in x[place] * factors:
                tried = x.copy()
                tried[place] = value
                tried = fitted.problem.bounded(tried)
                less = _cost(fitted.problem, noise, tried, None)[2]
                if less < cost:
                    x, cost = tried, less
    return x


def _bend(
    problem: System,
    noise: Whitener,
    x: Array,
    white: Array,
    step: Array,
    jacobian: Array,
    rows: NDArray[np.bool_] | None,
) -> Array:
    """Return the second derivative of the whitened predictions along a step: valleys are bent.

    An effect that the parameters can imitate leaves a valley, the product of both being all that the data know; steps
    along it follow its bend (geodesic acceleration: Transtrum and Sethna 2012, arXiv:1201.5885).
    """
    part = 0.1
    there = _cost(problem, noise, problem.bounded(x + part * step), rows)[1]
    return np.asarray(2.0 / part * ((white - there) / part - jacobian @ step))


def _updated(slopes: Array, step: Array, changed: Array) -> Array:
    """Return slopes (R, K) that tell how rows changed (R,) by a step (Broyden 1965), the nearest such."""
    wrong = changed - slopes @ step
    return np.asarray(slopes + np.outer(step / max(float(step @ step), 1e-300), wrong).T)


def _own(problem: System, x: Array, columns: Sequence[int] | None = None) -> Array:
    return np.asfortranarray(np.nan_to_num(problem.sensitivities(x, columns)))


def _borrowed(problem: System, x: Array, near: Fitted) -> tuple[Array, Array]:
    """Return sensitivities (R, K), those to the nuisances as they are nearby, and where these were found, (K,).

    Beside other effects they were found nowhere: a reversed thruster turns every one of them round.
    """
    if near.problem.slots == problem.slots:
        return near.sensitivities, near.anchor
    found, rest = near.sensitivities[:, : problem.nuisances], range(problem.nuisances, x.size)
    if rest:
        found = np.hstack((found, _own(problem, x, rest)))
    return np.asfortranarray(found), np.full(x.size, np.nan)


def _close(problem: System, x: Array, anchor: Array) -> bool:
    """Tell whether sensitivities are still those of x: no unknown has moved by much, and there are no jumps."""
    count = problem.nuisances
    near = np.max(np.abs(x - anchor)[:count], initial=0.0) < _STILL
    sizes = np.all(np.abs(x - anchor)[count:] <= _STILL_SIZE * np.abs(anchor[count:]))
    return bool(near and sizes and not problem.jumps)


def _cost(problem: System, noise: Whitener, x: Array, rows: NDArray[np.bool_] | None) -> tuple[Array, Array, float]:
    residuals = problem.residuals(x)
    white = noise.whiten(residuals)
    white = white if rows is None else white * rows
    return residuals, white, float(white @ white + noise.prior(problem) @ x[: problem.nuisances] ** 2)


def _pull(jacobian: Array, white: Array, x: Array, prior: Array) -> Array:
    pull = jacobian.T @ white
    pull[: prior.size] -= prior * x[: prior.size]
    return np.asarray(pull)


def _with_priors(gram: Array, prior: Array) -> Array:
    information = gram.copy()
    information[np.arange(prior.size), np.arange(prior.size)] += prior
    return np.asarray(information)


def _information(gram: Array, prior: Array) -> Array:
    information = _with_priors(gram, prior)
    # A size without any influence is as uncertain as its range.
    rest = np.arange(prior.size, information.shape[0])
    information[rest, rest] += 12.0
    return information


def _evidence(problem: System, noise: Whitener, cost: float, jacobian: Array) -> float:
    """Return -(cost + logdet(noise) + logdet(information) - sizes ln(2 pi)) / 2; sizes in units of their ranges."""
    factor = np.linalg.cholesky(_information(jacobian.T @ jacobian, noise.prior(problem)))
    free = len(problem.slots)
    return float(
        noise.levels.log_prior
        - 0.5 * (cost + noise.log_det)
        - np.sum(np.log(np.diag(factor)))
        + 0.5 * free * np.log(2.0 * np.pi)
    )


def projector(jacobian: Array, prior: Array) -> Array:
    """Return an orthonormal basis (R + nuisances, K) of what the unknowns can do to whitened rows and their priors."""
    own = np.zeros((prior.size, jacobian.shape[1]))
    own[np.arange(prior.size), np.arange(prior.size)] = np.sqrt(prior)
    stacked = np.vstack((jacobian, own))
    lengths = np.linalg.norm(stacked, axis=0)
    stacked = stacked / np.where(lengths > 0.0, lengths, 1.0)  # of two that do the same one is left
    factor = np.linalg.cholesky(stacked.T @ stacked + 1e-9 * np.eye(stacked.shape[1]))
    return np.asarray(solve_triangular(factor, stacked.T, lower=True).T)
