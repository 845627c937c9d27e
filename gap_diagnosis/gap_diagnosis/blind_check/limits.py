"""Detection limits of the effects in a blind check; late stamps have one for each channel."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from gap_diagnosis.blind_check.catalogue import EFFECTS, Kind
from gap_diagnosis.blind_check.judging import is_named, size_of, size_parameter
from gap_diagnosis.blind_check.statistics import Limit, detection_limit

__all__ = ["STANDARD", "detection_limits", "kind_of_limit", "limit_name", "never_found", "sizes_above"]

Key = Mapping[str, Any]

STANDARD = ("effect", "sweep")
"""Kinds of case from which limits are found: one effect, the standard campaign."""


def limit_name(key: Key, name: str) -> str:
    """Return the name of the limit that concerns an effect of a case."""
    return f"{name} ({size_parameter(key, name)})" if name == "log_alignment" else name


def kind_of_limit(name: str) -> Kind:
    """Return the effect of a limit."""
    return EFFECTS[name.split()[0]]


def detection_limits(cases: Iterable[tuple[Key, Mapping[str, Any]]], rng: np.random.Generator) -> dict[str, Limit]:
    """Return the limits by name from pairs (key, diagnosis); `rng` is that of the bootstrap."""
    found: dict[str, list[tuple[float, bool]]] = {}
    for key, diagnosis in cases:
        if key["kind"] in STANDARD:
            for name in key["effects"]:
                sized = (size_of(key, name), is_named(key, name, diagnosis))
                found.setdefault(limit_name(key, name), []).append(sized)
    ordered = sorted(found, key=lambda name: (list(EFFECTS).index(name.split()[0]), name))
    return {
        name: detection_limit(
            [size for size, _ in found[name]],
            [named for _, named in found[name]],
            rng,
            falls=kind_of_limit(name).size.falls,
        )
        for name in ordered
        if kind_of_limit(name).size.lower < kind_of_limit(name).size.upper
    }


def sizes_above(key: Key, limits: Mapping[str, Limit]) -> bool:
    """Return whether all known effects of a case are above their limits (true for a case without)."""
    for name in key["effects"]:
        limit = limits.get(limit_name(key, name))
        if limit is not None:
            size = abs(size_of(key, name))
            if (size > limit.value) if EFFECTS[name].size.falls else (size < limit.value):
                return False
    return True


def never_found(name: str, limit: Limit) -> bool:
    """Return whether the limit lies beyond the sizes tried."""
    return limit.value == (0.0 if kind_of_limit(name).size.falls else np.inf)
