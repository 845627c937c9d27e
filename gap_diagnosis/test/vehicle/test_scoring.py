"""How opened cases of vehicles are counted and compared, on answers made by hand."""

import json
from pathlib import Path
from typing import Any

import pytest

from gap_diagnosis.vehicle.blind import cli_blind_vehicle
from gap_diagnosis.vehicle.blind.cli_blind_vehicle import FROZEN, TUNING, main
from gap_diagnosis.vehicle.blind.scoring import differences, scored, table


def said(effect: str, thruster: int | None = None, probability: float = 0.9) -> dict[str, Any]:
    place = {"thruster": thruster, "other": None, "axis": None}
    return {"id": effect, **place, "probability": probability, "indistinguishable_from": [], "parameters": {}}


def case(seed: int, hidden: list[dict[str, Any]], outside: str, verdict: str, *effects: dict[str, Any]) -> Any:
    marks = scored(hidden, outside, {"verdict": verdict, "effects": list(effects)})
    return {"seed": seed, "hidden": hidden, "outside": outside, "missing": (), "marks": marks}


LOSS = {"id": "thrust_loss", "thruster": 2, "sizes": {"share": 0.4}}
CASES = [
    case(1, [LOSS], "", "effect", said("thrust_loss", 2)),
    case(2, [LOSS], "", "effect", said("thrust_loss", 3)),
    case(3, [], "leak", "effect", said("buoyancy_offset")),
    case(4, [], "leak", "effect", said("thrust_loss", 1)),
    case(5, [], "lift", "unknown"),
    case(6, [], "", "no_gap"),
]


def test_what_is_outside_the_library_may_be_named_in_its_block() -> None:
    marks = {c["seed"]: c["marks"] for c in CASES}
    assert [marks[seed]["right"] for seed in (3, 4, 5)] == [False, False, True]
    assert [marks[seed]["block"] for seed in (3, 4, 5)] == [True, False, True]


def test_the_table_counts_each_figure_over_its_own_cases() -> None:
    rows = dict(table(CASES))
    assert rows["one effect hidden: it alone is named, in its place"].startswith("50 % (1/2;")
    assert rows["outside: unknown, or all that is named is in the right block"].startswith("67 % (2/3;")
    assert rows["a wrong effect or place named with p of 0.8 or more, all cases"].startswith("50 % (3/6;")
    assert rows["an effect claimed where there is none"].startswith("0 % (0/1;")
    assert rows["calibration error of what is named"] == "0.65 (4 names)"  # of four names at 0.9 one is right


def test_cases_that_are_answered_otherwise_are_told() -> None:
    after = [case(1, [LOSS], "", "unknown"), case(2, [LOSS], "", "effect", said("thrust_loss", 2)), *CASES[2:]]
    assert differences(CASES, after) == [
        ("1", "thrust_loss 2", "effect: thrust_loss 2", "unknown", "worse"),
        ("2", "thrust_loss 2", "effect: thrust_loss 3", "effect: thrust_loss 2", "better"),
    ]


def test_the_frozen_cases_are_none_that_are_reported() -> None:
    assert len(FROZEN) == 12 and max(FROZEN) < TUNING
    assert set(FROZEN.values()) == {"none", "one", "pair", "outside"}


def test_stored_answers_are_told_and_compared(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = {name: tmp_path / name for name in ("before", "after")}
    files["before"].write_text("".join(json.dumps(c) + "\n" for c in CASES), "utf-8")
    files["after"].write_text(json.dumps(case(1, [LOSS], "", "no_gap")) + "\n", "utf-8")
    assert main([str(files["after"]), "--compare", str(files["before"])]) == 0
    assert "| 1 | thrust_loss 2 | effect: thrust_loss 2 | no_gap | worse |" in capsys.readouterr().out


def test_of_the_frozen_cases_the_first_ones_are_run_and_an_interrupt_keeps_what_is_finished(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ran: list[tuple[int, str | None]] = []

    def answered(seed: int, kind: str | None) -> Any:
        if len(ran) == 1:
            raise KeyboardInterrupt
        ran.append((seed, kind))
        return case(seed, [LOSS], "", "effect", said("thrust_loss", 2))

    monkeypatch.setattr(cli_blind_vehicle, "_case", answered)
    cases = tmp_path / "new" / "cases.jsonl"
    assert main([str(cases), "--frozen", "--count", "1"]) == 0
    assert ran == [(1500, FROZEN[1500])]
    assert main([str(cases), "--frozen", "--count", "2"]) == 130
    assert "interrupted: cases that were finished are kept" in capsys.readouterr().err
    assert [json.loads(line)["seed"] for line in cases.read_text("utf-8").splitlines()] == [1500]


def test_a_file_without_cases_and_a_broken_line_are_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(tmp_path / "none.jsonl")]) == 1
    assert "expected cases to tell of, or --count; found none" in capsys.readouterr().err
    (tmp_path / "broken.jsonl").write_text("seed 3\n", "utf-8")
    assert main([str(tmp_path / "broken.jsonl")]) == 1
    assert "broken.jsonl, line 1: expected a JSON object; found 'seed 3'" in capsys.readouterr().err
