"""Diagnoses side by side: none is lost, and what is no diagnosis is refused by its name."""

import json

import pytest

from gap_diagnosis.cli_diagnosis_table import main

BUDGET = {
    "parameters": {"share": 0.46, "interval": [0.28, 0.6]},
    "causes": [
        {
            "id": "log_alignment", "channel": "load", "share": 0.11, "interval": [0.05, 0.17], "helps": 0.97,
            "best_without_each_run": None, "sizes_by_run_left_out": {"load": [0.02, 0.031, 0.025]},
        }
    ],
    "unexplained": {"share": 0.38, "interval": [0.26, 0.5]},
    "left_out": [{"step": "retuned", "helps": 0.999}],
}  # fmt: skip


def written(folder, verdict="unknown", budget=None):
    folder.mkdir(parents=True)
    content = {
        "verdict": verdict,
        "gap": {"total": None, "channels": {}},
        "p_unknown": 0.9,
        "summary": "Nothing fits.",
        "budget": budget,
        "provenance": {"runs": ["a"], "parameter_set": "HL"},
    }
    (folder / "diagnosis.json").write_text(json.dumps(content))
    return str(folder / "diagnosis.json")


def test_folders_of_the_same_name_are_told_apart_by_their_parents(tmp_path, capsys):
    assert main([written(tmp_path / "p" / "run"), written(tmp_path / "q" / "run", "no_gap")]) == 0
    printed = capsys.readouterr().out
    assert "| p/run | HL | 1 | `unknown` |" in printed and "| q/run | HL | 1 | `no_gap` |" in printed


def test_a_budget_has_a_row_for_each_cause(tmp_path, capsys):
    assert main([written(tmp_path / "a", budget=BUDGET), written(tmp_path / "b")]) == 0
    printed = capsys.readouterr().out
    assert "| a | re-tuned | 0.46 (0.28 to 0.60) | 0.999 | – | – |" in printed
    assert "| a | log_alignment:load | 0.11 (0.05 to 0.17) | 0.97 | – | load 0.02 to 0.031 |" in printed
    assert "| a | nothing with a name | 0.38 (0.26 to 0.50) | – | – | – |" in printed
    assert "| b | re-tuned" not in printed


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
