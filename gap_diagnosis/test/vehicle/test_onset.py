"""Failures that begin in mid-run: which effects are on when, a filter that goes on, and when one began."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.diagnosis_io import Diagnosed, diagnosed, load_model, written
from gap_diagnosis.vehicle.filtering import Filtered, filtered, prepared_with
from gap_diagnosis.vehicle.hypotheses import Hypothesis, hypotheses
from gap_diagnosis.vehicle.learning import first_noises
from gap_diagnosis.vehicle.log_io import read_logs
from gap_diagnosis.vehicle.onset import Begun, Onset, on_in, pieces
from gap_diagnosis.vehicle.onset_search import begun_nearby
from rov_sim.vehicle.effects.active import ActiveVehicleEffect
from run_bag import write_run
from thruster_model.vehicle_set_io import load_vehicle_set

ONSET = Onset(run=1, name="dive", instant=500, period=0.04, last=2, among=100)
LATE = Begun(id="thrust_loss", sizes={"share": 0.5}, thruster=0, onset=ONSET)
ALWAYS = ActiveVehicleEffect(id="thrust_loss", sizes={"share": 0.2}, thruster=1)


def test_an_effect_is_on_from_its_onset_to_its_last_recording_and_in_those_to_come() -> None:
    assert [LATE in on_in([ALWAYS, LATE], run) for run in (-1, 0, 1, 2, 3)] == [True, False, True, True, False]
    assert all(ALWAYS in on_in([ALWAYS, LATE], run) for run in (-1, 0, 1, 2, 3))


@pytest.mark.parametrize(
    ("run", "cut", "count", "expected"),
    [
        (0, 0, 900, [(0, 1)]), (2, 0, 900, [(0, 2)]), (1, 0, 900, [(0, 1), (500, 2)]),
        (1, 480, 100, [(0, 1), (20, 2)]), (1, 600, 100, [(0, 2)]), (1, 0, 400, [(0, 1)]),
    ],
)  # fmt: skip
def test_a_recording_is_in_pieces_where_an_effect_begins_within_it(
    run: int, cut: int, count: int, expected: list[tuple[int, int]]
) -> None:
    found = [(first, len(on)) for first, on in pieces([ALWAYS, LATE], run, cut, count)]
    assert found == [each for each in expected if each[0] < count]


@pytest.mark.parametrize(
    ("earliest", "latest", "last", "words"),
    [
        (495, 505, 1, "from 20.0 s of dive on"), (450, 500, 1, "from somewhere between 18.0 and 20.0 s of dive on"),
        (500, 500, 2, "from 20.0 s of dive on, later recordings included"),
    ],
)  # fmt: skip
def test_an_onset_says_when_and_how_surely(earliest: int, latest: int, last: int, words: str) -> None:
    assert ONSET._replace(earliest=earliest, latest=latest, last=last).words == words


@pytest.fixture(scope="module")
def followed(tmp_path_factory: pytest.TempPathFactory) -> Any:
    draw = Draw(seed=31, vehicle="ngs", kinds=("steps",), duration=16.0)
    model = load_model("ngs")
    (topics,) = recorded(draw, model.vehicle, model.sets, model.sensors)
    (log,), model = read_logs([write_run(tmp_path_factory.mktemp("onset") / "run", topics)], model)
    prepared = prepared_with(model, log, 1, first_noises(model, [log]), {})

    def follow(*effects: ActiveVehicleEffect) -> Filtered:
        return filtered(model, prepared, {}, effects)

    return follow


def begun(share: float, instant: int) -> Begun:
    return Begun(id="thrust_loss", sizes={"share": share}, thruster=0, onset=ONSET._replace(instant=instant))


def test_a_filter_goes_on_where_an_effect_begins_that_does_nothing(followed: Any) -> None:
    one, two = followed(), followed(begun(0.0, 201))
    assert one.done and two.done
    for name in ("body", "rotor", "battery", "states"):
        np.testing.assert_allclose(getattr(two, name), getattr(one, name), rtol=0.0, atol=1e-12)


def test_before_its_onset_an_effect_does_nothing_and_long_after_it_what_it_always_does(followed: Any) -> None:
    none, late = followed(), followed(begun(0.6, 201))
    always = followed(ActiveVehicleEffect(id="thrust_loss", sizes={"share": 0.6}, thruster=0))
    np.testing.assert_array_equal(late.body[:201], none.body[:201])
    there, otherwise = np.nan_to_num(late.body[300:] - always.body[300:]), np.nan_to_num(late.body - none.body)
    assert np.abs(otherwise[201:250]).max() > 1e-3
    assert np.abs(there).max() < 0.02 * np.abs(otherwise).max(), "a filter forgets"


def test_a_rotor_that_stops_stands_still_from_then_on(followed: Any) -> None:
    stop = Begun(id="thruster_failure", sizes={"failed": 1.0}, thruster=0, kind="stopped", onset=ONSET)
    turning = followed().rotor[:, 0]
    stopped = followed(replace(stop, onset=ONSET._replace(instant=201))).rotor[:, 0]
    np.testing.assert_array_equal(stopped[:201], turning[:201])
    assert np.nanmax(np.abs(stopped[203:])) > 20.0, "its tachometer reads what it does not do"


def test_only_failures_of_single_parts_may_begin_in_mid_run() -> None:
    there = dict.fromkeys(("attitude", "gyro", "accelerometer", "depth", "velocity", "tachometer", "battery"), True)
    found: list[Hypothesis] = [h for h in hypotheses(load_model("ngs"), there) if h.begins]
    assert {h.effect for h in found} == {
        "thrust_loss", "thruster_failure", "tach_scale", "imu_bias", "buoyancy_offset", "velocity_scale",
    }  # fmt: skip
    assert all(h.thruster is not None for h in found if h.effect in ("thrust_loss", "tach_scale"))


@dataclass(frozen=True, kw_only=True)
class Peaked:
    """A problem whose log likelihood has a narrow peak, and a lower hill that the first look meets on its top."""

    effects: tuple[Hypothesis, ...]
    screen: Any
    _points: dict[Any, Any] = field(default_factory=dict)
    _made: dict[Any, Any] = field(default_factory=dict)

    def score_of(self, k: int, moved: Any, sizes: Any) -> float:
        at = self.effects[0].since.instant  # type: ignore[union-attr]
        assert k == ONSET.run
        return max(-2000.0, -300.0 * abs(at - 507), -900.0 - 100.0 * abs(at - 475))


@pytest.mark.parametrize("begin", [450, 500, 550])
def test_an_onset_is_found_whose_peak_is_narrower_than_the_first_look(begin: int) -> None:
    there = dict.fromkeys(("attitude", "gyro", "accelerometer", "depth", "velocity", "tachometer", "battery"), True)
    loss = next(h for h in hypotheses(load_model("ngs"), there) if h.effect == "thrust_loss" and h.thruster == 0)
    log = SimpleNamespace(cut=400, count=200, period=0.04)
    screen = SimpleNamespace(runs=[SimpleNamespace(log=log)] * 2)
    problem: Any = Peaked(effects=(replace(loss, since=ONSET._replace(instant=begin)),), screen=screen)
    found = begun_nearby(problem, np.zeros(1), [(0.5,)]).effects[0].since
    assert found is not None
    assert (found.instant, found.earliest, found.latest) == (507, 507, 507)


def failing(folder: Path, begins: tuple[int, float, int]) -> Diagnosed:
    hidden: Any = (("thrust_loss", {"thruster": 2}, {"share": 0.4}),)
    draw = Draw(
        seed=11, vehicle="ngs", effects=hidden, kinds=("steps", "sines"), duration=30.0, begins=begins
    )  # fmt: skip
    model = load_model(draw.vehicle)
    runs = [
        write_run(folder / f"run_{k}", topics)
        for k, topics in enumerate(recorded(draw, model.vehicle, model.sets, model.sensors))
    ]
    logs, model = read_logs(runs, model)
    tried = ("thrust_loss", "buoyancy_offset", "velocity_scale", "cavitation")
    return diagnosed(model, logs, {"runs": ["sealed"]}, only=lambda h: h.effect in tried)


@pytest.mark.parametrize(
    ("begins", "lasts"),
    [
        pytest.param((0, 17.3, 1), True, marks=pytest.mark.long),
        pytest.param((0, 17.3, 0), False, marks=pytest.mark.long),
        ((1, 12.6, 1), False),
    ],
)
def test_a_thruster_that_loses_thrust_in_mid_run_is_named_with_when_and_how_much(
    begins: tuple[int, float, int], lasts: bool, tmp_path: Path
) -> None:
    found = failing(tmp_path, begins)
    (effect,), run = found.content["effects"], begins[0]
    assert (found.content["verdict"], effect["id"], effect["thruster"]) == ("effect", "thrust_loss", 2)
    assert (effect["since"]["recording"], effect["since"]["lasts"]) == (f"run_{run}", lasts)
    assert effect["since"]["time_s"] == pytest.approx(begins[1], abs=0.2)
    first, latest = effect["since"]["interval_s"]
    assert first - 0.2 < begins[1] < latest + 0.2 and latest - first < 0.5
    size = effect["parameters"]["share"]
    assert abs(size["value"] - 0.4) < 4.0 * size["std"] < 0.2
    assert f"from {effect['since']['time_s']:.1f} s of run_{run} on" in found.content["summary"]
    if begins == (1, 12.6, 1):
        written(found, tmp_path / "out")
        assert "from 12.6 s of run_1 on" in (tmp_path / "out" / "report.html").read_text("utf-8")
        (on,) = load_vehicle_set(str(tmp_path / "out" / "with_effect.yaml")).effects
        assert (on.id, on.thruster, on.sizes["share"]) == ("thrust_loss", 2, pytest.approx(size["value"]))
