"""Delays and drifts are found from where they begin: nothing that is small leads to them."""

from pathlib import Path
from typing import Any

import pytest
from restamped import restamped

from gap_diagnosis.vehicle import beginning
from gap_diagnosis.vehicle.beginning import RoughFit, beyond_numbers, delays_in, foreseen
from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.hypotheses import hypotheses
from gap_diagnosis.vehicle.log import told_in
from gap_diagnosis.vehicle.log_io import read_logs
from run_bag import write_run


@pytest.mark.parametrize("rate", [0.008, -0.006])
def test_a_drift_of_a_third_of_a_second_is_a_drift_and_no_delay(rate: float, tmp_path: Path) -> None:
    draw = Draw(seed=12, vehicle="ngs", kinds=("steps",), duration=40.0)
    model = load_model(draw.vehicle)
    topics = recorded(draw, model.vehicle, model.sets, model.sensors)[0]
    topics = restamped(topics, "throttle", lambda t: t * (1.0 - rate))
    logs, model = read_logs([write_run(tmp_path / "run", topics)], model)
    found = delays_in(model, logs, hypotheses(model, told_in(logs)), foreseen(model, logs, ()))
    (_, likeliest), *_ = sorted(found, key=lambda each: -each[0])
    assert likeliest.hypothesis.effect == "clock_drift"
    assert likeliest.sizes[0] == pytest.approx(rate, rel=0.1)


@pytest.mark.parametrize(("from_there", "late"), [(195.0, False), (120.0, True)])
def test_a_delay_is_none_where_numbers_do_as_well_once_they_are_where_it_led_to(
    from_there: float, late: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    there = {("vehicle", "mass"): 0.3}

    def rough(model: Any, logs: Any, free: Any, on: Any, values: Any = None) -> RoughFit:
        likelihood = 200.0 if on else from_there if values == there else 100.0
        return RoughFit(likelihood, 1000.0, there if on or values else {}, tuple(on))

    monkeypatch.setattr(beginning, "_rough", rough)
    a_delay: Any = object()
    model: Any = None
    found, values = beyond_numbers(model, [], {}, [(500.0, a_delay)])
    assert [own for own, _ in found] == ([500.0] if late else [])
    assert values == there


def test_a_delay_of_two_sizes_is_tried_as_one(tmp_path: Path) -> None:
    draw = Draw(seed=12, vehicle="ngs", kinds=("steps",), duration=20.0)
    model = load_model(draw.vehicle)
    topics = recorded(draw, model.vehicle, model.sets, model.sensors)[0]
    topics = restamped(topics, "throttle", lambda t: t - 0.2)
    logs, model = read_logs([write_run(tmp_path / "run", topics)], model)
    lags = [h for h in hypotheses(model, told_in(logs)) if h.effect == "command_lag"]
    nothing = foreseen(model, logs, ())
    ((gain, lag),) = delays_in(model, logs, lags, nothing)
    assert len(lag.sizes) == 2 and lag.sizes[0] == pytest.approx(0.2, abs=0.1)
    ((_, fit),), _ = beyond_numbers(model, logs, {}, [(gain, lag)])
    assert len(fit.effects[0].sizes) == 2 and fit.likelihood > nothing
