"""The command, with a diagnosis of our own in place of the real one."""

import gzip
import shutil
import sys
from concurrent.futures import ThreadPoolExecutor
from types import ModuleType

import pytest

from gap_diagnosis.blind_check import cli_blind_check
from gap_diagnosis.blind_check.opened_io import read_opened, write_opened


@pytest.fixture
def stub(monkeypatch):
    """Put in place a diagnosis that never finds anything."""
    module = ModuleType("gap_diagnosis.diagnose_io")
    module.calls = []

    def diagnose_paths(paths, parameter_set_path, excluded=(), seed=0):
        module.calls.append(paths)
        return {"verdict": "no_gap", "effects": [], "candidates": [], "p_none": 1.0, "p_unknown": 0.0}

    module.diagnose_paths = diagnose_paths
    monkeypatch.setitem(sys.modules, "gap_diagnosis.diagnose_io", module)
    monkeypatch.setattr(cli_blind_check, "worker_processes", ThreadPoolExecutor)
    return module


def command(folder, *more):
    given = ["--cases", "4", "--seed", "21", "--out", str(folder), "--processes", "1"]
    return cli_blind_check.main([*given, *more])


def test_the_hash_of_the_seals_is_printed_before_the_scores_and_the_page_has_it(stub, tmp_path, capsys):
    page = tmp_path / "docs" / "blind_check.md"
    assert command(tmp_path / "check", "--kinds", "none", "nuisance", "--docs", str(page)) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert printed.index("hash of all") < printed.index("right verdict")
    assert "4 keys sealed" in printed and len(stub.calls) == 4
    assert "hash of all sealed keys `" in page.read_text() and "| none | 100.0 %" in page.read_text()


def test_a_second_call_diagnoses_nothing_anew(stub, tmp_path, capsys):
    assert command(tmp_path / "check") == 0 and command(tmp_path / "check") == 0
    assert len(stub.calls) == 4


def test_what_is_finished_so_far_is_scored_without_diagnosing_more(stub, tmp_path, capsys):
    folder, page = tmp_path / "check", tmp_path / "page.md"
    assert command(folder) == 0
    for case in sorted((folder / "cases").iterdir())[2:]:
        shutil.rmtree(case)
    assert command(folder, "--so-far", "--docs", str(page)) == 0
    assert len(stub.calls) == 4 and "2 cases of 4" in page.read_text()


def test_what_was_opened_elsewhere_is_scored_with_the_rest_and_not_diagnosed_again(stub, tmp_path, capsys):
    """Two machines share a check: the second goes on where the first stopped, and has the figures of both."""
    first, second, page = tmp_path / "first", tmp_path / "second", tmp_path / "page.md"
    assert command(first) == 0
    whole, part = read_opened(first / "opened.jsonl.gz"), tmp_path / "part.jsonl.gz"
    write_opened(whole[:3], part)
    assert command(second, "--opened", str(part), "--docs", str(page)) == 0
    assert [paths[0].parts[-3] for paths in stub.calls[4:]] == ["case_00003"]
    joined = read_opened(tmp_path / "page_cases.jsonl.gz")
    assert joined[:3] == whole[:3] and joined[3].seal != whole[3].seal, "sealed anew, with another nonce"
    assert "4 cases of 4" in page.read_text()


def test_cases_opened_elsewhere_must_be_of_this_check(stub, tmp_path, capsys):
    assert command(tmp_path / "check") == 0
    opened, torn, plain = tmp_path / "check" / "opened.jsonl.gz", tmp_path / "torn.gz", tmp_path / "plain"
    torn.write_bytes(gzip.compress(b'{"seal": "12'))
    plain.write_text('{"seal": "12"}')
    sentences = {
        opened: f"{opened}: case_00000 was sealed for another seed",
        torn: "line 1: expected an opened case with seal, key, diagnosis, shrink",
        plain: "expected JSON Lines compressed by gzip",
    }
    for file, sentence in sentences.items():
        assert command(tmp_path / "other", "--seed", "22", "--opened", str(file)) == 1
        assert sentence in capsys.readouterr().err


def test_nothing_so_far_is_said(stub, tmp_path, capsys):
    assert command(tmp_path / "check", "--so-far") == 1
    assert "expected finished cases; found none" in capsys.readouterr().err


def test_a_folder_of_another_seed_is_refused_with_a_sentence(stub, tmp_path, capsys):
    assert command(tmp_path / "check") == 0
    assert command(tmp_path / "check", "--seed", "22") == 1
    assert "was sealed for another seed or another choice of cases" in capsys.readouterr().err


def test_unknown_effects_are_refused_with_a_sentence(stub, tmp_path, capsys):
    assert command(tmp_path / "check", "--effects", "gremlins") == 1
    assert "effect: expected log_alignment" in capsys.readouterr().err
