"""Distances, shares, plans and figures by hand."""

import json
import math
from dataclasses import asdict

import numpy as np
import pytest

from gap_diagnosis.scoreboard.answers import Answer
from gap_diagnosis.scoreboard.case import Generator, Samples, SyntheticRun, Truth
from gap_diagnosis.scoreboard.figures import differences, table
from gap_diagnosis.scoreboard.generators import GENERATORS
from gap_diagnosis.scoreboard.plans import REPORTED, SETS, planned
from gap_diagnosis.scoreboard.running_io import read_answers
from gap_diagnosis.scoreboard.truths import PARAMETERS, distances, shares

X = np.linspace(-1.0, 1.0, 201)


TIME = 0.1 * np.arange(X.size)


def _clean(truth, effects, outside, factors, push):
    """A line of slope k, an effect that bends it, one that equals a re-tuning, a push that moves it."""
    y = 100.0 * factors.get("k", 1.0) * X
    y = y + effects.get("bend", {}).get("size", 0.0) * X**2 + effects.get("gain", {}).get("size", 0.0) * X
    return y[None] if push is None else (y + 3.0 * push(0, TIME, 2.0) + 0.0 * push(1, TIME, 2.0))[None]


def _record(truth):
    stamps = Samples(TIME, TIME)
    return [SyntheticRun(name="line", throttle=stamps, signals={"speed": stamps})]


LINE = Generator(name="line", title="", draw=lambda *_: None, record=_record, clean=_clean)


def _truth(**effects):
    sizes = {name: {"size": size} for name, size in effects.items()}
    return Truth(generator="line", kind="two", index=0, model="line", effects=sizes, factors={"k": 1.02})


def test_what_parameters_imitate_is_less_far_away_than_what_they_do_not():
    found = distances(LINE, _truth(bend=4.0, gain=4.0))
    # By hand: noise, one stated deviation of the true slope, and what the push may do.
    covariance = np.eye(X.size) + np.outer(5.1 * X, 5.1 * X) + 9.0 * np.exp(-np.abs(TIME[:, None] - TIME) / 2.0)
    for name, trace in (("gain", 4.0 * X), ("bend", 4.0 * X**2)):
        assert found[name] == pytest.approx(np.sqrt(trace @ np.linalg.solve(covariance, trace)), rel=1e-6)


def test_shares_add_up_to_the_gap_and_are_those_of_orthogonal_traces():
    found = shares(LINE, _truth(bend=4.0))
    line, bend = 2.0 * X, 4.0 * X**2
    total = line @ line + bend @ bend
    assert sum(found.values()) == pytest.approx(1.0)
    assert found["bend"] == pytest.approx(bend @ bend / total)
    assert found[PARAMETERS] == pytest.approx(line @ line / total)


def test_cases_for_tuning_and_for_reporting_never_meet():
    assert {each.index for each in planned("quick", tuple(GENERATORS))} < set(range(REPORTED))
    assert all(each.index >= REPORTED for each in planned("reported", ("lab",)))
    assert sum(SETS["quick"][2].values()) * len(GENERATORS) >= 200


def answer(case, kind, diagnosis, effects=(), outside=(), **more):
    given = {"distances": {}, "shares": {}, "seconds": 1.0, **more}
    return Answer(
        case=case, generator="lab", kind=kind, model="hl", effects={name: {"share": 0.3} for name in effects},
        outside={name: {"share": 0.3} for name in outside}, diagnosis=diagnosis, **given,
    )  # fmt: skip


def claim(name, probability=0.99, value=0.3, std=0.01):
    return {"id": name, "probability": probability, "parameters": {"share": {"value": value, "std": std}}}


ONE = {
    "verdict": "effect",
    "effects": [claim("thrust_loss")],
    "candidates": [{"id": "thrust_loss", "probability": 0.9}],
}
CASES = [
    answer("a", "one", ONE, ["thrust_loss"], distances={"thrust_loss": 9.0}),
    answer("b", "one", ONE, ["thermal_fade"], distances={"thermal_fade": 2.0}),
    answer("c", "none", {"verdict": "parameters"}),
    answer("d", "none", ONE),
    answer("e", "many", {"verdict": "effect", "effects": [claim("thrust_loss"), claim("tach_lag")]},
           ["thrust_loss", "throttle_gain", "supply_sag"],
           distances={"thrust_loss": 9.0, "throttle_gain": 2.0, "supply_sag": 9.0},
           shares={"thrust_loss": 0.5, "throttle_gain": 0.3, "supply_sag": 0.01}),
    answer("f", "outside", {"verdict": "unknown"}, outside=["cogging"]),
]  # fmt: skip


def test_the_table_counts_what_a_person_would():
    rows = {row[0]: row[1] for row in table(CASES)}
    assert rows["one effect: right"].startswith("50 % (1/2;")
    assert rows["one effect above its limit: right"].startswith("100 % (1/1;")
    assert rows["none: an effect is claimed"].startswith("50 % (1/2;")
    assert rows["many: claims right"].startswith("50 % (1/2;")
    assert rows["many: causes worth > 5 % of the gap named"].startswith("50 % (1/2;")
    assert rows["many: of these, above their limits"].startswith("100 % (1/1;")
    assert rows["outside: flagged"].startswith("100 % (1/1;")
    assert rows["wrong name with 0.8 or more"].startswith("50 % (3/6;")


def test_two_runs_are_compared_case_by_case():
    after = [answer("d", "none", {"verdict": "no_gap"}), CASES[2]]
    assert differences(CASES, after)[1:] == [["d", "nothing", "effect: thrust_loss", "no_gap", "better"]]


def test_answers_are_read_as_they_were_kept_and_a_line_cut_off_is_not_there(tmp_path):
    lines = [json.dumps(asdict(each)) for each in CASES]
    (tmp_path / "answers.jsonl").write_text("\n".join(lines[:3]) + "\n" + lines[3][:50], encoding="utf-8")
    assert read_answers(tmp_path) == CASES[:3]


def test_a_diagnosis_that_broke_off_is_wrong():
    broken = answer("g", "none", {"verdict": "failed", "reason": "ValueError: x"}, seconds=math.nan)
    assert not broken.right
