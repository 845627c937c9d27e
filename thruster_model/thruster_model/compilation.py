"""Compile kernels with numba into a cache that notices every change of the equations.

numba's own cache looks at the file of the compiled function only, so a changed callee in another file would go
unseen. Here the cache folder is named after a hash of all source files of the packages that hold equations and is
private to the user: its files are pickles, and who writes them has his code run. A folder that somebody else owns or
may write, or that lies in one, is not used: a private one takes its place, in ~/.cache or else for this process alone.
"""

import atexit
import hashlib
import logging
import os
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar

import numba
from numba.core import cgutils, event, types
from numba.extending import intrinsic, overload, register_jitable

__all__ = ["BARE", "borrowed", "cache_folder", "compiled", "equation", "inlined", "told_of_compiling"]

Function = TypeVar("Function", bound=Callable[..., Any])
BARE = {"no_cfunc_wrapper": True, "no_cpython_wrapper": True}
"""Of equations, which only kernels call when they are compiled: their wrappers are a tenth of the time it takes."""

_PACKAGE = Path(__file__).parent
_LOG = logging.getLogger(__name__)
_KEPT_CACHES = 8
_IN_USE = 3600.0  # s
_cache_folders: dict[frozenset[Path], Path] = {}


def equation(function: Function) -> Function:
    """Mark a function as an equation: plain Python when called from Python, compiled when called from a kernel."""
    return register_jitable(**BARE)(function)  # type: ignore[no-any-return]


def inlined(function: Function) -> Function:
    """Mark an equation that is laid into the code of its caller: many coefficients then stay where they are."""
    return register_jitable(forceinline=True, **BARE)(function)  # type: ignore[no-any-return]


def compiled(function: Function) -> Function:
    """Compile a kernel, cached in a folder that belongs to exactly this state of the equations.

    Kernels are module-level functions: a closure would be compiled again in each process. Python is left to
    other threads while they run.
    """
    folder = cache_folder(*_packages_of(function))
    previous = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(folder)
    try:
        return numba.njit(cache=True, error_model="numpy", nogil=True)(function)  # type: ignore[no-any-return]
    finally:
        numba.config.CACHE_DIR = previous


@contextmanager
def told_of_compiling(told: Callable[[str], None]) -> Iterator[None]:
    """Tell once, within this context, that a kernel begins to compile; those of the cache do not."""
    with event.install_listener("numba:compile", _First(told)):
        yield


class _First(event.Listener):  # type: ignore[misc, unused-ignore]
    """Tells of the first event of its kind."""

    def __init__(self, told: Callable[[str], None]) -> None:
        self._told, self._said = told, False

    def on_start(self, event: Any) -> None:
        if not self._said:
            self._said = True
            self._told("compiling the model, once for as many thrusters: a minute or two, or more beside other work")

    def on_end(self, event: Any) -> None:
        return


def borrowed(values: Any) -> Any:
    """Return arrays, or a tuple of them and of tuples and numbers, that a kernel may use without counting references.

    The caller of the kernel holds them while it runs. Each row that an equation takes of an array would else be counted
    in and out, atomically: of a plant of six thrusters with tables that was four fifths of the time.
    """
    return values


@overload(borrowed)
def _compile_borrowed(values):  # type: ignore[no-untyped-def]
    return lambda values: _without_owner(values)


@intrinsic  # type: ignore[untyped-decorator]
def _without_owner(typing, values):  # type: ignore[no-untyped-def]
    def without(context, builder, kind, value):  # type: ignore[no-untyped-def]
        if isinstance(kind, types.Array):
            array = context.make_array(kind)(context, builder, value)
            array.meminfo = cgutils.get_null_value(array.meminfo.type)
            array.parent = cgutils.get_null_value(array.parent.type)
            return array._getvalue()
        if isinstance(kind, types.BaseTuple):  # type: ignore[attr-defined]
            items = cgutils.unpack_tuple(builder, value)
            return context.make_tuple(
                builder, kind, [without(context, builder, k, v) for k, v in zip(kind, items, strict=True)]
            )
        return value

    return values(values), lambda context, builder, signature, args: without(context, builder, values, args[0])


def cache_folder(*packages: Path) -> Path:
    """Return the cache folder for kernels built from `packages`, made if need be, readable by its owner alone."""
    key = frozenset({_PACKAGE, *packages})
    if key not in _cache_folders:
        parent = _private_parent()
        folder = parent / _sources_hash(key)
        folder.mkdir(exist_ok=True, mode=0o700)
        os.utime(folder)
        _remove_oldest(parent)
        _cache_folders[key] = folder
    return _cache_folders[key]


def _packages_of(function: Callable[..., Any]) -> set[Path]:
    """Return the folders of the packages that hold the function and the functions it calls, directly or not."""
    seen: set[Any] = set()
    waiting: list[Any] = [function]
    while waiting:
        function = waiting.pop()
        if isinstance(function, FunctionType) and function not in seen:
            seen.add(function)
            named = (function.__globals__.get(name) for name in function.__code__.co_names)
            waiting += [getattr(value, "py_func", value) for value in named]
    sources = {Path(found.__code__.co_filename) for found in seen}
    return {_package_root(source) for source in sources if source.is_absolute()}  # generated code has no file


@cache
def _private_parent() -> Path:
    """Return the folder of all caches, made if need be, that nobody but the user can have written into."""
    own = Path.home() / ".cache"
    for root in dict.fromkeys((Path(os.environ.get("XDG_CACHE_HOME") or own), own)):
        parent = root / "thruster_model"
        try:
            parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            trouble = next((said for path in (parent, *parent.glob("[!.]*")) if (said := _shared(path))), "")
        except OSError as error:
            trouble = f"{parent} cannot be made: {error.strerror}"
        if not trouble:
            return parent
        _LOG.warning(
            "compiled code is not kept in %s: %s, and so could put code of theirs there; expected a folder of your own "
            "(the variable XDG_CACHE_HOME names another place)", parent, trouble,
        )  # fmt: skip
    alone = tempfile.mkdtemp(prefix="thruster_model-")  # private by its making
    atexit.register(shutil.rmtree, alone, ignore_errors=True)
    return Path(alone)


def _shared(folder: Path) -> str:
    """Return who else owns or may write a folder or one that it lies in, "" for nobody.

    In a folder like /tmp, whose sticky bit lets everybody write but only owners rename, one's own folder is safe.
    """
    for place in (path := folder.resolve(), *path.parents):
        try:
            found = place.stat()
        except FileNotFoundError:  # an old one, which another process has just removed
            continue
        if found.st_uid not in (0, os.getuid()):
            return f"others own {place}"
        by_group = found.st_mode & stat.S_IWGRP and not (found.st_gid == os.getgid() == os.getuid())
        if (by_group or found.st_mode & stat.S_IWOTH) and not (found.st_mode & stat.S_ISVTX and place != path):
            return f"others may write {place}"
    return ""


def _package_root(source: Path) -> Path:
    root = source.parent
    while (root.parent / "__init__.py").exists():
        root = root.parent
    return root


def _sources_hash(packages: frozenset[Path]) -> str:
    digest = hashlib.sha256(numba.__version__.encode())
    for package in sorted(packages):
        for source in sorted(package.rglob("*.py")):
            digest.update(source.relative_to(package).as_posix().encode())
            digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _remove_oldest(parent: Path) -> None:
    """Keep the most recently used caches and all of the last hour; other processes may be removing the same ones."""
    used = {}
    for folder in parent.glob("[!.]*"):
        with suppress(FileNotFoundError):
            used[folder] = folder.stat().st_mtime
    latest = max(used.values(), default=0.0)
    for folder in sorted(used, key=lambda folder: used[folder], reverse=True)[_KEPT_CACHES:]:
        if used[folder] < latest - _IN_USE:
            # Renamed first: a folder that is being emptied has just changed and would pass for a newly used one.
            with suppress(OSError):
                folder.rename(parent / f".{folder.name}.{os.getpid()}")
    for removed in parent.glob(".*"):  # and what an interrupted process left behind
        for path, _, files in os.walk(removed, topdown=False):  # passes over what it can no longer list
            for name in files:
                with suppress(OSError):
                    os.unlink(os.path.join(path, name))
            with suppress(OSError):
                os.rmdir(path)
