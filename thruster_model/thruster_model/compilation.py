"""Compile kernels with numba into a cache that notices every change of the equations.

numba's own cache looks at the file of the compiled function only, so a changed callee in another file would go
unseen. Here the cache folder is named after a hash of all source files of the packages that hold equations, is
private to the user, and is never a shared temporary folder (its files are pickles).
"""

import hashlib
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar

import numba
from numba.extending import register_jitable

__all__ = ["cache_folder", "compiled", "equation", "inlined"]

Function = TypeVar("Function", bound=Callable[..., Any])

_PACKAGE = Path(__file__).parent
_KEPT_CACHES = 8
_IN_USE = 3600.0  # s
_cache_folders: dict[frozenset[Path], Path] = {}


def equation(function: Function) -> Function:
    """Mark a function as an equation: plain Python when called from Python, compiled when called from a kernel."""
    return register_jitable(function)  # type: ignore[no-any-return]


def inlined(function: Function) -> Function:
    """Mark an equation that is laid into the code of its caller: many coefficients then stay where they are."""
    return register_jitable(forceinline=True)(function)  # type: ignore[no-any-return]


def compiled(function: Function) -> Function:
    """Compile a kernel, cached in a folder that belongs to exactly this state of the equations.

    Kernels are module-level functions: a closure would be compiled again in each process.
    """
    folder = cache_folder(*_packages_of(function))
    previous = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(folder)
    try:
        return numba.njit(cache=True, error_model="numpy")(function)  # type: ignore[no-any-return]
    finally:
        numba.config.CACHE_DIR = previous


def cache_folder(*packages: Path) -> Path:
    """Return the cache folder for kernels built from `packages`, made if need be, readable by its owner alone."""
    key = frozenset({_PACKAGE, *packages})
    if key not in _cache_folders:
        parent = _cache_root() / "thruster_model"
        folder = parent / _sources_hash(key)
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        parent.chmod(0o700)
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


def _cache_root() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


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
