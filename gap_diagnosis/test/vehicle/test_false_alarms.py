"""Rates of false alarms from peaks whose distribution is known, and the count by the watch's own code on one dive."""

import json
from pathlib import Path

import numpy as np
import pytest

from gap_diagnosis.vehicle.blind import watch_hours_io
from gap_diagnosis.vehicle.blind.cli_watch_rate import main, said
from gap_diagnosis.vehicle.blind.watch_hours_io import EFFECTS, Watched, watched_draw
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.false_alarms import (
    most_alarms,
    probabilities,
    rate_at,
    stated_rate,
    threshold_for,
)
from gap_diagnosis.vehicle.rules import WATCH_THRESHOLD


def test_thresholds_of_exponential_peaks_are_those_of_their_distribution() -> None:
    # 200 peaks in 50 h with mean 4: rate(h) = 4 exp(-h / 4) an hour, so 0.02 at 4 ln 200 = 21.2
    found = [threshold_for(0.02, list(np.random.default_rng(seed).exponential(4.0, 200)), 50.0) for seed in range(200)]
    assert np.median(found) == pytest.approx(4.0 * np.log(200.0), rel=0.05)
    assert np.std(found) < 5.0


def test_within_the_count_the_count_stands() -> None:
    peaks = [float(k) for k in range(1, 101)]
    assert threshold_for(5.0, peaks, 10.0) == 51.0 and rate_at(51.0, peaks, 10.0) == 5.0


def test_no_alarm_in_a_time_excludes_a_rate_by_poisson() -> None:
    assert most_alarms(0, 10.0) == pytest.approx(0.29957, rel=1e-3)


def test_the_stated_rate_is_the_counted_one_and_none_where_nothing_was_counted() -> None:
    assert stated_rate(35.0) == "0.1 (less than 0.2 at 95 %, 173 h counted)"
    assert stated_rate(45.0) == "0.09 (less than 0.14 at 95 %, 173 h counted)"
    assert stated_rate(19.0) == "not counted below a threshold of 20"


def test_an_alarm_is_as_probable_as_failures_are_frequent_beside_false_alarms_at_its_height() -> None:
    # 24 false alarms in 173 h at 35 against one failure in 10 h
    assert probabilities([35.0]) == pytest.approx([0.1 / (0.1 + 24.0 / 173.0)])
    # 58 at 20 and 16 at 45: a sixteenth of 58 as many for each 25 that it is higher
    assert probabilities([70.0]) == pytest.approx([0.1 / (0.1 + 16.0 / 173.0 * 16.0 / 58.0)])
    first, second = probabilities([600.0, 575.0])
    assert first == pytest.approx(58.0 / 16.0 * second) and first + second == pytest.approx(1.0, abs=1e-3)


def test_too_few_minutes_give_no_threshold() -> None:
    with pytest.raises(ValueError, match="more than 20 minutes; found 1"):
        threshold_for(0.1, [3.0], 2.0)
    assert "No threshold" in said([{"seed": 1, "run": 0, "hours": 2.0, "minutes": [3.0]}], 0.1)


def test_what_was_counted_is_told_without_counting(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "dives.jsonl"
    rows = [
        {"seed": 1, "run": 0, "hours": 100.0, "minutes": [float(k) for k in range(1, 31)]},
        {"seed": 1, "run": 0, "kind": "steps", "thrust": 4.0, "ratios": [0.0, 10.0, 60.0, 200.0], "others": [0.0] * 4},
    ]
    rows.append({"seed": 1, "run": 0, "failure": "gyro", "ratios": [0.0, 170.0], "others": [300.0, 0.0]})
    file.write_text("".join(json.dumps(r) + "\n" for r in rows), "utf-8")
    picture = tmp_path / "delays.svg"
    assert main([str(file), "--plot", str(picture)]) == 0
    assert "not found in 60 s" in picture.read_text("utf-8")
    told = capsys.readouterr().out
    assert "100.0 h of 1 healthy vehicles." in told
    assert "| 3 to 6 | 1 | 1 | 1 | 3 | 0 |" in told
    assert "| gyro | 1 | 1 | 1 | 2 | 1 |" in told


def test_a_thruster_that_loses_half_its_thrust_stands_out_as_do_failing_sensors(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(watch_hours_io, "_MINUTE", 30.0)
    monkeypatch.setattr(watch_hours_io, "_AFTER", 20.0)
    draw = watched_draw(5)
    watched = Watched(draw, load_model(draw.vehicle))
    calm = watched.healthy(1, 0.25)
    lost = watched.loss(1, 0.5)
    assert calm["hours"] == pytest.approx(7.5 / 3600.0, rel=0.05)
    assert max(lost["ratios"]) > 10.0 * max([*calm["minutes"], 1.0])
    assert max(lost["ratios"]) > max(lost["others"])
    for run, name in enumerate(EFFECTS):
        failed = watched.failure(run)
        assert failed["failure"] == name
        if name not in ("velocity log", "foam lost"):  # these take longer than 20 s
            assert max(failed["ratios"]) > 2.0 * WATCH_THRESHOLD and max(failed["ratios"]) > max(failed["others"])
