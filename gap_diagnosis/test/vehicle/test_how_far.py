"""How far a vehicle's model goes astray: against what it is measured, and what is said where there is no gap."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gap_diagnosis.vehicle import how_far
from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.content import content_of
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.how_far import Point, fit_without, left_out_errors, without_run
from gap_diagnosis.vehicle.log_io import read_logs
from gap_diagnosis.vehicle.refining import Problem
from gap_diagnosis.vehicle.report_io import report_of
from gap_diagnosis.vehicle.screening import Screen
from gap_diagnosis.vehicle.search import Found, search
from gap_diagnosis.vehicle.verdict import judged
from run_bag import write_run

MODEL = load_model("ngs")


@pytest.fixture(scope="module")
def healthy(tmp_path_factory: pytest.TempPathFactory) -> Found:
    draw = Draw(seed=12, vehicle="ngs", deviations=0.0, kinds=("steps",), duration=14.0)
    (topics,) = recorded(draw, MODEL.vehicle, MODEL.sets, MODEL.sensors)
    logs, model = read_logs([write_run(tmp_path_factory.mktemp("runs") / "run", topics)], MODEL)
    return search(model, logs, only=lambda h: False)


def pushed(found: Found, times: float) -> Found:
    """Return what was found with a random wrench learned as so many times as large."""
    last = found.stages[-1]
    runs = [replace(p, noises=p.noises._replace(wrench=times * p.noises.wrench)) for p in last.screen.runs]
    stage = replace(last, screen=replace(last.screen, runs=runs))
    return replace(found, stages=(*found.stages[:-1], stage))


def test_a_random_wrench_that_was_learned_as_large_is_no_excuse_for_an_error(healthy: Found) -> None:
    large, huge = (left_out_errors(pushed(healthy, times), [2.0])[0] for times in (1e3, 1e5))
    assert large.foreseen == pytest.approx(huge.foreseen, nan_ok=True)
    assert large.steps == pytest.approx(huge.steps)


def test_free_runs_of_a_model_that_loses_the_vehicle_are_as_far_off_as_can_be(
    healthy: Found, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Drag that no step of the filter follows, as where numbers of other recordings make no vehicle."""
    monkeypatch.setattr(how_far, "without_run", lambda *_: Point({("vehicle", "Q_r"): 1e6}, ()))
    found, last = healthy, healthy.stages[-1]
    (errors,) = left_out_errors(found, [2.0])
    assert errors.retuned["gyro"] == np.inf and np.isfinite(errors.as_is["gyro"])
    assert 10.0 * errors.steps[0] < errors.steps[1] <= 30.0
    log = last.screen.runs[0].log
    content = content_of(judged(found, [log]), found, [errors], None, [log], {"runs": ["run"]})
    asked = content_of(judged(found, [log]), found, [errors], None, [log], {"runs": ["run"]}, asked=True)
    assert asked["next_experiment"] is None, "where a programme was asked for and none helps, nothing else is advised"
    assert json.dumps(content, allow_nan=False)
    assert "Where the gap goes" in report_of(content, MODEL.vehicle, [errors], "", "Diagnosis").html()


def test_where_there_is_no_gap_a_sentence_says_so_in_place_of_shares(healthy: Found) -> None:
    log, errors = healthy.stages[-1].screen.runs[0].log, left_out_errors(healthy, [2.0])[0]
    none = replace(errors, budget=())
    content = content_of(judged(healthy, [log], [none]), healthy, [none], None, [log], {"runs": ["run"]})
    assert content["verdict"] == "no_gap"
    assert content["budget"]["parameters"] is None and "no gap to share out" in content["budget"]["why_not"]
    assert content["gap"]["left_out"] is False and content["gap"]["total"]["as_is"] == errors.steps[0]


def test_what_the_other_recordings_say_is_as_likely_in_them_as_what_all_say_even_where_one_pulls_far(
    tmp_path: Path,
) -> None:
    """The recordings lie: one of them has a payload of which the search knows nothing."""
    paths = []
    for k, hidden in enumerate(((), (("payload", {}, {"mass": 2.0, "x": 0.2, "y": 0.0, "z": 0.0}),))):
        draw = Draw(seed=12, vehicle="ngs", deviations=0.0, effects=hidden, kinds=("steps",), duration=14.0)
        (topics,) = recorded(draw, MODEL.vehicle, MODEL.sets, MODEL.sensors)
        paths.append(write_run(tmp_path / f"run_{k}", topics))
    logs, model = read_logs(paths, MODEL)
    found = search(model, logs, only=lambda h: False)
    stage = found.stages[-1]
    for left_out, other in ((0, 1), (1, 0)):
        without = fit_without(stage.screen, stage.fit, found.nuisances, left_out)
        alone = Screen(model=model, runs=[stage.screen.runs[other]], values={})
        there = Problem(screen=alone, nuisances=found.nuisances, effects=())
        assert there.score(without.moved, []) > there.score(stage.fit.moved, []) - 1.0
        predicted = without_run(stage.screen, stage.fit, found.nuisances, left_out)
        assert not any(key[0] == "trim" for key in predicted.values)  # of a dive that was not seen it is not known
    assert all(np.isfinite(errors.with_effect["attitude"]) for errors in left_out_errors(found, [2.0]))
