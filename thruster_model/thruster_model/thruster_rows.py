"""The coefficients or effects of several thrusters as one table, for kernels that go through them in a loop.

A tuple of N `ThrusterCoefficients` is N times 28 numbers that a kernel would hand from function to function. Here they
are rows of one array, and `thruster(rows, i)` is the tuple of thruster i again, of the same class: its equations do not
notice.

A kernel is compiled for the class of the rows, which their `kind` tells: an empty class of its own for each class of
thrusters, made when it is first needed. Another process, which finds the kernel in the cache, has to find the same one:
its name says of what it is made, and this module makes what it is asked for.
"""

import importlib
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


_KINDS: dict[tuple[type, tuple[str, ...]], _Kind] = {}
_BUILDERS: dict[type, Callable[..., Any]] = {}


def rows_of(thrusters: Sequence[Any]) -> ThrusterRows:
    """Return the rows of named tuples of one class; ValueError where they differ in class or in the size of tables."""
    classes = {type(each).__name__ for each in thrusters}
    if len(classes) != 1:
        raise ValueError(f"expected thrusters of one class; found {', '.join(sorted(classes)) or 'none'}")
    first = thrusters[0]
    stacked = tuple(n for n, v in zip(first._fields, first, strict=True) if not isinstance(v, float) and np.ndim(v) > 0)
    numbers = [name for name in first._fields if name not in stacked]
    for name in stacked:
        sizes = {np.shape(getattr(each, name)) for each in thrusters}
        if len(sizes) != 1:
            raise ValueError(f"expected tables of one size for all thrusters; found {name} of {sorted(sizes)}")
    plain = thrusters if not stacked else [[getattr(each, name) for name in numbers] for each in thrusters]
    values = np.array(plain, dtype=np.float64)
    arrays = tuple(np.array([getattr(each, name) for each in thrusters], dtype=np.float64) for name in stacked)
    return ThrusterRows(values, arrays, _kind_of(type(first), stacked).marker(0.0))


def thruster(rows: ThrusterRows, i: int) -> Any:
    """Return the named tuple of thruster i."""
    return _BUILDERS[type(rows.kind)](rows, i)


@overload(thruster, inline="always")
def _compile_thruster(rows, i):  # type: ignore[no-untyped-def]
    build = _BUILDERS[rows.types[2].instance_class]
    return build


def __getattr__(name: str) -> Any:
    """Return the class of that name, for whoever unpickles one."""
    module, *rest = name.replace("/", ".").split("|")
    if not rest:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return _kind_of(getattr(importlib.import_module(module), rest[0]), tuple(rest[1:])).marker


def _kind_of(kind: type, stacked: tuple[str, ...]) -> _Kind:
    if (kind, stacked) not in _KINDS:
        marker: Any = namedtuple("marker", ("nothing",), module=__name__)
        marker.__name__ = marker.__qualname__ = "|".join((kind.__module__, kind.__qualname__, *stacked)).replace(
            ".", "/"
        )
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
