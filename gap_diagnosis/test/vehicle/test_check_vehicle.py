"""What runs of a vehicle are good for, said before any fit."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

from gap_diagnosis.findings import Finding, lines_of
from gap_diagnosis.vehicle import cli_check_vehicle
from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.check_io import _grouped, check_vehicle
from gap_diagnosis.vehicle.cli_check_vehicle import main
from gap_diagnosis.vehicle.cli_diagnose_vehicle import main as diagnose
from gap_diagnosis.vehicle.cli_fit_vehicle import main as fit
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.hypotheses import hypotheses
from rov_sim.vehicle.settings_io import load_vehicle_settings
from run_bag import Topic, write_run
from thruster_model.effect_entry import EffectEntry
from thruster_model.errors import VehicleError
from thruster_model.vehicle_set_io import dump_vehicle_set

MODEL = load_model("ngs")


def dive(folder: Path, change: Any = lambda topic: topic, **more: Any) -> Path:
    draw = Draw(**{"seed": 3, "vehicle": "ngs", "kinds": ("pulses",), "duration": 20.0, **more})
    (topics,) = recorded(draw, MODEL.vehicle, MODEL.sets, MODEL.sensors)
    return write_run(folder, [new for topic in topics if (new := change(topic)) is not None])


def told(found: list[Finding], kind: str) -> dict[str, str]:
    return {": ".join(filter(None, (each.run, each.about))): each.sentence for each in found if each.kind == kind}


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> list[Finding]:
    return check_vehicle([dive(tmp_path_factory.mktemp("runs") / "dive")], MODEL)


def test_sensors_wiring_and_what_could_be_told_are_named(sound: list[Finding]) -> None:
    good = told(sound, "good")
    assert {"dive: gyro", "dive: attitude", "dive: depth", "dive: velocity", "dive: tachometer"} <= set(good)
    assert good["dive: gyro"].startswith("2000 readings, one every 0.01 s")
    assert good["wiring"] == "Commands move the vehicle as the set states."
    shown, of, all_of_them = good["effects that would show"].split(",")[0].split()
    assert of == "of" and 0.8 * int(all_of_them) < int(shown) < int(all_of_them)
    named = good["effects that would show"].partition("its range: ")[2].split("; ")
    assert "loss of thrust at all speeds" in named, "wherever it is"
    assert any(each.startswith("linear drag of one axis (") and "sway" not in each for each in named), "there alone"
    others = good["effects that are looked for, too"].partition(": ")[0].split(", ")
    assert {"payload", "current of the water", "thruster wired the wrong way round"} <= set(others)
    assert not set(others) & {each.partition(" (")[0] for each in named}
    assert not told(sound, "refused")
    assert not {"tachometer", "battery"} & set(told(sound, "note"))


def test_short_dives_leave_numbers_and_effects_in_the_dark_and_name_them(sound: list[Finding]) -> None:
    left = told(sound, "good")["numbers that a fit would leave as they are"]
    assert "flow_drag of all thrusters" in left and "k_v of thruster 0 1 2 3 4 5" in left
    hidden = told(sound, "note")["effects that would not show"]
    assert hidden.count("linear drag of one axis (") == 1
    assert "sway" in hidden.split("linear drag of one axis (")[1].split(")")[0]


@pytest.mark.parametrize(
    ("effect", "place"),
    [("cavitation", "all thrusters"), ("water_density", "the vehicle"), ("cb_shift", "the vehicle")],
)
def test_what_is_on_all_thrusters_at_once_is_not_called_the_vehicle_s(effect: str, place: str) -> None:
    everywhere = [h for h in hypotheses(MODEL, {}) if h.effect == effect and h.thruster is None]
    assert _grouped(everywhere).endswith(f"({place})")


def test_places_of_an_effect_are_told_by_what_they_are_with_the_thrusters_that_share_it() -> None:
    there = hypotheses(MODEL, dict.fromkeys(("attitude", "gyro", "accelerometer", "velocity", "depth"), True))
    askew = [h for h in there if h.effect == "thruster_misalignment" and h.kind != "position"]
    both = ", ".join(f"{kind} normal of thruster 0 1 2 3 4 5" for kind in ("first", "second"))
    assert _grouped(askew) == f"thruster misaligned ({both})"
    arms = _grouped([h for h in there if h.effect == "sensor_lever_arm"]).partition(" (")[2].split(", ")
    assert "imu y" in arms and "velocity x" in arms


def test_stamps_that_scatter_are_no_note_as_they_are_put_right(tmp_path: Path) -> None:
    draw = np.random.default_rng(2)

    def scattered(topic: Topic) -> Topic:
        if topic.name != "rov/imu":
            return topic
        late = np.round(draw.normal(0.0, 8e6, len(topic.stamps))).astype(np.int64)
        stamps = np.sort(np.asarray(topic.stamps, dtype=np.int64) + late)
        return Topic(name=topic.name, type=topic.type, stamps=stamps, fields=topic.fields)

    found = [each for each in check_vehicle([dive(tmp_path / "dive", scattered)], MODEL) if "Scatter" in each.sentence]
    assert [each.kind for each in found] == ["good"]
    assert found[0].sentence.endswith("on regular stamps; on their own they would err by 0.25 of their noise or more.")


def test_without_a_sensor_its_effects_cannot_be_looked_for(tmp_path: Path) -> None:
    found = check_vehicle([dive(tmp_path / "dive", missing=("velocity", "tachometer", "battery"))], MODEL)
    assert told(found, "good")["dive: not measured"] == "velocity, tachometer, battery", (
        "nothing is to be done about it"
    )
    blind = told(found, "good")["effects that cannot be looked for"]
    assert blind.split(", ")[:2] == ["lag of the tachometer", "late readings of the velocity log"]


def test_recordings_with_fewer_throttles_than_the_set_has_thrusters_are_asked_about(tmp_path: Path) -> None:
    def without_the_last(topic: Topic) -> Topic | None:
        return None if topic.name == "thruster_5/throttle" else topic

    runs = [dive(tmp_path / "whole"), *(dive(tmp_path / name, without_the_last) for name in ("one", "two"))]
    found = check_vehicle(runs, MODEL)
    asked = "No throttle of thruster 5 in one, two: it counts as at rest. Is this the set's vehicle, of 6 thrusters?"
    assert [each.sentence for each in found if each.about == "throttles" and not each.run] == [asked]
    assert told(found, "note")["throttles"] == asked and not told(found, "refused")


def test_a_thruster_that_answers_none_of_its_pulses_is_named_and_one_that_was_not_to_is_not(tmp_path: Path) -> None:
    stopped: Any = (("thruster_failure", {"thruster": 1, "kind": "stopped"}, {}),)
    found = check_vehicle([dive(tmp_path / "stopped", effects=stopped, duration=60.0)], MODEL)
    says = told(found, "note")["wiring"]
    assert says.startswith("Thruster 1 was commanded up to ") and "`pulses`" not in says
    assert says.endswith("its tachometer says that it stands still: it is dead, or its wire is cut.")
    assert "wiring" not in told(check_vehicle([dive(tmp_path / "sound", duration=60.0)], MODEL), "note")


def test_a_wrong_wire_and_an_imu_upside_down_are_notes(tmp_path: Path) -> None:
    def turned(topic: Topic) -> Topic:
        if topic.name != "rov/imu":
            return topic
        fields = {p: -np.asarray(v) if p.startswith("linear") and p[-1] in "yz" else v for p, v in topic.fields.items()}
        return Topic(name=topic.name, type=topic.type, stamps=topic.stamps, fields=fields)

    wrong: Any = (("thruster_polarity", {"thruster": 4}, {}),)
    found = check_vehicle([dive(tmp_path / "dive", effects=wrong)], MODEL)
    assert told(found, "note")["wiring"] == "The command of thruster 4 drives it the other way round."
    found = check_vehicle([dive(tmp_path / "askew", turned)], MODEL)
    assert "its z axis points up" in told(found, "note")["askew"]


@pytest.mark.parametrize("stated", [True, False])
def test_an_imu_that_is_stated_to_be_upside_down_contradicts_no_attitude_of_the_vehicle(
    tmp_path: Path, stated: bool
) -> None:
    draw = Draw(seed=3, vehicle="ngs", kinds=("pulses",), duration=20.0)
    topics = {topic.name: topic for topic in recorded(draw, MODEL.vehicle, MODEL.sets, MODEL.sensors)[0]}
    imu = topics["rov/imu"]
    told_there = {f"pose.pose.{p}": v for p, v in imu.fields.items() if p.startswith("orientation")}
    vectors = {p: np.asarray(v) for p, v in imu.fields.items() if not p.startswith("orientation")}
    topics["rov/imu"] = replace(imu, fields={p: -v if p[-1] in "yz" else v for p, v in vectors.items()})
    odometry = Topic(name="rov/odometry", type="nav_msgs/msg/Odometry", stamps=imu.stamps, fields=told_there)
    sensors = replace(MODEL.sensors, imu=replace(MODEL.sensors.imu, rotation=(np.pi, 0.0, 0.0)))
    model = replace(MODEL, sensors=sensors) if stated else MODEL
    found = check_vehicle([write_run(tmp_path / "dive", [*topics.values(), odometry])], model)
    assert any("where down is" in each.sentence for each in found) is not stated


def test_an_attitude_at_times_of_its_own_is_read_where_it_is(tmp_path: Path) -> None:
    def slower(topic: Topic) -> Topic:
        there = np.arange(len(topic.stamps)) % 5 == 0
        parts = {p: np.where(there, v, np.nan) for p, v in topic.fields.items() if p.startswith("orientation")}
        return replace(topic, fields={**topic.fields, **parts}) if topic.name == "rov/imu" else topic

    found = check_vehicle([dive(tmp_path / "dive", slower, duration=20.0)], MODEL)
    assert not any("where down is" in each.sentence for each in found)
    assert any(each.about == "attitude" for each in found if each.kind == "good")


def test_readings_in_another_unit_or_sign_and_another_battery_are_asked_about(tmp_path: Path) -> None:
    def misread(topic: Topic) -> Topic:
        factors = {"n": 2.0 * np.pi / 60.0, "voltage": 0.75} | {f"twist.twist.linear.{a}": 0.1 for a in "xyz"}
        factors |= {"current": -1.0}
        fields = {p: factors.get(p, 1.0) * np.asarray(v) for p, v in topic.fields.items()}
        return Topic(name=topic.name, type=topic.type, stamps=topic.stamps, fields=fields)

    found = check_vehicle([dive(tmp_path / "dive", misread, duration=40.0)], MODEL)
    assert any("rov/battery.current: positive throughout" in each.sentence for each in found if each.kind == "note")
    notes = told(found, "note")
    assert notes["velocity"].startswith("reads 0.09") or notes["velocity"].startswith("reads 0.1")
    assert "what depth and accelerometer say of the velocity; is the unit" in notes["velocity"]
    assert notes["tachometer"].startswith("reads 0.1") and "is the unit" in notes["tachometer"]
    assert notes["battery"].startswith("reads 0.7") and "the nominal voltage" in notes["battery"]


@pytest.mark.parametrize(
    ("kept", "taken"),
    [
        ({}, "that of rov/odometry, as rov/imu has none"),
        (
            {"w": 1.0, "x": 0.0, "y": 0.0, "z": 0.0},
            "that of rov/odometry, as rov/imu has one that is not measured or never changes",
        ),
        (None, "that of rov/imu; rov/odometry has another one, which is not read"),
    ],
)
def test_of_two_attitudes_that_which_is_measured_is_taken_and_named(
    tmp_path: Path, kept: dict[str, float] | None, taken: str
) -> None:
    def elsewhere(topic: Topic) -> Topic:
        if topic.name != "rov/imu" or kept is None:
            return topic
        fields = {p: v for p, v in topic.fields.items() if not p.startswith("orientation")}
        fields |= {f"orientation.{part}": np.full(len(topic.stamps), value) for part, value in kept.items()}
        return Topic(name=topic.name, type=topic.type, stamps=topic.stamps, fields=fields)

    (topics,) = recorded(
        Draw(seed=3, vehicle="ngs", kinds=("pulses",), duration=20.0), MODEL.vehicle, MODEL.sets, MODEL.sensors
    )
    imu = next(topic for topic in topics if topic.name == "rov/imu")
    turned = {f"pose.pose.orientation.{part}": imu.fields[f"orientation.{part}"] for part in "wxyz"}
    odometry = Topic(name="rov/odometry", type="nav_msgs/msg/Odometry", stamps=imu.stamps, fields=turned)
    (tmp_path / "runs").mkdir()
    run = write_run(tmp_path / "runs" / "dive", [*map(elsewhere, topics), odometry])
    found = check_vehicle([run], MODEL)
    assert [each.kind for each in found if each.sentence == taken] == ["good"]
    warned = [each.sentence for each in found if each.kind == "note" and "orientation: never changes" in each.sentence]
    assert len(warned) == bool(kept), "an attitude beside the measured one that nobody measured"


def test_thrusters_that_are_commanded_alike_are_named(tmp_path: Path) -> None:
    first: dict[str, Any] = {}

    def alike(topic: Topic) -> Topic:
        if topic.name == "thruster_0/throttle":
            first.update(topic.fields)
        if topic.name != "thruster_1/throttle":
            return topic
        return Topic(name=topic.name, type=topic.type, stamps=topic.stamps, fields=dict(first))

    found = check_vehicle([dive(tmp_path / "dive", alike)], MODEL)
    assert told(found, "note")["excitation"].startswith("thrusters 0 and 1 were hardly commanded apart")


def test_what_a_diagnosis_would_refuse_is_a_refusal_and_the_status_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    blind = dive(tmp_path / "blind", lambda topic: None if topic.name == "rov/imu" else topic)
    assert main([str(blind), "--vehicle", "ngs"]) == 1
    printed = capsys.readouterr().out
    assert "! blind: expected rov/imu or rov/odometry with attitude or rates" in printed
    assert printed.endswith("not usable as it is: 1 refusal (!), 0 notes (?)\n")
    assert main([str(tmp_path / "none"), "--vehicle", "ngs"]) == 1
    assert "none" in capsys.readouterr().err


def test_sensors_that_are_alike_in_all_dives_are_a_line_each_and_lone_readings_no_note(tmp_path: Path) -> None:
    def with_an_outlier(topic: Topic) -> Topic:
        if topic.name != "rov/depth":
            return topic
        depth = np.array(topic.fields["depth"], dtype=np.float64)
        depth[100] += 50.0
        return Topic(name=topic.name, type=topic.type, stamps=topic.stamps, fields={**topic.fields, "depth": depth})

    found = check_vehicle([dive(tmp_path / name, with_an_outlier) for name in ("one", "two")], MODEL)
    lines = lines_of(found)
    assert lines[0].startswith("  each run: ") and len([line for line in lines if ": gyro: " in line]) == 1
    assert any(
        line.startswith("  each run: gyro: 2000, 2000 readings, one every 0.01 s, longest gap") for line in lines
    )
    assert any("  each run: readings that stand alone, far off, are left out: 1 of" in line for line in lines)


def test_effects_that_the_set_states_are_named(tmp_path: Path) -> None:
    entry = EffectEntry(id="supply_sag", sizes={"share": 0.04}, units={"share": "1"})
    stated = replace(MODEL, vehicle=replace(MODEL.vehicle, effects=(entry,)))
    found = told(check_vehicle([dive(tmp_path / "dive")], stated), "good")
    assert found["effects that the set states"] == "sag of the shared supply: taken as exact"


@pytest.mark.parametrize("command", [main, diagnose, fit])
def test_a_set_that_lacks_what_its_effect_needs_is_one_sentence_with_file_and_key(
    command: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    reaction = EffectEntry(id="reaction_torque", sizes={"share": 1.0}, units={"share": "1"})
    layout = tuple(replace(t, hand=None) if i == 2 else t for i, t in enumerate(MODEL.vehicle.layout))
    own = tmp_path / "own.yaml"
    own.write_text(dump_vehicle_set(replace(MODEL.vehicle, layout=layout, effects=(reaction,))), encoding="utf-8")
    out = [] if command is main else ["--out", str(tmp_path / "out")]
    assert command([str(tmp_path / "dive"), "--vehicle", str(own), *out]) == 1
    (sentence,) = capsys.readouterr().err.splitlines()
    assert sentence.startswith(f"{own}: key 'thrusters.2.hand': missing; the effect reaction_torque needs the hand")
    with pytest.raises(VehicleError, match=r"key 'thrusters\.2\.hand': missing"):
        load_vehicle_settings(own)


def test_a_check_says_that_it_compiles_before_it_does(monkeypatch: Any, capsys: Any) -> None:
    kernel = numba.njit(lambda x: 2.0 * x)
    monkeypatch.setattr(cli_check_vehicle, "load_model", lambda *given: None)
    monkeypatch.setattr(cli_check_vehicle, "check_vehicle", lambda runs, model: [None] * int(kernel(0.0)))
    for told in (1, 0):
        cli_check_vehicle.main(["runs/dive", "--vehicle", "own.yaml"])
        assert capsys.readouterr().err.count("compiling the model, once for as many thrusters") == told
