"""What the engine needs to know of a system: a simulator with unknowns, and recordings of the real one.

Unknowns x, shape (K,): first the nuisances (parameters, what else all runs share, what is particular to a run), each
over its standard deviation and with a normal prior; then the sizes of effects, each over the width of its plausible
range. Rows, shape (R,): all samples of all signals in all runs, in the signals' units; NaN where nothing counts.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["Linear", "Series", "SizeSlot", "System"]

Array = NDArray[np.float64]


class Series(NamedTuple):
    """Where the samples of one signal of one run stand among all rows."""

    recording: int
    signal: str
    first: int
    last: int

    @property
    def rows(self) -> slice:
        """Of the vector of all rows."""
        return slice(self.first, self.last)


class SizeSlot(NamedTuple):
    """One unknown size of an effect, its plausible range and its unit."""

    effect: str
    parameter: str
    lower: float
    upper: float
    unit: str = ""

    @property
    def width(self) -> float:
        """Of the range; 1 where the size has only one value."""
        return (self.upper - self.lower) or 1.0


class Linear(NamedTuple):
    """One run, linearised along its simulation at N instants `dt` apart, m states and q disturbances.

    Attributes:
        dt: time between the instants [s].
        transition: of the states over `dt`, shape (N, m, m).
        push: what a rate held over `dt` does to the states, by disturbance, shape (N, m, q).
        unforeseen: variances that the states gain over `dt` by what nothing foretells, shape (N, m).
        rows: of the samples, in the order of time, shape (M,).
        places: at which instant each was taken, or after which it was the first, shape (M,).
        readings: d reading / d state there of each, and d reading / d push since then, shape (M, m) or (M, m + q).
        signals: which of the system's signals each is of, shape (M,).
    """

    dt: float
    transition: Array
    push: Array
    unforeseen: Array
    rows: NDArray[np.int64]
    places: NDArray[np.int64]
    readings: Array
    signals: NDArray[np.int64]


class System(Protocol):
    """A simulator with suspected effects, and what was recorded of the real system."""

    @property
    def slots(self) -> tuple[SizeSlot, ...]:
        """Unknown sizes of the effects that are suspected here."""

    @property
    def nuisances(self) -> int:
        """How many unknowns have a prior."""

    @property
    def parameters(self) -> int:
        """How many of these, the first ones, are parameters that all runs share."""

    @property
    def local(self) -> NDArray[np.bool_]:
        """Which unknowns are particular to a single run, shape (K,)."""

    @property
    def conventions(self) -> NDArray[np.bool_]:
        """Which nuisances are conventions, as of clocks, that differ from run to run, shape (nuisances,)."""

    @property
    def shared_conventions(self) -> NDArray[np.bool_]:
        """Which nuisances are what all runs have in common of these, shape (nuisances,)."""

    @property
    def signal_names(self) -> tuple[str, ...]:
        """Of the signals."""

    @property
    def series(self) -> Sequence[Series]:
        """Where the rows of each signal of each run stand."""

    @property
    def times(self) -> Array:
        """Of all rows on the clocks of their runs [s]."""

    @property
    def measured(self) -> Array:
        """All samples, NaN where they do not count, shape (R,)."""

    @property
    def known(self) -> NDArray[np.bool_]:
        """Which rows count, shape (R,)."""

    @property
    def levels(self) -> dict[str, float]:
        """Standard deviation of each signal's noise by its samples alone."""

    @property
    def single(self) -> dict[str, float]:
        """Standard deviation of the noise of each signal's single readings, where samples are means of several."""

    @property
    def pushed(self) -> tuple[str, ...]:
        """Signal that reads the state itself which a disturbance pushes, of each disturbance."""

    @property
    def spread(self) -> Array:
        """How many times noisier than its signal each row is, shape (R,)."""

    @property
    def jumps(self) -> bool:
        """Whether readings jump where a state passes a threshold."""

    def predicted(self, x: Array) -> Array:
        """Return what the simulator predicts for all rows, shape (R,)."""

    def residuals(self, x: Array) -> Array:
        """Return measured less predicted, NaN where nothing counts, shape (R,)."""

    def sensitivities(self, x: Array, columns: Sequence[int] | None = None) -> Array:
        """Return d predicted / d unknowns, shape (R, K) or those of `columns` alone; NaN where nothing counts."""

    def movable(self) -> NDArray[np.bool_]:
        """Return which unknowns a slope can improve, shape (K,)."""

    def bounded(self, x: Array) -> Array:
        """Return unknowns held inside their ranges."""

    def linear(self, x: Array, apart: Sequence[Array] | None = None) -> list[Linear]:
        """Return the model of each run, linearised along what is simulated for x, or states (N, m) apart from that."""

    def with_effects(self, slots: tuple[SizeSlot, ...], gates: Any = ()) -> "System":
        """Return the same system with unknown sizes of other effects."""

    def tried(self, x: Array, suspect: Any) -> Array:
        """Return the predictions (G, R) with a suspect at each size of its grid beside the effects at x."""
