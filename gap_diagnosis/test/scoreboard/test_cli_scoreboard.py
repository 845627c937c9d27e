"""One case through the command: recorded, diagnosed from its files, kept, not run again."""

import pytest

from gap_diagnosis.scoreboard import cli_scoreboard, plans
from gap_diagnosis.scoreboard.running_io import read_answers


@pytest.mark.long
def test_a_case_is_recorded_diagnosed_and_kept_and_the_second_time_read(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(plans.SETS, "smoke", (0, False, {"one": 1}))
    folder = tmp_path / "board"
    command = ["run", "smoke", str(folder), "--generators", "lab", "--processes", "1", "--docs", str(tmp_path / "b.md")]
    assert cli_scoreboard.main(command) == 0
    (kept,) = read_answers(folder)
    assert kept.diagnosis["verdict"] != "failed", kept.diagnosis
    assert "one effect: right" in (tmp_path / "b.md").read_text(encoding="utf-8")
    assert cli_scoreboard.main(command) == 0
    assert read_answers(folder) == [kept]
    assert "1 cases" in capsys.readouterr().out


def test_an_empty_folder_is_a_sentence(tmp_path, capsys):
    assert cli_scoreboard.main(["table", str(tmp_path)]) == 1
    assert "expected answers of `scoreboard run`; found none" in capsys.readouterr().err
