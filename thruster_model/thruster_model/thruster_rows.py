"""The coefficients or effects of several thrusters as one table, for kernels that go through them in a loop.

A tuple of N `ThrusterCoefficients` is N times 28 numbers that a kernel would hand from function to function. Here they
are rows of one array, and `thruster(rows, i)` is the tuple of thruster i again, of the same class: its equations do not
notice.
"""

from collections import namedtuple
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numba.extending import overload

__all__ = ["ThrusterRows", "rows_of", "thruster"]


class ThrusterRows(NamedTuple):
    """values: (N, F), one column per number; arrays: of all thrusters, stacked (N, ...); kind: their class."""

    values: Any
    arrays: Any
    kind: Any


class _Kind(NamedTuple):
    marker: Any
    build: Callable[..., Any]


_MARKERS: dict[str, type] = {}
_KINDS: dict[tuple[type, tuple[str, ...]], _Kind] = {}
_BUILDERS: dict[type, Callable[..., Any]] = {}


def __getattr__(name: str) -> type:
    """Return a marker by its name: the cache of compiled kernels names the types of their arguments so."""
    if not name.startswith("Kind"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return _marker(name)


def _marker(name: str) -> type:
    """Return the class that stands for a class of coefficients in the types of kernels.

    The same one for a name wherever it is asked for: a marker that a cache could not find again by module and name
    would be another type in each process, and each process would compile every kernel anew.
    """
    if name not in _MARKERS:
        _MARKERS[name] = namedtuple(name, ("nothing",), module=__name__)  # type: ignore[misc]
    return _MARKERS[name]


def rows_of(thrusters: Sequence[Any]) -> ThrusterRows:
    """Return the rows of named tuples of one class; ValueError where they differ in class or in the size of tables."""
    classes = {type(each).__name__ for each in thrusters}
    if len(classes) != 1:
        raise ValueError(f"expected thrusters of one class; found {', '.join(sorted(classes)) or 'none'}")
    first = thrusters[0]
    stacked = tuple(name for name in first._fields if np.ndim(getattr(first, name)) > 0)
    numbers = [name for name in first._fields if name not in stacked]
    for name in stacked:
        sizes = {np.shape(getattr(each, name)) for each in thrusters}
        if len(sizes) != 1:
            raise ValueError(f"expected tables of one size for all thrusters; found {name} of {sorted(sizes)}")
    values = np.array([[getattr(each, name) for name in numbers] for each in thrusters], dtype=np.float64)
    arrays = tuple(np.array([getattr(each, name) for each in thrusters], dtype=np.float64) for name in stacked)
    return ThrusterRows(values, arrays, _kind_of(type(first), stacked).marker(0.0))


def thruster(rows: ThrusterRows, i: int) -> Any:
    """Return the named tuple of thruster i."""
    return _BUILDERS[type(rows.kind)](rows, i)


@overload(thruster, inline="always")
def _compile_thruster(rows, i):  # type: ignore[no-untyped-def]
    build = _BUILDERS[rows.types[2].instance_class]
    return build


def _kind_of(kind: type, stacked: tuple[str, ...]) -> _Kind:
    if (kind, stacked) not in _KINDS:
        marker = _marker("_".join((f"Kind{kind.__name__}", *stacked)))
        column, array, terms = 0, 0, []
        for name in kind._fields:  # type: ignore[attr-defined]
            if name in stacked:
                terms.append(f"rows.arrays[{array}][i]")
                array += 1
            else:
                terms.append(f"rows.values[i, {column}]")
                column += 1
        namespace: dict[str, Any] = {"kind": kind}
        exec(f"def build(rows, i):\n    return kind({', '.join(terms)})", namespace)
        _KINDS[kind, stacked] = _Kind(marker, namespace["build"])
        _BUILDERS[marker] = namespace["build"]
    return _KINDS[kind, stacked]
