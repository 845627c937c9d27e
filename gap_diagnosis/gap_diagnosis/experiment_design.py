"""The next throttle experiment: of many programmes the one that tells the remaining hypotheses apart best.

With y_a, y_b the whitened predictions of two hypotheses for an experiment, S_b the whitened sensitivities of the second
one and P_b the covariance of its unknowns after the present recordings (clocks and rest values of the new one:
as uncertain as ever), the distance that is left once b has been re-tuned to first order is

    D^2 = min over z of |y_a - y_b - S_b z|^2 + z' P_b^-1 z = d'd - d'J (I + J'J)^-1 J'd,   d = y_a - y_b, J J' = S P S'

in standard deviations; of the two ways round the smaller counts. The programme chosen has the largest smallest
distance (max-min); pairs that no programme separates do not count. Twins, which act alike by what they are, are no pair
for any programme, whatever their distance where one of them is at the end of its range.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.experiment_inputs import Limits, Programme, programmes
from gap_diagnosis.experiment_rivals import Rival, in_experiment, recording_of_programme, rivals_of
from gap_diagnosis.experiment_words import SURE, as_sentence, inseparable_in_words
from system_identification.noise import Whitener, white_noise

__all__ = ["NextExperiment", "Separation", "design", "distances"]

Array = NDArray[np.float64]
INSEPARABLE = 0.3
"""Standard deviations below which no repetition of an experiment would tell two hypotheses apart."""
_WEIGHED = 40
_OF_EACH_KIND = 2


@dataclass(frozen=True, kw_only=True)
class Separation:
    """Two hypotheses and how far apart they are: in the next experiment and in the present recordings [std]."""

    candidates: tuple[str, str]
    distance: float
    distance_now: float


@dataclass(frozen=True, kw_only=True)
class NextExperiment:
    """The next experiment.

    Attributes:
        programme: what is played; None where no throttle experiment would tell anything.
        separates: pairs of hypotheses that it tells apart.
        inseparable: a sentence for each pair that no throttle experiment tells apart.
        sentence: all that in words.
        seed, count: of the programmes among which it was chosen.
    """

    programme: Programme | None
    separates: tuple[Separation, ...]
    inseparable: tuple[str, ...]
    sentence: str
    seed: int
    count: int


def design(
    found: Diagnosis, *, duration: float, period: float, largest: float, count: int = 200, seed: int = 0
) -> NextExperiment | None:
    """Return the next experiment; None where there is nothing to tell apart that these recordings do not tell.

    Args:
        found: the diagnosis of the present recordings.
        duration: of the experiment [s].
        period: of its commands [s].
        largest: magnitude of its throttle [V].
        count: programmes among which it is chosen.
        seed: of these.

    Raises:
        ValueError: a limit that is no limit.
    """
    values = found.parameter_set.values
    limits = Limits(
        largest=largest,
        rate=values.get("u_dot_max", np.inf) if values.get("u_dot_max", 0.0) > 0.0 else 100.0,
        duration=duration,
        period=period,
        dead_zone=(values.get("delta_u1", 0.0), values.get("delta_u2", 0.0)),
    )
    rivals, pairs = rivals_of(found)
    if not pairs or found.investigation is None:
        return None
    twins = tuple(
        inseparable_in_words(rivals[i].keys, rivals[k].keys) for i, k in pairs if rivals[i].is_twin_of(rivals[k])
    )
    pairs = [(i, k) for i, k in pairs if not rivals[i].is_twin_of(rivals[k])]
    noise = {name: found.investigation.noise.level(name) for name in found.investigation.noise.levels.sensors}
    with threadpool_limits(1):  # the matrices are tall and thin: threads only wait for each other
        apart_now = {(i, k): _distance_now(rivals[i], rivals[k], found.investigation.noise) for i, k in pairs}
        pairs = [pair for pair in pairs if apart_now[pair] < SURE]
        if not pairs:
            return _only_twins(twins, seed, count) if twins else None
        now = [apart_now[pair] for pair in pairs]
        chosen, apart = _chosen(programmes(limits, count=count, seed=seed), rivals, pairs, noise)
    names = [(rivals[i].name, rivals[k].name) for i, k in pairs]
    separable = apart.max(axis=0) >= INSEPARABLE
    separates = tuple(
        Separation(candidates=names[place], distance=float(apart[chosen[0], place]), distance_now=now[place])
        for place in np.flatnonzero(separable)
    )
    inseparable = twins + tuple(
        inseparable_in_words(rivals[i].keys, rivals[k].keys)
        for (i, k), possible in zip(pairs, separable, strict=True)
        if not possible
    )
    programme = chosen[1] if separates else None
    return NextExperiment(
        programme=programme,
        separates=separates,
        inseparable=inseparable,
        sentence=as_sentence(programme, [(s.candidates, s.distance, s.distance_now) for s in separates], inseparable),
        seed=seed,
        count=count,
    )


def _only_twins(sentences: tuple[str, ...], seed: int, count: int) -> NextExperiment:
    """Return that there is no programme, as only twins are left, and what would tell them apart."""
    return NextExperiment(
        programme=None, separates=(), inseparable=sentences, sentence=as_sentence(None, [], sentences), seed=seed,
        count=count,
    )  # fmt: skip


def _chosen(
    tried: Sequence[Programme], rivals: Sequence[Rival], pairs: Sequence[tuple[int, int]], noise: Mapping[str, float]
) -> tuple[tuple[int, Programme], Array]:
    """Return (place and programme chosen, distances (weighed programmes, pairs)).

    Without any re-tuning first; of these distances the most promising programmes, some of each kind, are weighed.
    """
    first = np.array([_raw(programme, rivals, pairs, noise) for programme in tried])
    order = np.argsort(-np.min(first / np.maximum(first.max(axis=0), 1e-12), axis=1))
    by_kind: dict[str, list[int]] = {}
    for place in order:
        by_kind.setdefault(tried[place].kind, []).append(int(place))
    some = [place for places in by_kind.values() for place in places[:_OF_EACH_KIND]]
    weighed = list(dict.fromkeys([*some, *(int(place) for place in order)]))[: max(_WEIGHED, len(some))]
    apart = np.array([distances(tried[place], rivals, pairs, noise) for place in weighed])
    counting = apart.max(axis=0) >= INSEPARABLE
    best = int(np.argmax(np.min(apart[:, counting], axis=1))) if np.any(counting) else 0
    return (best, tried[weighed[best]]), apart


def _raw(
    programme: Programme, rivals: Sequence[Rival], pairs: Sequence[tuple[int, int]], noise: Mapping[str, float]
) -> list[float]:
    recording = recording_of_programme(rivals[0].problem, programme)
    posed = [in_experiment(rival, recording) for rival in rivals]
    plain = white_noise(posed[0][0], noise)
    white = [plain.whiten(problem.predicted(x)) for problem, x, _ in posed]
    return [float(np.linalg.norm(white[i] - white[k])) for i, k in pairs]


def distances(
    programme: Programme, rivals: Sequence[Rival], pairs: Sequence[tuple[int, int]], noise: Mapping[str, float]
) -> list[float]:
    """Return how far apart pairs of hypotheses would be in an experiment, re-tuned [std]."""
    recording = recording_of_programme(rivals[0].problem, programme)
    posed = [in_experiment(rival, recording) for rival in rivals]
    plain = white_noise(posed[0][0], noise)
    white = [plain.whiten(problem.predicted(x)) for problem, x, _ in posed]
    able = {b for i, k in pairs for a, b in ((i, k), (k, i)) if rivals[b].imitates(rivals[a])}
    moves = {}
    for place in able:
        problem, x, root = posed[place]
        moves[place] = plain.whiten(problem.sensitivities(x)) @ root
    return [
        min(
            _left(white[a] - white[b], moves[b])
            for a, b in ((i, k), (k, i))
            if b in moves and rivals[b].imitates(rivals[a])
        )
        for i, k in pairs
    ]


def _distance_now(first: Rival, second: Rival, noise: Whitener) -> float:
    """Return how far apart two hypotheses are in the present recordings, re-tuned, priors included [std]."""
    white = []
    for rival in (first, second):
        white.append(noise.whiten(rival.problem.predicted(rival.x)))
    found = []
    for imitator, truth, difference in ((second, first, white[0] - white[1]), (first, second, white[1] - white[0])):
        if imitator.imitates(truth):
            prior = imitator.fitted.prior
            jacobian = noise.whiten(imitator.fitted.sensitivities)
            weight = np.full(jacobian.shape[1], 12.0)  # a size is as uncertain as its range
            weight[: prior.size] = prior
            pull = jacobian.T @ difference
            pull[: prior.size] -= prior * imitator.x[: prior.size]
            gained = pull @ np.linalg.solve(jacobian.T @ jacobian + np.diag(weight), pull)
            own, other = (float(prior @ r.x[: prior.size] ** 2) for r in (imitator, truth))
            found.append(np.sqrt(max(float(difference @ difference + own - gained - other), 0.0)))
    return float(max(found))  # the one that the recordings speak for is the truth


def _left(difference: Array, moves: Array) -> float:
    """Return the norm of a whitened difference (R,) that moves (R, K) of unit variance each leave."""
    projected = moves.T @ difference
    inner = np.eye(moves.shape[1]) + moves.T @ moves
    squared = float(difference @ difference - projected @ np.linalg.solve(inner, projected))
    return float(np.sqrt(max(squared, 0.0)))
