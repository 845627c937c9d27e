"""Diagnoses side by side: none is lost, and what is no diagnosis is refused by its name."""

import json

import pytest

from gap_diagnosis.cli_diagnosis_table import main


def written(folder, verdict="unknown"):
    folder.mkdir(parents=True)
    content = {
        "verdict": verdict,
        "gap": {"total": None, "channels": {}},
        "p_unknown": 0.9,
        "summary": "Nothing fits.",
        "provenance": {"runs": ["a"], "parameter_set": "HL"},
    }
    (folder / "diagnosis.json").write_text(json.dumps(content))
    return str(folder / "diagnosis.json")


def test_folders_of_the_same_name_are_told_apart_by_their_parents(tmp_path, capsys):
    assert main([written(tmp_path / "p" / "run"), written(tmp_path / "q" / "run", "no_gap")]) == 0
    printed = capsys.readouterr().out
    assert "| p/run | HL | 1 | `unknown` |" in printed and "| q/run | HL | 1 | `no_gap` |" in printed


def test_the_same_diagnosis_twice_is_refused(tmp_path, capsys):
    file = written(tmp_path / "run")
    assert main([file, file]) == 1
    assert "expected each diagnosis once; found run several times" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "sentence"),
    [("{}", "expected a diagnosis.json; it has no verdict, gap, p_unknown"), ("no", "expected JSON; Expecting value")],
)
def test_what_is_no_diagnosis_is_refused_by_its_name(tmp_path, capsys, text, sentence):
    (tmp_path / "diagnosis.json").write_text(text)
    assert main([str(tmp_path / "diagnosis.json")]) == 1
    said = capsys.readouterr().err
    assert sentence in said and str(tmp_path) in said
