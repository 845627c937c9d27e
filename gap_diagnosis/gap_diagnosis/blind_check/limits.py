"""Detection limits of the effects in a blind check; late stamps have one for each channel."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gap_diagnosis.blind_check.catalogue import EFFECTS, Kind
from gap_diagnosis.blind_check.judging import is_named, size_of, size_parameter
from gap_diagnosis.blind_check.statistics import Limit, detection_limit, limit_without

__all__ = [
    "LIMIT_TARGETS",
    "STANDARD",
    "detection_limits",
    "kind_of_limit",
    "limit_name",
    "limits_without_own",
    "never_found",
    "sizes_above",
    "sizes_above_targets",
]

Key = Mapping[str, Any]
Case = tuple[Key, Mapping[str, Any]]

STANDARD = ("effect", "sweep")
"""Kinds of case from which limits are found: one effect, the standard campaign."""
LIMIT_TARGETS = {
    "log_alignment (speed)": (0.01, "s"),
    "log_alignment (flow)": (0.07, "s"),
    "command_delay": (0.02, "s"),
    "command_lag": (0.03, "s"),
    "supply_sag": (0.08, ""),
    "coulomb_friction": (40.0, "rad/s²"),
    "thrust_asymmetry": (0.07, ""),
    "cavitation": (0.08, ""),
    "tach_lag": (0.03, "s"),
    "flow_delay": (0.25, "s"),
    "flow_bias": (0.02, "m/s"),
    "load_cell_bias": (0.3, "N"),
    "throttle_gain": (0.13, ""),
    "thrust_loss": (0.17, ""),
    "dead_zone_shift": (0.13, "V"),
}
"""What limits should be at most, and their units, by the limit's name."""


def limit_name(key: Key, name: str) -> str:
    """Return the name of the limit that concerns an effect of a case."""
    return f"{name} ({size_parameter(key, name)})" if name == "log_alignment" else name


def kind_of_limit(name: str) -> Kind:
    """Return the effect of a limit."""
    return EFFECTS[name.split()[0]]


def detection_limits(cases: Sequence[Case], rng: np.random.Generator) -> dict[str, Limit]:
    """Return the limits by name from pairs (key, diagnosis); `rng` is that of the bootstrap."""
    tried = _tried(cases)
    ordered = sorted(tried, key=lambda name: (list(EFFECTS).index(name.split()[0]), name))
    return {
        name: detection_limit(
            [size for _, size, _ in tried[name]],
            [named for _, _, named in tried[name]],
            rng,
            falls=kind_of_limit(name).size.falls,
        )
        for name in ordered
    }


def limits_without_own(cases: Sequence[Case], limits: Mapping[str, Limit]) -> list[dict[str, float]]:
    """Return for each case the values of the limits that all other cases give: none decides about itself.

    `limits`: those that all cases together give.
    """
    result = [{name: limit.value for name, limit in limits.items()} for _ in cases]
    for name, rows in _tried(cases).items():
        sizes, named = ([row[k] for row in rows] for k in (1, 2))
        for left_out, (place, *_) in enumerate(rows):
            result[place][name] = limit_without(sizes, named, left_out, falls=kind_of_limit(name).size.falls)
    return result


def _tried(cases: Sequence[Case]) -> dict[str, list[tuple[int, float, bool]]]:
    """Return by limit (place of the case, size, whether it was named); effects of one size only have no limit."""
    tried: dict[str, list[tuple[int, float, bool]]] = {}
    for place, (key, diagnosis) in enumerate(cases):
        for name in key["effects"] if key["kind"] in STANDARD else ():
            limit = limit_name(key, name)
            if kind_of_limit(limit).size.lower < kind_of_limit(limit).size.upper:
                tried.setdefault(limit, []).append((place, size_of(key, name), is_named(key, name, diagnosis)))
    return tried


def sizes_above(key: Key, limits: Mapping[str, float]) -> bool:
    """Return whether all known effects of a case are above these limits (true for a case without)."""
    return all(_beyond(key, name, limits[limit_name(key, name)]) for name in _limited(key, limits))


def sizes_above_targets(key: Key) -> bool:
    """Return whether a case has effects with a target for their limit, all of them above it."""
    targets = {name: value for name, (value, _) in LIMIT_TARGETS.items()}
    return bool(key["effects"]) and len(_limited(key, targets)) == len(key["effects"]) and sizes_above(key, targets)


def _limited(key: Key, limits: Mapping[str, float]) -> list[str]:
    return [name for name in key["effects"] if limit_name(key, name) in limits]


def _beyond(key: Key, name: str, limit: float) -> bool:
    size = abs(size_of(key, name))
    return size <= limit if EFFECTS[name].size.falls else size >= limit


def never_found(name: str, limit: Limit) -> bool:
    """Return whether the limit lies beyond the sizes tried."""
    return limit.value == (0.0 if kind_of_limit(name).size.falls else np.inf)
