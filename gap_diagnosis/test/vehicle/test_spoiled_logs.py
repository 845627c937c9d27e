"""Recordings of a vehicle with everything wrong that happens: an answer or a sentence each."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.cli_diagnose_vehicle import main
from gap_diagnosis.vehicle.diagnosis_io import diagnosed, load_model
from gap_diagnosis.vehicle.log_io import log_of
from gap_diagnosis.vehicle.wiring import wiring_of
from run_bag import Channel, Run, RunError, Topic, read_run, write_run

DURATION = 12.0
YEAR = round(365.25 * 86400e9)
SENSORS = {
    "gyro": "imu.angular", "accelerometer": "imu.linear", "attitude": "orientation", "velocity": "rov/velocity",
    "depth": "depth", "battery": "battery", "speeds": "state.n", "throttles": "throttle",
}  # fmt: skip
Change = Callable[[Any, Any], tuple[Any, Any]]


def valued(value: float, part: slice) -> Change:
    def change(stamps: Any, values: Any) -> tuple[Any, Any]:
        values[part] = value
        return stamps, values

    return change


def without(seconds: tuple[float, float]) -> Change:
    def change(stamps: Any, values: Any) -> tuple[Any, Any]:
        time = 1e-9 * (stamps - stamps[0])
        keep = (time < seconds[0]) | (time > seconds[1])
        return stamps[keep], values[keep]

    return change


SPOILED: dict[str, Change] = {
    "NaN at times": valued(np.nan, slice(3, None, 7)),
    "NaN for seconds": valued(np.nan, slice(20, 60)),
    "never a number": valued(np.nan, slice(None)),
    "infinite at times": valued(np.inf, slice(3, None, 7)),
    "one value always": valued(1.0, slice(None)),
    "zero always": valued(0.0, slice(None)),
    "gap": without((3.0, 8.0)),
    "one reading": lambda s, v: (s[:1], v[:1]),
    "all at one instant": lambda s, v: (np.full_like(s, s[0]), v),
    "another clock": lambda s, v: (s + 50 * YEAR, v),
    "a year's pause": lambda s, v: (np.where(np.arange(s.size) < s.size // 2, s, s + YEAR), v),
}
REFUSED = {
    ("throttles", "never a number"): "expected thruster_<i>/throttle",
}  # the others of the table above are answered


@pytest.fixture(scope="module")
def topics() -> list[Topic]:
    model = load_model("ngs")
    draw = Draw(seed=12, vehicle="ngs", deviations=0.7, kinds=("steps",), duration=DURATION)
    return recorded(draw, model.vehicle, model.sets, model.sensors)[0]


@pytest.fixture(scope="module")
def run(topics: list[Topic], tmp_path_factory: pytest.TempPathFactory) -> Run:
    return read_run(write_run(tmp_path_factory.mktemp("sound") / "run", topics))


def spoiled(run: Run, words: str, change: Change) -> Run:
    """Return a run whose channels with these words in their names are changed."""
    channels = {}
    for name in run:
        one = run[name]
        given = (one.stamps.copy(), one.values.copy())
        stamps, values = change(*given) if words in name else given
        channels[name] = Channel(name=name, stamps=stamps, values=values)
    return Run(name="spoiled", channels=channels)


@pytest.mark.parametrize("how", SPOILED)
@pytest.mark.parametrize("sensor", SENSORS)
def test_a_spoiled_sensor_is_left_out_or_read_as_far_as_it_goes(run: Run, sensor: str, how: str) -> None:
    change = spoiled(run, SENSORS[sensor], SPOILED[how])
    if (sensor, how) in REFUSED:
        with pytest.raises(RunError, match=REFUSED[sensor, how]):
            log_of(change, 6)
        return
    log = log_of(change, 6)
    assert np.isfinite(log.throttles).all() and log.count * log.period < 2.0 * DURATION
    for told in (log.told, log.attitude, log.speeds, log.battery):
        assert not np.isinf(told).any()
    others = [name for name, there in log.there.items() if not there]
    assert len(others) <= 1 or log.count == 1, others
    K_t = load_model("ngs").vehicle.configuration
    assert wiring_of([log], K_t, np.eye(6)).verdict in ("as_stated", "cannot_tell", "wrong")


@pytest.mark.parametrize("value", [1e30, -1e300])
@pytest.mark.parametrize("sensor", SENSORS)
def test_a_reading_that_no_vehicle_gives_is_refused_by_name_and_time(run: Run, sensor: str, value: float) -> None:
    with pytest.raises(RunError, match=rf"{SENSORS[sensor]}.*: expected readings up to 1e\+06; found .* at \d+\.\d+ s"):
        log_of(spoiled(run, SENSORS[sensor], valued(value, slice(30, 31))), 6)


def test_a_reading_of_attitude_that_is_missing_takes_no_other_with_it(run: Run) -> None:
    log = log_of(spoiled(run, "orientation.w", SPOILED["NaN at times"]), 6)
    assert log.there["attitude"] and np.isfinite(log.attitude).mean() > 0.7


def test_a_pause_of_a_year_is_refused_with_its_place(run: Run) -> None:
    told = r"expected at most \d+ instants of 0.04 s for \d+ readings .* found \d{9}; for 3\d{7} s from \d\.\d s on"
    with pytest.raises(RunError, match=told):
        log_of(spoiled(run, "", SPOILED["a year's pause"]), 6)


def test_a_thruster_that_was_never_commanded_is_named(run: Run) -> None:
    log = log_of(spoiled(run, "thruster_2/throttle", SPOILED["zero always"]), 6)
    found = wiring_of([log], load_model("ngs").vehicle.configuration, np.eye(6))
    assert 2 in found.silent and "Thruster 2 was never commanded" in " ".join(found.sentences)


@pytest.mark.parametrize("how", ["one value always", "all at one instant"])
def test_where_nothing_moved_nothing_is_said(run: Run, how: str) -> None:
    log = log_of(spoiled(run, "", SPOILED[how]), 6)
    found = diagnosed(load_model("ngs"), [log], {"runs": ["spoiled"]}, only=lambda h: False, how_far=False)
    assert found.content["verdict"] == "not_enough_data" and json.dumps(found.content, allow_nan=False)


@pytest.mark.parametrize(
    ("arguments", "left_out", "said"),
    [
        (["--vehicle", "ngs", "--period", "0"], "", "period of the filter [s]: expected a number above 0; found 0"),
        (["--vehicle", "ngs", "--period", "1e-9"], "", "expected at most"),
        (["--vehicle", "ngs"], "throttle", "expected thruster_<i>/throttle"),
        (["--vehicle", "ngs"], "rov/", "expected rov/imu or rov/odometry"),
    ],
)
def test_the_command_answers_with_a_sentence_and_writes_nothing(
    topics: list[Topic], arguments: list[str], left_out: str, said: str, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    path = write_run(tmp_path / "run", [t for t in topics if not left_out or left_out not in t.name])
    assert main([str(path), *arguments, "--out", str(tmp_path / "out")]) == 1
    told = capsys.readouterr().err
    assert said in told and len(told.splitlines()) == 1
    assert not (tmp_path / "out").exists()
