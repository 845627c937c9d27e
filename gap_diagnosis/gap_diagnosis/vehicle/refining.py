r"""Nuisances and effects fitted together without linearisation, by Gauss and Newton from columns made where the fit is.

With x all unknowns in their deviations and r the whitened innovations,

    x <- x - (J^T J + W)^-1 (J^T r + W x),     log p = -1/2 r^T r - 1/2 x^T W x - 1/2 log |J^T J + 1|

W is 1 but for sizes whose neutral value is infinite, where it is 0. Columns are not those of where the search began:
what a nuisance took over before an effect was there (a thrust smaller by 15 of its deviations) it gives back only along
columns that know of the effect. They are slopes, by small steps: chords over a fifth of a deviation are not zero where
the fit is best, and fits along them stopped 40 nats short of it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.stats import chi2

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.descent import Columns, descended, normal
from gap_diagnosis.vehicle.hypotheses import Hypothesis
from gap_diagnosis.vehicle.screening import Screen
from gap_diagnosis.vehicle.side_by_side import side_by_side
from gap_diagnosis.vehicle.unknowns import Key, acts_in, in_units, sum_of
from gap_diagnosis.vehicle.whitening import LOST
from rov_sim.vehicle.effects.active import ActiveVehicleEffect

__all__ = ["Fit", "Problem", "Refined"]

Array = NDArray[np.float64]
_NEAR = 1.0
"""Of their deviations by which all unknowns together may have moved since columns were made that still hold."""
_STEP, _STEP_OF_PROBE = 0.02, 0.05
"""Of slopes: of an uncertain number, in deviations, and of a size, in those by which effects are probed."""
_COARSELY = {"xatol": 0.02, "maxiter": 12}
"""How well a share is found that only begins a fit."""
_KEPT_POINTS, _KEPT_COLUMNS = 32, 4
"""Points of a problem whose innovations are kept, and those whose columns are: a fit that goes back where it was, and
one that begins where the last one ended, ask for them again. Columns of all unknowns take some 20 MB."""


@dataclass(frozen=True, kw_only=True)
class Refined:
    """A hypothesis with its most likely sizes and their deviations, one for each of its parameters.

    A time is known no better than stamps are, however sharply the recordings tell it. A size that blocks of recordings
    tell more differently than their noise allows, as where an equation has another form, is known less well by as much
    (the sandwich of White 1982). `pressed`: by how many deviations of noise alone the first size would be farther out
    if its range did not end there.
    """

    hypothesis: Hypothesis
    sizes: tuple[float, ...]
    deviations: tuple[float, ...]
    pressed: float = 0.0

    @property
    def active(self) -> ActiveVehicleEffect:
        """The effect, switched on."""
        return self.hypothesis.active(self.sizes)

    @property
    def told(self) -> tuple[float, ...]:
        """The values of its parameters, in their units."""
        return self.hypothesis.told(self.sizes)

    @property
    def at_the_end(self) -> bool:
        """Whether recordings ask for a first size beyond the range that is searched, where that is not all of
        something."""
        if self.hypothesis.switch or self.pressed < rules.MORE_THAN_MOST:
            return False
        return not np.isclose(abs(self.sizes[0]), 1.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """The most likely point of a set of effects.

    Attributes:
        effects: in order.
        values: of the nuisances; moved: the same in their deviations, (m,).
        log_evidence: as `gram.evidence` has it, with priors about the model's own numbers.
        scatter: by how much more than expected the scores of the last effect vary from block to block, 1 or more.
        columns: (rows, n) of each run at this point: nuisances, then sizes.
    """

    effects: tuple[Refined, ...]
    values: dict[Key, float]
    moved: Array
    log_evidence: float
    scatter: float
    columns: tuple[NDArray[np.float32], ...]

    @property
    def unknowns(self) -> Array:
        """All of them in their deviations, (n,), as columns have them."""
        sizes = [s / d for a in self.effects for s, d in zip(a.sizes, a.hypothesis.scale, strict=True)]
        return np.concatenate((self.moved, sizes))


@dataclass(frozen=True, kw_only=True, eq=False)
class Problem:
    """What is fitted to which recordings.

    Attributes:
        screen: model and recordings; its own point does not matter here.
        nuisances: deviations by key.
        effects: those that are on.
    """

    screen: Screen
    nuisances: Mapping[Key, float]
    effects: tuple[Hypothesis, ...]
    _points: dict[bytes, tuple[list[Array], float]] = field(default_factory=dict)
    _made: dict[bytes, list[NDArray[np.float32]]] = field(default_factory=dict)

    def fit(
        self, moved: Array, sizes: Sequence[tuple[float, ...]], columns: Sequence[NDArray[np.float32]] = (),
        product: Array | None = None, *, exact: bool = False,
    ) -> Fit:  # fmt: skip
        """Return the fit from a point.

        Args:
            moved: nuisances in their deviations, (m,).
            sizes: of each effect.
            columns: of the nuisances and of all effects but the last one, made nearby, (rows, m + ...) of each run: a
                quick fit along these, to see which deserves a whole one. None: made where the fit is.
            product: of these columns, J^T J over all runs, where it is known.
            exact: make the columns of the fit where it ends, whether or not those that led there would do.
        """
        x = self._at(moved, sizes)
        (score, x, r), J, fresh, made = descended(self, x, columns, product)
        H, slope = normal(J, r, x, self.weight, product)
        if exact or float((x - made) @ (H + np.diag(self.weight)) @ (x - made)) > _NEAR**2:
            J = fresh if np.array_equal(x, made) else self.made(x, r, columns)
            H, slope = normal(J, r, x, self.weight, product)
        H += np.eye(len(x))
        _, log_det = np.linalg.slogdet(H)
        inverse = np.linalg.inv(H)[:, len(moved) :]
        spread = np.sqrt(np.diag(inverse[len(moved) :]))
        pressed = np.abs(slope @ inverse) / spread  # nothing where no end is in the way
        unsteady, by_chance = self._unsteady(r, [each @ inverse for each in J])
        spread = spread * np.sqrt(np.maximum(unsteady / by_chance, 1.0))
        return Fit(
            effects=self._refined(x, spread, pressed), values=self._values(x), moved=x[: len(moved)].copy(),
            log_evidence=score - 0.5 * float(log_det), scatter=self._scatter(x, r, J, H), columns=tuple(J),
        )  # fmt: skip

    def most_likely(
        self, moved: Array, sizes: Sequence[tuple[float, ...]], nearby: Columns | None = None
    ) -> tuple[Array, list[tuple[float, ...]], Columns]:  # fmt: skip
        """Return (nuisances, sizes, columns) about where the fit from a point ends, without how sure they are; nearby:
        see `descended`."""
        found = descended(self, self._at(moved, sizes), nearby=nearby, rough=rules.ROUGH)
        x = found.end[1]
        return x[: len(moved)].copy(), self._sizes(x), found.columns

    def _at(self, moved: Array, sizes: Sequence[tuple[float, ...]]) -> Array:
        """Return the unknowns of a point in their deviations, within their ranges."""
        return self.held(np.concatenate((moved, [s / d for s, d in zip(_flat(sizes), self._scale, strict=True)])))

    def score(self, moved: Array, sizes: Sequence[tuple[float, ...]]) -> float:
        """Return the log likelihood at a point, priors included."""
        return self.scored(self._at(moved, sizes))[1]

    def score_of(self, k: int, moved: Array, sizes: Sequence[tuple[float, ...]]) -> float:
        """Return the log likelihood of one recording at a point."""
        r = self._residual(k, self._at(moved, sizes))
        return -0.5 * float(r @ r)

    def columns(self, moved: Array, sizes: Sequence[tuple[float, ...]]) -> tuple[NDArray[np.float32], ...]:
        """Return the columns of all unknowns at a point, (rows, m + ...) of each run."""
        x = self._at(moved, sizes)
        return tuple(self.made(x, self.scored(x)[0], ()))

    def resized(
        self, moved: Array, sizes: Sequence[tuple[float, ...]]
    ) -> tuple[Array, list[tuple[float, ...]]]:  # fmt: skip
        """Return the point with that share of the last effect's sizes, up to twice them, that is most likely."""

        def at(share: float) -> list[tuple[float, ...]]:
            return [*sizes[:-1], tuple(share * s for s in sizes[-1])]

        best = minimize_scalar(
            lambda share: -self.score(moved, at(share)), bounds=(0.0, 2.0), method="bounded", options=_COARSELY
        )
        return moved, at(float(best.x))

    def grid_start(self, moved: Array, sizes: Sequence[tuple[float, ...]]) -> tuple[float, ...]:
        """Return where the last effect begins that is a switch or has no finite neutral value; the others are given."""
        if self.effects[-1].switch:
            return ()
        return max(((s,) for s in self.effects[-1].grid), key=lambda s: self.score(moved, [*sizes, s]))

    @cached_property
    def _late(self) -> list[int]:
        """Places of nuisances that are times."""
        return [j for j, key in enumerate(self.nuisances) if key[0] == "late"]

    @cached_property
    def _replaced(self) -> list[int]:
        """Places of what sensors are off where an effect that is on says it."""
        on = {("sensor", h.effect, h.sensor, h.axis) for h in self.effects}
        return [j for j, key in enumerate(self.nuisances) if key in on]

    @property
    def _scale(self) -> list[float]:
        return [d for h in self.effects for d in h.scale]

    @property
    def weight(self) -> Array:
        """Inverse variances of the unknowns in their deviations, (n,): 0 of a size without a finite neutral value."""
        own = [0.0 if h.grid else 1.0 for h in self.effects for _ in h.scale]
        return np.concatenate((np.ones(len(self.nuisances)), own))

    def held(self, x: Array) -> Array:
        """Return a point whose sizes are within their ranges, and whose stamps are as late as loops and buses are.

        What a sensor is off is all the effect's where that is on: else it would be known no better than a healthy one.
        """
        m, x = len(self.nuisances), x.copy()
        x[self._late] = np.clip(x[self._late], -rules.LATEST, rules.LATEST)
        x[self._replaced] = 0.0
        lower = [v for h in self.effects for v in h.lower]
        upper = [v for h in self.effects for v in h.upper]
        scale = np.array(self._scale)
        x[m:] = np.clip(x[m:] * scale, lower, upper) / scale
        return x

    def _values(self, x: Array) -> dict[Key, float]:
        return in_units(x, self.nuisances)

    def _sizes(self, x: Array) -> list[tuple[float, ...]]:
        at, out = len(self.nuisances), []
        for h in self.effects:
            out.append(tuple(float(v) * d for v, d in zip(x[at:], h.scale, strict=False)))
            at += len(h.scale)
        return out

    def _refined(self, x: Array, spread: Array, pressed: Array) -> tuple[Refined, ...]:
        at, out = 0, []
        for h, sizes in zip(self.effects, self._sizes(x), strict=True):
            timing = [self._timing(h.units[p]) for p in h.parameters]
            own = tuple(float(np.hypot(v * d, t)) for v, d, t in zip(spread[at:], h.scale, timing, strict=False))
            size, ends = sizes[0] if sizes else 0.0, (*h.lower[:1], *h.upper[:1])
            held = size != 0.0 and np.isclose(size, ends, rtol=1e-6, atol=0.0).any()
            asks = float(pressed[at]) if held else 0.0
            out.append(Refined(hypothesis=h, sizes=sizes, deviations=own, pressed=asks))
            at += len(h.scale)
        return tuple(out)

    def _timing(self, unit: str) -> float:
        """Return how much of a size in this unit is within what stamps are unsure of."""
        if unit == "s/s":
            return rules.TIMING / max(run.log.count * run.log.period for run in self.screen.runs)
        return rules.TIMING if unit == "s" else 0.0

    def _residual(self, k: int, x: Array, on: Sequence[ActiveVehicleEffect] | None = None) -> Array:
        """Return whitened innovations of run k, flat; where there is no such model, those of a filter that is lost; on:
        the effects, if not those of the point."""
        found = self._innovations(k, x, on)
        return np.full(self.screen.residual(k).size, LOST) if found is None else found

    def _innovations(
        self, k: int, x: Array, on: Sequence[ActiveVehicleEffect] | None = None, *, coarse: bool = False
    ) -> Array | None:
        """Return whitened innovations of run k, flat; None: there is no such model; coarse: see `filtered`."""
        active = self._active(x) if on is None else on
        found = self.screen.at(k, self._values(x), active, coarse=coarse)
        return None if found is None else np.nan_to_num(found).ravel()

    def _active(self, x: Array) -> list[ActiveVehicleEffect]:
        """Return the effects of a point."""
        return [h.active(s) for h, s in zip(self.effects, self._sizes(x), strict=True)]

    def scored(self, x: Array) -> tuple[list[Array], float]:
        """Return innovations (rows,) of each run and the log likelihood at a point, priors included."""
        at = x.tobytes()
        if at not in self._points:
            r = side_by_side(lambda k: self._residual(k, x), range(len(self.screen.runs)))
            score = -0.5 * sum(float(each @ each) for each in r) - 0.5 * float(self.weight @ x**2)
            _keep(self._points, at, (r, score), _KEPT_POINTS)
        return self._points[at]

    def made(self, x: Array, r: list[Array], known: Sequence[NDArray[np.float32]]) -> Columns:
        """Return the columns of all unknowns at a point; `known`: those of the first ones, taken as they are."""
        if known:
            return self._new_columns(x, r, known)
        at = x.tobytes()
        if at not in self._made:
            _keep(self._made, at, self._new_columns(x, r, ()), _KEPT_COLUMNS)
        return self._made[at]

    def _new_columns(
        self, x: Array, r: list[Array], known: Sequence[NDArray[np.float32]]
    ) -> Columns:  # fmt: skip
        of_sizes = [_STEP_OF_PROBE * p / s for h in self.effects for p, s in zip(h.probe, h.scale, strict=True)]
        steps = np.concatenate((np.full(len(self.nuisances), _STEP), of_sizes))
        keys = list(self.nuisances)
        first = known[0].shape[1] if known else 0
        out = []
        for k, each in enumerate(r):
            J = np.zeros((each.size, len(x)), dtype=np.float32, order="F")
            here = self._innovations(k, x, coarse=True)
            here = each if here is None else here
            if known:
                J[:, :first] = known[k]

            sums = {j: of for j, key in enumerate(keys[first:], first) if (of := sum_of(key, k, self.nuisances))}

            def fill(j: int, k: int = k, here: Array = here, J: NDArray[np.float32] = J) -> None:
                for step in (steps[j], -steps[j]):
                    there = x.copy()
                    there[j] += step
                    there = self.held(there)
                    moved = there[j] - x[j]
                    if abs(moved) <= 0.5 * abs(step):
                        continue
                    found = self._innovations(k, there, coarse=True)
                    if found is not None:
                        J[:, j] = (found - here) / moved
                        break

            alone = [j for j in range(first, len(x)) if j >= len(keys) or (acts_in(keys[j], k) and j not in sums)]
            side_by_side(fill, alone)
            for j, of in sums.items():
                J[:, j] = sum(share * J[:, keys.index(key)] for key, share in of.items())
            out.append(J)
        return out

    def _scatter(self, x: Array, r: Sequence[Array], J: Sequence[NDArray[np.float32]], H: Array) -> float:
        """Return the variance of block scores of the last effect's columns over the expected one; see `Gram.scatter`.

        The numbers r are those with the effect on: where it explains them, its scores scatter by chance alone. Of one
        that begins in mid-run they are those that it would have if it were there all along: the last seconds of a
        recording tell too little of how scores scatter. H: 1 and the product of the columns.
        """
        if not self.effects:
            return 1.0
        h = self.effects[-1]
        rest = len(x) - len(h.scale) if h.since is None else len(x)
        if rest < len(x):
            own, B = [each[:, rest:] for each in J], H[:rest, rest:]
        else:
            on = self._active(x)
            other = on[:-1] if h.since is None else [*on, replace(h, since=None).active(h.probe)]
            moved = [self._residual(k, x, other) for k in range(len(r))]
            own = [(a - b)[:, None].astype(np.float32) for a, b in zip(r, moved, strict=True)]
            B = np.asarray(sum(a[:, :rest].T @ b for a, b in zip(J, own, strict=True)))
        shadow = np.linalg.solve(H[:rest, :rest], B).astype(np.float32)
        found, _ = self._unsteady(r, [b - a[:, :rest] @ shadow for a, b in zip(J, own, strict=True)])
        return max(float(np.mean(found)), 1.0)

    def _unsteady(self, r: Sequence[Array], freed: Sequence[Array]) -> tuple[Array, float]:
        """Return the variance of block scores of columns freed of all others over the expected one, (n,), and what that
        is once in twenty by chance."""
        width = round(rules.BLOCK / self.screen.runs[0].log.period) * self.screen.residual(0).shape[1]
        scores, squares = [], []
        for v, residual in zip(freed, r, strict=True):
            edges = np.arange(0, len(v), width)
            scores.append(np.add.reduceat(v * residual[:, None], edges))
            squares.append(np.add.reduceat(v * v, edges))
        s, q = np.concatenate(scores), np.concatenate(squares)
        total = q.sum(axis=0)
        around = ((s - s.sum(axis=0) / np.maximum(total, 1e-30) * q) ** 2).sum(axis=0)
        return around / np.maximum(total, 1e-30), float(chi2.ppf(0.95, len(s)) / len(s))


def _keep(kept: dict[bytes, Any], at: bytes, value: Any, most: int) -> None:
    """Add what was found at a point to what is kept; the oldest goes."""
    kept[at] = value
    if len(kept) > most:
        del kept[next(iter(kept))]


def _flat(sizes: Sequence[tuple[float, ...]]) -> list[float]:
    return [s for each in sizes for s in each]
