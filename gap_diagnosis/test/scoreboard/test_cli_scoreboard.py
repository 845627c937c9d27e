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


@pytest.mark.parametrize(
    ("asked", "said"),
    [(["--first", "9000"], "expected a case of the set smoke; found 9000"), (["--count", "0"], "found 0, 0")],
)
def test_cases_that_are_not_there_are_a_sentence(asked, said, tmp_path, capsys):
    assert cli_scoreboard.main(["run", "smoke", str(tmp_path / "board"), *asked]) == 1
    assert said in capsys.readouterr().err
    assert not (tmp_path / "board").exists()


def test_a_part_of_a_set_is_run_by_itself(tmp_path, monkeypatch):
    ran = []
    monkeypatch.setattr(cli_scoreboard, "run_cases", lambda cases, *_: ran.extend(cases))
    cli_scoreboard.main(["run", "quick", str(tmp_path), "--first", "3", "--count", "2"])
    assert ran == plans.planned("quick", tuple(cli_scoreboard.GENERATORS))[3:5]
