"""The parts of a vector of a topic, where all of them were told, and whether an attitude is one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..topic import Topic
from .sources import Array

__all__ = ["attitude_moves", "vector_of"]


def vector_of(topic: Topic | None, head: str, parts: Sequence[str]) -> tuple[Array, Array] | None:
    """Return when all these parts of a field were told [s], and what (N, parts); None where that was not twice."""
    names = [f"{head}.{part}" if part else head for part in parts]
    if topic is None or not all(name in topic.fields for name in names):
        return None
    values = np.column_stack([np.asarray(topic.fields[name], dtype=np.float64) for name in names])
    there = np.isfinite(values).all(axis=1)
    return (np.asarray(topic.stamps)[there] * 1e-9, values[there]) if there.sum() > 1 else None


def attitude_moves(q: Array) -> bool:
    """Tell whether attitudes (N, 4) are told at all, of length 1, and ever change: a driver that measures none writes
    one all the time."""
    return bool(np.abs(np.linalg.norm(q, axis=1) - 1.0).max(initial=0.0) < 0.1 and np.ptp(q, axis=0).any())
