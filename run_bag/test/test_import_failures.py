"""Importers that cannot write or are interrupted: one sentence, an exit status, nothing half done."""

import importlib.util
import os
import signal
from pathlib import Path

import numpy as np
import pytest

from run_bag import CannotWriteError, write_run, writer
from run_bag.benchmark import bench_topics
from run_bag.importers.cli_bench import main as import_bench
from run_bag.importers.cli_recording import main as import_csv

_spec = importlib.util.spec_from_file_location("synthetic_bench", Path(__file__).with_name("synthetic_bench.py"))
made = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(made)


def csv_import(folder, out):
    (folder / "x.csv").write_text("0,1\n1,-2\n")
    (folder / "map.yaml").write_text("thruster_0/state.n: {column: 2, time_column: 1, unit: rad/s}")
    return import_csv([str(folder / "x.csv"), "--map", str(folder / "map.yaml"), "--out", str(out / "x")])


def bench_import(folder, out):
    time = np.arange(12_000) * 0.001
    throttle = made.ramp(time, start=3.1, duration=1.4, setting=3.0, stop=9.0)
    n = made.rotor(time, throttle)
    for name in ("ap3V", "bp3V"):
        made.write_csv(folder / f"{name}.csv.xz", made.load_cell(time, n, made.tachometer(n)))
    return import_bench([str(folder), "--out", str(out)])


IMPORTS = pytest.mark.parametrize("run_import", [csv_import, bench_import])


@IMPORTS
def test_a_target_that_cannot_be_written_is_one_sentence_and_status_one(tmp_path, capsys, run_import):
    (tmp_path / "in").mkdir()
    (tmp_path / "file").write_text("in the way")
    assert run_import(tmp_path / "in", tmp_path / "file") == 1
    (sentence,) = capsys.readouterr().err.splitlines()
    assert str(tmp_path / "file") in sentence and "cannot be written: " in sentence


@IMPORTS
def test_an_interrupt_is_one_sentence_and_status_130_and_leaves_nothing_half_written(
    tmp_path, capsys, monkeypatch, run_import
):
    write = writer._write_messages

    def interrupted(*arguments):
        write(*arguments)
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(writer, "_write_messages", interrupted)
    (tmp_path / "in").mkdir()
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
    try:
        assert run_import(tmp_path / "in", tmp_path / "out") == 130
    finally:
        signal.signal(signal.SIGINT, before)
    (sentence,) = capsys.readouterr().err.splitlines()
    assert "interrupted; what is there is whole" in sentence
    assert list((tmp_path / "out").iterdir()) == []


def test_a_full_disk_is_told_with_the_target_and_leaves_nothing_half_written(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(writer, "write_metadata_yaml", full)
    with pytest.raises(CannotWriteError, match="/a: cannot be written: No space left on device"):
        write_run(tmp_path / "a", bench_topics(3))
    assert list(tmp_path.iterdir()) == []


def test_a_folder_without_recordings_of_the_bench_is_a_sentence(tmp_path, capsys):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "notes.txt").write_text("nothing measured")
    assert import_bench([str(tmp_path / "in"), "--out", str(tmp_path / "out")]) == 1
    sentence = (
        f"{tmp_path / 'in'}: expected recordings of the bench: csv of its load cell, dat of a velocimeter, mat of "
    )
    assert capsys.readouterr().err == f"{sentence}a controller; found none\n"
