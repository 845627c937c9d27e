"""The next experiment settles what the recordings at hand leave open: with its recording, the answer is right."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.content import _proposed
from gap_diagnosis.vehicle.diagnosis_io import Diagnosed, diagnosed, load_model, written
from gap_diagnosis.vehicle.filtering import foreseen
from gap_diagnosis.vehicle.hypotheses import Hypothesis, hypotheses
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.log_io import read_logs
from gap_diagnosis.vehicle.next_experiment import NextExperiment, Separation
from gap_diagnosis.vehicle.programmes import DryRun, Limits, Programme
from run_bag import read_run, write_run

TRIED = ("thrust_loss", "thrust_asymmetry")
MODEL = load_model("ngs")


def noisy(log: VehicleLog, seed: int) -> VehicleLog:
    """Return a recording that was foreseen as sensors tell it."""
    rng = np.random.default_rng(seed)
    told = log.told + np.nan_to_num(log.noise) * rng.normal(size=log.told.shape)
    turn = 0.5 * log.noise[0] * rng.normal(size=(log.count, 3))
    w, v = log.attitude[:, :1], log.attitude[:, 1:]
    attitude = np.hstack((w - np.sum(v * turn, axis=1, keepdims=True), v + w * turn + np.cross(v, turn)))
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    speeds = log.speeds + log.speed_noise * rng.normal(size=log.speeds.shape)
    battery = log.battery + np.nan_to_num(log.battery_noise) * rng.normal(size=log.battery.shape)
    return replace(log, told=told, attitude=attitude, speeds=speeds, battery=battery)


def asymmetric(like: VehicleLog, throttles: NDArray[np.float64], seed: int) -> VehicleLog:
    """Return what sensors tell of a vehicle whose thruster 2 pushes a third less in reverse alone."""
    hidden = next(
        h
        for h in hypotheses(MODEL, like.there)
        if h.effect == "thrust_asymmetry" and h.thruster == 2
    )  # fmt: skip
    return noisy(foreseen(MODEL, like, throttles, {}, [hidden.active((0.35,))])[0], seed)


@pytest.fixture(scope="module")
def like(tmp_path_factory: pytest.TempPathFactory) -> VehicleLog:
    draw = Draw(seed=12, vehicle="ngs", kinds=("steps",), duration=14.0)
    topics = next(iter(recorded(draw, MODEL.vehicle, MODEL.sets, MODEL.sensors)))
    return read_logs([write_run(tmp_path_factory.mktemp("like") / "run", topics)], MODEL)[0][0]


def told(logs: list[VehicleLog], limits: Limits | None = None, how_far: bool = False) -> Diagnosed:
    def few(h: Hypothesis) -> bool:
        return h.effect in TRIED and h.thruster is not None

    return diagnosed(MODEL, logs, {"runs": ["foreseen"]}, only=few, how_far=how_far, experiment=limits)


def planned(now: float, then: float, hidden_then: int = 3) -> NextExperiment:
    """Return a proposal about one pair, with 3 effects that these recordings hide."""
    loss, asymmetry = (
        next(h for h in hypotheses(MODEL, {}) if (h.effect, h.thruster) == (effect, 2)) for effect in TRIED
    )
    programme = Programme(
        words="a sweep of surge", throttles=np.zeros((25, 6)), period=0.04,
        dry_run=DryRun(tilt=0.1, depth=0.1, speed=0.1, level=2.0),
    )  # fmt: skip
    pair = Separation(first=loss, second=asymmetry, now=now, then=then)
    return NextExperiment(programme=programme, separates=(pair,), hidden_now=3, hidden_then=hidden_then)


def test_what_tells_a_pair_apart_is_what_a_programme_adds_to_recordings_that_did_not() -> None:
    little, much, some = planned(6.9, 7.1), planned(6.9, 9.0), planned(6.9, 7.5)
    assert little.separates[0].added == pytest.approx((7.1**2 - 6.9**2) ** 0.5)
    assert not little.helps and planned(6.9, 7.1, hidden_then=1).helps, "it is not proposed for 1.7 sigma"
    assert _proposed(much)["why"].startswith("it tells 1 of 1 pairs apart; ")
    says = _proposed(some)["why"]
    assert says.startswith("it adds 2.9 of the 5 σ that tell a pair apart: played 3 times it does; ")
    assert says.endswith("of 3 effects that could not be shown at any size it leaves 3")
    assert _proposed(some)["separates"][0]["added"] == 2.94


@pytest.mark.long
def test_what_one_way_alone_cannot_tell_the_next_recording_tells(like: VehicleLog, tmp_path: Path) -> None:
    time = like.period * np.arange(like.count)
    # thruster 2 in reverse alone: less thrust there is a loss, or an asymmetry
    throttles = np.zeros((like.count, MODEL.thrusters))
    throttles[:, 2] = np.where(np.sin(2.0 * np.pi * time / 8.0) > 0.0, -2.0, 0.0)
    throttles[:, 3] = -throttles[:, 2]
    first = asymmetric(like, throttles, 1)
    found = told([first], Limits())
    assert found.proposed is not None
    apart = [s for s in found.proposed.separates if {s.first.effect, s.second.effect} == set(TRIED)]
    assert apart and all(s.now < 5.0 < s.then for s in apart if s.first.thruster == s.second.thruster == 2)

    again = told([first, asymmetric(like, found.proposed.programme.throttles, 2)], how_far=True)
    effects = again.content["effects"]
    assert [(e["id"], e["thruster"]) for e in effects] == [("thrust_asymmetry", 2)]
    assert effects[0]["probability"] > 0.9 and not effects[0]["indistinguishable_from"]

    budget = again.content["budget"]
    (cause,) = budget["causes"]
    assert cause["share"] > 0.5 and cause["interval"][0] > 0.0
    assert budget["parameters"]["share"] + cause["share"] + budget["unexplained"]["share"] == pytest.approx(1.0)

    paths = {path.name: path for path in written(found, tmp_path / "out")}
    planned = found.content["next_experiment"]
    run = read_run(paths[planned["file"]])
    assert run.duration == pytest.approx(planned["duration_s"], abs=0.1)
    assert planned["hidden"] <= planned["hidden_now"]
    assert "What would settle it" in paths["report.html"].read_text("utf-8")
