"""Compile kernels with numba into a cache that notices every change of the equations.

numba's own cache looks at the file of the compiled function only, so a changed callee in another file would go
unseen. Here the cache folder is named after a hash of all source files of the packages that hold equations, is
private to the user, and is never a shared temporary folder (its files are pickles).
"""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.extending import register_jitable

__all__ = ["cache_folder", "compiled", "equation", "inlined"]

Function = TypeVar("Function", bound=Callable[..., Any])

_PACKAGE = Path(__file__).parent
_KEPT_CACHES = 4
_cache_folders: dict[Path, Path] = {}


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
    source = Path(function.__code__.co_filename)
    folder = cache_folder(_package_root(source))
    previous = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(folder)
    try:
        return numba.njit(cache=True, error_model="numpy")(function)  # type: ignore[no-any-return]
    finally:
        numba.config.CACHE_DIR = previous


def cache_folder(package: Path = _PACKAGE) -> Path:
    """Return the cache folder for kernels of `package`, made if it is not there, readable by its owner alone."""
    if package not in _cache_folders:
        parent = _cache_root() / "thruster_model"
        folder = parent / _sources_hash({package, _PACKAGE})
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        parent.chmod(0o700)
        os.utime(folder)
        _remove_oldest(parent)
        _cache_folders[package] = folder
    return _cache_folders[package]


def _cache_root() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


def _package_root(source: Path) -> Path:
    root = source.parent
    while (root.parent / "__init__.py").exists():
        root = root.parent
    return root


def _sources_hash(packages: set[Path]) -> str:
    digest = hashlib.sha256(numba.__version__.encode())
    for package in sorted(packages):
        for source in sorted(package.rglob("*.py")):
            digest.update(source.relative_to(package).as_posix().encode())
            digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _remove_oldest(parent: Path) -> None:
    """Keep the most recently used caches; a cache in use that disappears is only compiled again."""
    folders = sorted((f for f in parent.iterdir() if f.is_dir()), key=lambda f: f.stat().st_mtime, reverse=True)
    for folder in folders[_KEPT_CACHES * 2 :]:
        for file in folder.rglob("*"):
            if file.is_file():
                file.unlink(missing_ok=True)
        for empty in sorted(folder.rglob("*"), reverse=True):
            empty.rmdir()
        folder.rmdir()
