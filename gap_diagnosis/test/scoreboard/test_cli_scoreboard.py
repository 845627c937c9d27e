"""One case through the command: recorded, diagnosed from its files, kept, not run again."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import asdict

import pytest

from gap_diagnosis.kept_lines_io import keep_line
from gap_diagnosis.scoreboard import cli_scoreboard, plans
from gap_diagnosis.scoreboard.answers import Answer
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
    assert "1 case in" in capsys.readouterr().out


def test_an_empty_folder_is_a_sentence(tmp_path, capsys):
    assert cli_scoreboard.main(["table", str(tmp_path)]) == 1
    assert "expected answers of `scoreboard run`; found none" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("asked", "said"),
    [(["--first", "9000"], ", a case of the set smoke; found 9000"), (["--count", "0"], "found 0, 0")],
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


def kept(folder, *names):
    folder.mkdir()
    answers = [
        Answer(
            case=name, generator="lab", kind="none", model="hl", effects={}, outside={}, distances={}, shares={},
            diagnosis={"verdict": "no_gap", "effects": [], "candidates": []}, seconds=1.0,
        )
        for name in names
    ]  # fmt: skip
    (folder / "answers.jsonl").write_text("".join(json.dumps(asdict(each)) + "\n" for each in answers), "utf-8")
    return folder


def test_folders_without_a_case_in_both_are_not_compared(tmp_path, capsys):
    before, after = kept(tmp_path / "before", "lab-none-1", "lab-none-2"), kept(tmp_path / "after", "lab-none-3")
    assert cli_scoreboard.main(["compare", str(before), str(after)]) == 1
    said = "expected answers to the same cases; found 2 cases and 1 case, none of them in both"
    assert said in capsys.readouterr().err
    (after / "answers.jsonl").write_text((before / "answers.jsonl").read_text("utf-8").split("\n")[0] + "\n", "utf-8")
    assert cli_scoreboard.main(["compare", str(before), str(after)]) == 0
    assert f"0 of 1 case in both answered otherwise than in {before}" in capsys.readouterr().out


def test_a_broken_line_is_named_and_one_that_was_cut_off_is_passed_over(tmp_path, capsys):
    folder = kept(tmp_path / "board", "lab-none-1", "lab-none-2")
    whole = (folder / "answers.jsonl").read_text("utf-8")
    (folder / "answers.jsonl").write_text(whole[:-20], "utf-8")
    assert cli_scoreboard.main(["table", str(folder)]) == 0
    keep_line(folder / "answers.jsonl", asdict(read_answers(folder)[0]))
    assert [each.case for each in read_answers(folder)] == 2 * ["lab-none-1"], "the cut line is gone"
    (folder / "answers.jsonl").write_text('{"broken\n' + whole, "utf-8")
    assert cli_scoreboard.main(["table", str(folder)]) == 1
    assert f"{folder / 'answers.jsonl'}, line 1: expected a JSON object; found '{{\"broken'" in capsys.readouterr().err


def test_an_interrupt_ends_a_run_at_once_in_one_sentence(tmp_path):
    command = [sys.executable, "-m", "gap_diagnosis.scoreboard.cli_scoreboard", "run", "quick", str(tmp_path / "board")]
    with subprocess.Popen(
        [*command, "--processes", "1"], start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    ) as process:
        while not (tmp_path / "board").exists():
            time.sleep(0.1)
        time.sleep(5.0)  # a worker loads kernels, or is at work
        os.killpg(process.pid, signal.SIGINT)
        _, told = process.communicate(timeout=30)
    assert process.returncode == 130
    sentence = "interrupted: cases that were finished are kept, the same command goes on"
    assert told.decode().strip().splitlines()[-1] == sentence and b"Traceback" not in told
