"""The cache of compiled kernels: private, and new when an equation changes."""

import stat
import subprocess
import sys
from pathlib import Path

import pytest

from thruster_model import compilation


@pytest.fixture
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(compilation, "_cache_folders", {})
    return tmp_path


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


def test_old_caches_are_removed_and_the_newest_kept(own_cache, monkeypatch):
    for k in range(14):
        package(own_cache / "p", f"x = {k}")
        monkeypatch.setattr(compilation, "_cache_folders", {})
        newest = compilation.cache_folder(own_cache / "p")
        (newest / "kernel.nbc").write_text("")
    kept = [f for f in newest.parent.iterdir() if f.is_dir()]
    assert newest in kept and len(kept) <= 8


def test_a_second_process_finds_the_kernel_compiled(tmp_path):
    code = (
        "import os, numpy as np; from thruster_model import flow_tank as f;"
        "from thruster_model.parameter_set_io import load_parameter_set as l;"
        "f.simulate(l('hl').coefficients, np.ones(2), 0.01); print(sum(f.run_plant.stats.cache_hits.values()))"
    )
    environment = {"XDG_CACHE_HOME": str(tmp_path), "PYTHONPATH": ":".join(p for p in sys.path if p)}
    hits = [
        subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
        for _ in range(2)
    ]
    assert [h.stdout.strip() for h in hits] == ["0", "1"]
