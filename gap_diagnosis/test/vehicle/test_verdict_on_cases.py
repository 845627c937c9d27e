"""From recordings to a verdict: cases of the sealed generator, with few hypotheses so that they are quick."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from restamped import restamped

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.blind.scoring import scored
from gap_diagnosis.vehicle.diagnosis_io import Diagnosed, diagnosed, load_model, written
from gap_diagnosis.vehicle.log_io import read_logs
from gap_diagnosis.vehicle.nuisances import nuisances
from run_bag import write_run
from thruster_model.vehicle_set_io import load_vehicle_set

FEW = ("thrust_loss", "buoyancy_offset", "velocity_scale")


def of(folder: Path, draw: Draw, tried: tuple[str, ...] = FEW, *, how_far: bool = False) -> Diagnosed:
    model = load_model(draw.vehicle)
    paths = [
        write_run(folder / f"run_{k}", topics)
        for k, topics in enumerate(recorded(draw, model.vehicle, model.sets, model.sensors))
    ]
    logs, model = read_logs(paths, model)
    return diagnosed(model, logs, {"runs": ["sealed"]}, only=lambda h: h.effect in tried, how_far=how_far)


@pytest.fixture(scope="module")
def lossy(tmp_path_factory: pytest.TempPathFactory) -> Diagnosed:
    hidden: Any = (("thrust_loss", {"thruster": 2}, {"share": 0.4}),)
    draw = Draw(seed=11, vehicle="ngs", effects=hidden, kinds=("steps",), duration=40.0)
    return of(tmp_path_factory.mktemp("lossy"), draw, how_far=True)


def test_a_loss_of_thrust_is_named_on_its_thruster(lossy: Diagnosed) -> None:
    content = lossy.content
    assert content["verdict"] == "effect"
    first = content["effects"][0]
    assert (first["id"], first["thruster"]) == ("thrust_loss", 2)


def test_a_thruster_that_stands_still_is_named_with_its_kind(tmp_path: Path) -> None:
    hidden: Any = (("thruster_failure", {"thruster": 1, "kind": "stopped"}, {}),)
    draw = Draw(seed=12, vehicle="ngs", effects=hidden, kinds=("steps",), duration=20.0)
    content = of(tmp_path, draw, (*FEW, "thruster_failure")).content
    named = [(e["id"], e["thruster"], e["kind"], e["parameters"]) for e in content["effects"]]
    assert (content["verdict"], named) == ("effect", [("thruster_failure", 1, "stopped", {})])
    assert content["effects"][0]["probability"] > 0.9


def test_the_size_of_a_loss_of_thrust_lies_within_its_deviations(lossy: Diagnosed) -> None:
    size = lossy.content["effects"][0]["parameters"]["share"]
    assert abs(size["value"] - 0.4) < 3.0 * size["std"] < 0.12


def test_what_a_nuisance_took_over_before_the_effect_was_there_it_gives_back(lossy: Diagnosed) -> None:
    thrust = [p for name, p in lossy.content["retuned_parameters"].items() if name.startswith("thrust")]
    assert all(abs(p["deviations"]) < 4.0 for p in thrust)


def test_effects_that_need_a_number_far_from_what_is_stated_only_resemble(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rules, "HELD", 1.6)
    hidden: Any = (("thrust_loss", {"thruster": 2}, {"share": 0.4}),)
    content = of(tmp_path, Draw(seed=11, vehicle="ngs", effects=hidden, kinds=("steps",), duration=20.0)).content
    assert max(abs(p["deviations"]) for p in content["retuned_parameters"].values()) > 1.6
    assert (content["verdict"], content["effects"]) == ("unknown", []) and content["p_unknown"] >= 0.95
    assert [e["id"] for e in content["resembles"]] == ["thrust_loss"]
    assert "deviations from what is stated" in content["summary"]


def test_numbers_far_from_what_is_stated_only_resemble_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rules, "HELD", 1.6)
    content = of(tmp_path, Draw(seed=11, vehicle="ngs", kinds=("steps",), duration=20.0)).content
    assert max(abs(p["deviations"]) for p in content["retuned_parameters"].values()) > 1.6
    assert (content["verdict"], content["resembles"]) == ("unknown", []) and content["p_unknown"] >= 0.95
    assert "So far off is either what is stated, or what the model takes for it" in content["summary"]


def test_what_is_written_is_complete_and_the_set_can_be_loaded(lossy: Diagnosed, tmp_path: Path) -> None:
    paths = {path.name: path for path in written(lossy, tmp_path / "out")}
    content = json.loads(paths["diagnosis.json"].read_text("utf-8"))
    assert {"verdict", "gap", "where", "effects", "candidates", "p_none", "p_unknown", "hidden"} <= set(content)
    assert sum(w["share"] for w in content["where"]) == pytest.approx(1.0, abs=2e-3)
    effect = load_vehicle_set(paths["with_effect.yaml"]).effects[0]
    assert (effect.id, effect.thruster) == ("thrust_loss", 2)
    assert "Diagnosis of" in paths["report.html"].read_text("utf-8")


def test_the_set_that_is_written_has_the_numbers_re_tuned_and_marks_those_beyond_their_deviations(
    lossy: Diagnosed, tmp_path: Path
) -> None:
    vehicle = load_vehicle_set(str(next(p for p in written(lossy, tmp_path / "out") if p.name == "with_effect.yaml")))
    stated, moved = lossy.model.vehicle, lossy.content["retuned_parameters"]
    changed = {n for n, p in vehicle.parameters.items() if p.source.startswith("fitted to recordings")}
    begun = {"x_G": 0.0, "y_G": 0.0, "z_G": 0.0, **stated.values}  # a centre of mass that is not stated is the origin
    assert changed and all(vehicle.values[n] != begun[n] for n in changed)
    assert all(vehicle.parameters[n] == stated.parameters[n] for n in set(stated.parameters) - changed)
    for n in changed:
        far = abs(vehicle.values[n] - begun[n]) / nuisances(lossy.model, [])["vehicle", n]
        assert ("stated deviations away" in vehicle.parameters[n].source) == (far > 3.0)
        assert n not in moved or far == pytest.approx(abs(moved[n]["deviations"]), abs=0.2)


def test_a_single_recording_is_said_to_have_left_none_out(lossy: Diagnosed, tmp_path: Path) -> None:
    assert lossy.content["gap"]["left_out"] is False
    report = next(p for p in written(lossy, tmp_path / "out") if p.name == "report.html").read_text("utf-8")
    assert "none was left out" in report and "numbers of the others" not in report


def test_the_keys_of_a_single_thrusters_diagnosis_are_there(lossy: Diagnosed) -> None:
    gap, (effect,) = lossy.content["gap"], lossy.content["effects"]
    assert gap["total"]["as_is"] > gap["total"]["with_effect"] and gap["total"]["noise_floor"] == 1.0
    assert gap["shrink"] == pytest.approx(effect["shrink"])
    assert all(channel["noise_floor"] > 0.0 for channel in gap["channels"].values())
    # numbers re-tuned on this one recording do as well: what they leave is within two standard errors of none
    assert effect["class"] == "parametric" and effect["shrink"] is None
    assert effect["probability"] <= effect["group_probability"] <= 1.0 and effect["group_probability"] > 0.96
    assert "water_current" in lossy.content["not_tried"] and not set(FEW) & set(lossy.content["not_tried"])
    assert lossy.content["resembles"] == [] and lossy.content["log"] == []
    budget = lossy.content["budget"]
    assert budget["why_not"] is None and budget["parameters"] is not None


@pytest.mark.long
def test_a_thruster_the_wrong_way_round_is_named_and_nothing_beside_it(tmp_path: Path) -> None:
    hidden: Any = (("thruster_polarity", {"thruster": 1}, {}),)
    draw = Draw(seed=1215, vehicle="ngs", effects=hidden, wrench=0.28, time=5.0, noise=0.64, kinds=("steps",))
    content = of(tmp_path, draw, ("thruster_polarity", "thrust_loss", "entrained_water")).content
    assert content["verdict"] == "effect"
    assert [(e["id"], e["thruster"]) for e in content["effects"]] == [("thruster_polarity", 1)]


@pytest.mark.long
def test_a_thruster_that_has_stopped_is_neither_wired_wrongly_nor_limited(tmp_path: Path) -> None:
    tried = ("thruster_failure", "thruster_polarity", "throttle_saturation")
    hidden: Any = (("thruster_failure", {"thruster": 5, "kind": "stopped"}, {}),)
    draw = Draw(
        seed=1489, vehicle="ngs", effects=hidden, wrench=0.05, time=3.7, noise=0.52, kinds=("pulses", "sines")
    )  # fmt: skip
    content = of(tmp_path, draw, tried).content
    assert [(e["id"], e["kind"], e["thruster"]) for e in content["effects"]] == [("thruster_failure", "stopped", 5)]


def test_numbers_that_are_off_within_their_deviations_are_what_a_gap_comes_from(tmp_path: Path) -> None:
    draw = Draw(seed=12, vehicle="ngs", deviations=0.7, kinds=("steps",), duration=40.0)
    content = of(tmp_path, draw, how_far=True).content
    assert (content["verdict"], content["effects"]) == ("parameters", [])
    as_is, retuned = (step["rms"] for step in content["budget"]["left_out"])
    assert as_is > 15.0 and retuned < 2.0 and content["budget"]["parameters"]["interval"][0] > 0.0
    assert f"by {as_is:.2f} times" in content["summary"] and f"re-tuned, by {retuned:.2f} times" in content["summary"]


@pytest.mark.parametrize(
    ("outside", "seed", "axes", "of_it"),
    [
        ("sliding_water", 1552, ("roll", "pitch"), "late"),
        ("vibration", 1594, ("accelerometer x", "accelerometer z"), "rotors"),
        ("moving_arm", 1582, ("pitch",), "nothing recorded"),
    ],
)
def test_what_no_library_has_is_unknown_and_what_it_goes_with_is_said(
    outside: str, seed: int, axes: tuple[str, ...], of_it: str, tmp_path: Path
) -> None:
    draw = Draw(seed=seed, vehicle="ngs", outside=outside, wrench=0.1, kinds=("steps",), duration=40.0)
    content = of(tmp_path, draw).content
    assert (content["verdict"], content["effects"]) == ("unknown", []) and content["p_unknown"] >= 0.9
    first = content["unexplained"][0]
    assert first["signal"] in axes and of_it in first["depends_on"]
    assert f"{first['signal']} and goes with {first['depends_on']}" in content["summary"]


def test_a_drag_that_a_number_of_the_vehicle_had_taken_over_is_named(tmp_path: Path) -> None:
    hidden: Any = (("quadratic_drag", {"axis": "yaw"}, {"share": 0.75}),)
    draw = Draw(
        seed=21, vehicle="ngs", effects=hidden, wrench=0.02, noise=0.3, kinds=("steps", "sines"), duration=40.0
    )  # fmt: skip
    content = of(tmp_path, draw, ("quadratic_drag", "linear_drag", "thrust_loss")).content
    (claimed,) = content["effects"]
    assert (content["verdict"], claimed["id"], claimed["axis"]) == ("effect", "quadratic_drag", "yaw")
    size = claimed["parameters"]["share"]
    assert abs(size["value"] - 0.75) < 3.0 * size["std"] < 0.3


def test_marks_ask_for_effect_and_place() -> None:
    hidden = [{"id": "thrust_loss", "thruster": 2, "sizes": {"share": 0.4}}]
    said = {
        "id": "thrust_loss", "thruster": 2, "other": None, "axis": None, "probability": 0.9,
        "indistinguishable_from": [], "parameters": {"share": {"value": 0.38, "std": 0.03}},
    }  # fmt: skip
    right = scored(hidden, "", {"verdict": "effect", "effects": [said]})
    wrong = scored(hidden, "", {"verdict": "effect", "effects": [{**said, "thruster": 3}]})
    assert right["right"] and right["sizes"] == [[0.4, 0.38, 0.03]] and right["wrong_sure"] == 0
    assert not wrong["right"] and wrong["wrong_sure"] == 1 and wrong["thruster"] is False


@pytest.mark.parametrize(
    ("effect", "size", "of", "stamp"),
    [
        pytest.param("log_alignment", 0.08, "throttle", lambda t: t + 0.08, marks=pytest.mark.long),
        ("imu_delay", 0.14, "rov/imu", lambda t: t + 0.14),
        pytest.param("clock_drift", -0.002, "throttle", lambda t: t * 1.002, marks=pytest.mark.long),
    ],
)
def test_stamps_that_are_wrong_are_an_effect_of_their_log(
    effect: str, size: float, of: str, stamp: Callable[[Any], Any], tmp_path: Path
) -> None:
    draw = Draw(seed=12, vehicle="ngs", kinds=("steps",), duration=20.0)
    model = load_model(draw.vehicle)
    topics = recorded(draw, model.vehicle, model.sets, model.sensors)[0]
    wrong = restamped(topics, of, stamp)
    logs, model = read_logs([write_run(tmp_path / "run", wrong)], model)
    tried = (effect, "log_alignment", "command_delay", "command_lag", "velocity_delay", "thrust_loss")
    found = diagnosed(model, logs, {"runs": ["sealed"]}, only=lambda h: h.effect in tried, how_far=False)
    assert [e["id"] for e in found.content["effects"]] == [effect]
    first = next(iter(found.content["effects"][0]["parameters"].values()))
    assert abs(first["value"] - size) < 3.0 * first["std"]


@pytest.mark.long
@pytest.mark.xfail(reason="begun at the truth its odds are e^3.9, little more than a claim needs; the search misses it")
def test_a_weight_at_a_place_is_no_shift_of_the_centre_of_mass(tmp_path: Path) -> None:
    hidden = {"mass": 1.5625, "x": -0.128, "y": -0.2323, "z": 0.0936}  # to first order it weighs a tenth of that
    draw = Draw(
        seed=1383, vehicle="ngs", effects=(("payload", {}, hidden),), wrench=0.075, time=8.7, kinds=("sines", "steps")
    )  # fmt: skip
    found = of(tmp_path, draw, ("payload", "cg_shift", "thruster_misalignment")).content
    assert [e["id"] for e in found["effects"]] == ["payload"]
    sizes = found["effects"][0]["parameters"]
    assert all(abs(sizes[name]["value"] - size) < 4.0 * sizes[name]["std"] for name, size in hidden.items())


def test_a_depth_of_a_wrong_scale_is_not_blamed_on_the_velocity_log(tmp_path: Path) -> None:
    draw = Draw(seed=13, vehicle="ngs", deviations=0.7, kinds=("steps",), duration=30.0)
    model = load_model(draw.vehicle)
    (topics,) = recorded(draw, model.vehicle, model.sets, model.sensors)
    deeper = [
        replace(t, fields={"depth": 1.08 * np.asarray(t.fields["depth"])}) if t.name == "rov/depth" else t
        for t in topics
    ]
    logs, model = read_logs([write_run(tmp_path / "run", deeper)], model)
    tried = ("depth_scale", "velocity_scale", "velocity_misalignment")
    found = diagnosed(model, logs, {"runs": ["sealed"]}, only=lambda h: h.effect in tried, how_far=False).content
    (claimed,) = found["effects"]
    size = claimed["parameters"]["share"]
    assert (claimed["id"], claimed["sensor"]) == ("depth_scale", "depth")
    assert abs(size["value"] - 0.08) < 3.0 * size["std"]


def test_a_heading_that_errs_with_itself_is_not_blamed_on_the_gyro(tmp_path: Path) -> None:
    terms = {"semicircular_sin": 0.0, "semicircular_cos": 0.06, "quadrantal_sin": 0.1, "quadrantal_cos": 0.0}
    hidden: Any = (("compass_deviation", {}, terms),)
    draw = Draw(seed=13, vehicle="ngs", effects=hidden, kinds=("steps",), duration=30.0)
    found = of(tmp_path, draw, ("compass_deviation", "gyro_scale", "imu_misalignment")).content
    (claimed,) = found["effects"]
    assert claimed["id"] == "compass_deviation"
    sizes = claimed["parameters"]
    assert all(abs(sizes[name]["value"] - size) < 3.0 * sizes[name]["std"] for name, size in terms.items())


@pytest.mark.long
def test_four_minutes_of_dives_name_what_two_name_and_nothing_beside_it(tmp_path: Path) -> None:
    hidden: Any = (("thrust_loss", {"thruster": 3}, {"share": 0.2628}),)
    draw = Draw(
        seed=1491, vehicle="bluerov2_heavy", effects=hidden, deviations=0.81, wrench=0.06, time=7.6, noise=1.46,
        kinds=("steps", "sines", "pulses", "sines"), duration=60.0,
    )  # fmt: skip
    tried = ("thrust_loss", "tach_scale", "throttle_gain", "propeller_fouling", "viscous_friction", "added_mass")
    (found,) = of(tmp_path, draw, tried).content["effects"]
    assert (found["id"], found["thruster"]) == ("thrust_loss", 3)
    size = found["parameters"]["share"]
    assert abs(size["value"] - 0.2628) < 3.0 * size["std"]


def test_a_centre_of_mass_that_lies_elsewhere_in_each_dive_is_a_number_of_the_dives_and_no_effect(
    tmp_path: Path,
) -> None:
    model, paths = load_model("ngs"), []
    at = model.vehicle.values.get("x_G", 0.0)
    for k, forward in enumerate((-0.004, 0.004)):
        draw = Draw(seed=31 + k, vehicle="ngs", deviations=0.0, kinds=("steps",), duration=24.0)
        there = model.vehicle.with_values({"x_G": at + forward}, source="truth")
        (topics,) = recorded(draw, there, model.sets, model.sensors)
        paths.append(write_run(tmp_path / f"run_{k}", topics))
    logs, model = read_logs(paths, model)
    content = diagnosed(model, logs, {}, only=lambda h: h.effect in FEW, how_far=False).content
    assert content["verdict"] in ("parameters", "no_gap") and not content["effects"]
    apart = content["retuned_parameters"]["x_G.1"]
    scale = rules.TRIMMED * np.cbrt(model.vehicle.values["volume"]) * np.sqrt(2.0)
    assert abs(apart["deviations"] * scale - 0.008) < 0.001
    if content["verdict"] == "parameters":
        assert "x_G of recording 2 against those before it by" in content["summary"]
