"""The cache of compiled kernels: private, and new when an equation changes."""

import os
import stat
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

from thruster_model import compilation
from thruster_model.compilation import borrowed, told_of_compiling
from thruster_model.equations.thruster import input_map


@pytest.fixture
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(compilation, "_cache_folders", {})
    compilation._private_parent.cache_clear()
    yield tmp_path
    compilation._private_parent.cache_clear()


def package(folder: Path, body: str) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "__init__.py").write_text("")
    (folder / "equations.py").write_text(body)
    return folder


def test_a_changed_equation_in_another_file_gets_a_new_cache_folder(own_cache, monkeypatch):
    source = package(own_cache / "p", "x = 1")
    before = compilation.cache_folder(source)
    package(source, "x = 2")
    monkeypatch.setattr(compilation, "_cache_folders", {})
    assert compilation.cache_folder(source) != before


def test_the_cache_is_readable_by_its_owner_alone(own_cache):
    folder = compilation.cache_folder()
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert stat.S_IMODE(folder.parent.stat().st_mode) == 0o700


@pytest.mark.parametrize("writable", ["", "thruster_model", "thruster_model/0123456789abcdef"])
def test_a_folder_that_others_may_write_is_refused_and_a_private_one_is_used(own_cache, monkeypatch, caplog, writable):
    """They could have put code of theirs into it, which the files are."""
    home, shared = own_cache / "home", own_cache / "shared"
    for folder in (home, shared / "thruster_model" / "0123456789abcdef"):
        folder.mkdir(parents=True, mode=0o700)
    (shared / writable).chmod(0o777)
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setenv("XDG_CACHE_HOME", str(shared))
    assert compilation.cache_folder().parent == home / ".cache" / "thruster_model"
    assert f"others may write {(shared / writable).resolve()}" in caplog.text


def test_a_folder_that_others_own_is_refused_and_where_the_home_is_too_one_is_made_for_the_process(
    own_cache, monkeypatch, caplog
):
    monkeypatch.setenv("HOME", str(own_cache))
    if os.getuid() == 0:
        os.chown(own_cache, 12345, -1)
    else:
        monkeypatch.setattr(os, "getuid", lambda: 12345)
    folder = compilation.cache_folder()
    assert "others own" in caplog.text
    assert own_cache not in folder.parents
    assert stat.S_IMODE(folder.parent.stat().st_mode) == 0o700


def caches_after_use(own_cache: Path, monkeypatch, hours_ago: list[float]) -> list[bool]:
    """Return whether each of the caches used so many hours ago is left once the last one has been used."""
    folders = []
    for k, hours in enumerate(hours_ago):
        package(own_cache / "p", f"x = {k}")
        monkeypatch.setattr(compilation, "_cache_folders", {})
        folders.append(compilation.cache_folder(own_cache / "p"))
        (folders[-1] / "kernel.nbc").write_text("")
        made = folders[-1].stat().st_mtime
        os.utime(folders[-1], (made - 3600 * hours,) * 2)
    os.utime(folders[-1], (made, made))
    compilation._remove_oldest(folders[-1].parent)
    return [folder.exists() for folder in folders]


def test_of_old_caches_the_newest_are_kept(own_cache, monkeypatch):
    kept = caches_after_use(own_cache, monkeypatch, [hours + 2 for hours in range(14, 0, -1)])
    assert kept == [False] * 6 + [True] * 8


def test_processes_that_remove_the_same_caches_do_not_trip_over_each_other(tmp_path):
    """Four processes at once, each clearing the same twenty old caches of a hundred files."""
    parent = tmp_path / "caches"
    for k in range(28):
        (parent / f"{k:02d}").mkdir(parents=True)
        for name in range(100):
            (parent / f"{k:02d}" / f"{name}.nbc").write_text("")
        os.utime(parent / f"{k:02d}", (1e9 + k, 1e9 + k))
    os.utime(parent / "27", (2e9, 2e9))
    remove = (
        "import sys, pathlib; from thruster_model.compilation import _remove_oldest as r; r(pathlib.Path(sys.argv[1]))"
    )
    removing = [subprocess.Popen([sys.executable, "-c", remove, str(parent)]) for _ in range(4)]
    assert [process.wait(timeout=60) for process in removing] == [0] * 4
    assert sorted(folder.name for folder in parent.iterdir()) == [f"{k:02d}" for k in range(20, 28)]


def test_caches_that_may_be_in_use_are_kept(own_cache, monkeypatch):
    assert all(caches_after_use(own_cache, monkeypatch, [0.5] * 14))


def test_a_kernel_belongs_to_the_packages_of_all_it_calls():
    found = compilation._packages_of(calls_the_input_map)
    assert {folder.name for folder in found} >= {"thruster_model", Path(__file__).parent.name}


def calls_the_input_map(u, p):
    return input_map(u, p)


def test_a_second_process_finds_the_kernel_compiled(tmp_path):
    code = (
        "import os, numpy as np; from thruster_model import flow_tank as f, stepper as s;"
        "from thruster_model.parameter_set_io import load_parameter_set as l;"
        "f.simulate(l('hl').coefficients, np.ones(2), 0.01); print(sum(s.fill.stats.cache_hits.values()))"
    )
    environment = {"XDG_CACHE_HOME": str(tmp_path), "PYTHONPATH": ":".join(p for p in sys.path if p)}
    hits = [
        subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
        for _ in range(2)
    ]
    assert [h.stdout.strip() for h in hits] == ["0", "1"]


@numba.njit
def _summed(numbers, rows):
    first, (second, share) = borrowed((numbers, rows))
    total = 0.0
    for i in range(second.shape[0]):
        row = second[i]
        row[0] += 1.0
        total += share * row[1] + first[i]
    return total


def test_borrowed_arrays_are_the_callers_and_stay_his():
    numbers, rows = np.arange(3.0), np.ones((3, 2))
    before = sys.getrefcount(numbers), sys.getrefcount(rows)
    for _ in range(3):
        assert _summed(numbers, (rows, 0.5)) == 4.5 == _summed.py_func(numbers, (rows, 0.5))
    assert np.array_equal(rows[:, 0], [7.0, 7.0, 7.0])
    assert (sys.getrefcount(numbers), sys.getrefcount(rows)) == before


def test_an_old_cache_that_another_process_removes_meanwhile_is_no_trouble(own_cache, monkeypatch):
    gone = own_cache / "thruster_model" / "0123456789abcdef"
    gone.mkdir(parents=True, mode=0o700)
    listed = Path.glob

    def listed_then_removed(folder, pattern):
        found = list(listed(folder, pattern))
        gone.rmdir()
        return found

    monkeypatch.setattr(Path, "glob", listed_then_removed)
    assert compilation._private_parent() == gone.parent


def test_the_first_kernel_that_compiles_is_told_of_once_and_compiled_ones_are_not():
    told = []
    half, twice = numba.njit(lambda x: 0.5 * x), numba.njit(lambda x: 2.0 * x)
    with told_of_compiling(told.append):
        assert twice(half(1.0)) == 1.0
    assert len(told) == 1 and told[0].startswith("compiling the model")
    with told_of_compiling(told.append):
        assert half(3.0) == 1.5
    assert len(told) == 1
