"""Which hypothesis comes nearest, and how much of the gap it explains."""

import numpy as np

from gap_diagnosis.candidate import Candidate
from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.investigation import Investigation

__all__ = ["best_of", "share_explained"]


def best_of(diagnosis: Diagnosis) -> Candidate | None:
    """Return the hypothesis after which it is asked what stays unexplained; None where nothing was weighed."""
    if diagnosis.investigation is None:
        return None
    if diagnosis.verdict.verdict in ("no_gap", "parameters"):
        return diagnosis.investigation.none
    if diagnosis.verdict.verdict == "unknown":
        return _nearest(diagnosis.investigation)
    chosen = diagnosis.verdict.chosen or (diagnosis.posterior.leading if diagnosis.posterior else None)
    return chosen or diagnosis.investigation.none


def _nearest(found: Investigation) -> Candidate:
    """Return the effects that are the most probable with something unknown beside them; none where none was weighed."""
    most, nearest = -np.inf, found.none
    for candidate in found.candidates:
        beside = candidate.unexplained.evidence if candidate.unexplained is not None else 0.0
        if (candidate.unexplained is not None or candidate.pressed) and candidate.evidence + beside > most:
            most, nearest = candidate.evidence + beside, candidate
    return nearest


def share_explained(candidate: Candidate, none: Candidate) -> float:
    """Return which share of the cost beyond the noise a hypothesis takes off; `none`: without effects, same noise.

    Beyond the noise lies what is left above a unit a sample, and at least what functions of states and inputs explain.
    """
    cost = candidate.fitted.cost
    gained = max(none.fitted.cost - cost, 0.0)
    depends = sum(each.gain for each in candidate.unexplained.features) if candidate.unexplained is not None else 0.0
    left = max(cost - float(np.sum(candidate.fitted.problem.known)), depends)
    return gained / (gained + left) if gained > 0.0 else 0.0
