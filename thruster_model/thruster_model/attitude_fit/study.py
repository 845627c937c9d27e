"""The study of one set of recordings: fitted to all, to all but one, to one alone, and how much each fit explains."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from thruster_model.attitude_fit.fit import AttitudeFit, FitOptions, fit_attitude
from thruster_model.attitude_fit.recording import Recording
from thruster_model.attitude_fit.scores import Share, shares

__all__ = ["Study", "run_study"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Study:
    """What was fitted and explained; everything by recording, in their order.

    Attributes:
        recordings: first those that are fitted, then those that are only predicted.
        together: the fit to all that are fitted.
        fitted: what it explains of those, in free runs from the first sample.
        held: for each recording the fit to all others; empty where one is fitted only.
        predicted: what those explain of the recording left out, in free runs.
        predicted_pieces: the same, begun anew after every piece.
        matrix: what a fit to recording i alone explains of recording j, in free runs, `matrix[i][j]`; of those fitted.
    """

    recordings: tuple[Recording, ...]
    options: FitOptions
    seed: int
    together: AttitudeFit
    fitted: tuple[Share, ...]
    held: tuple[AttitudeFit, ...]
    predicted: tuple[Share, ...]
    predicted_pieces: tuple[Share, ...]
    matrix: tuple[tuple[Share, ...], ...]


def run_study(
    recordings: Sequence[Recording],
    options: FitOptions,
    seed: int,
    only_predicted: Sequence[Recording] = (),
    progress: Callable[[str], None] = lambda _: None,
) -> Study:
    """Return the whole study; `seed` draws the blocks of the intervals."""
    rng = np.random.default_rng(seed)
    progress("fit to all")
    together = fit_attitude(recordings, options)
    held: list[AttitudeFit] = []
    alone: list[AttitudeFit] = []
    for each in recordings:
        others = [other for other in recordings if other is not each]
        if others:
            progress(f"{each.name} left out")
            held.append(fit_attitude(others, options))
        progress(f"{each.name} alone")
        alone.append(fit_attitude([each], options))

    def explained(recording: Recording, fit: AttitudeFit, piece: float | None = None) -> Share:
        return shares(recording, fit.values, piece=piece, rng=rng)

    held += [together] * (len(only_predicted) if held else 0)
    known = (*recordings, *only_predicted)
    pairs = list(zip(known, held, strict=True)) if held else []
    return Study(
        recordings=known,
        options=options,
        seed=seed,
        together=together,
        fitted=tuple(explained(each, together) for each in recordings),
        held=tuple(held),
        predicted=tuple(explained(each, fit) for each, fit in pairs),
        predicted_pieces=tuple(explained(each, fit, options.piece) for each, fit in pairs),
        matrix=tuple(tuple(explained(each, fit) for each in recordings) for fit in alone),
    )
