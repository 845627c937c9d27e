"""Commands that act later than they are stamped; innovations of the right model, which are white noise."""

from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.blind.truth import installed, levelled, metered, off, placed, rested, slanted
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.filtering import at_rest, filtered, prepared_with
from gap_diagnosis.vehicle.instants import shifted
from gap_diagnosis.vehicle.learning import _all_prepared, _blocks, _scaled, first_noises, learned_from, prepared
from gap_diagnosis.vehicle.log import held
from gap_diagnosis.vehicle.log_io import read_logs
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.nuisances import nuisances
from gap_diagnosis.vehicle.unknowns import PRODUCTS, sum_of
from gap_diagnosis.vehicle.whitening import log_determinant, log_likelihood, whitened
from rov_sim.vehicle.effects.active import ActiveVehicleEffect
from rov_sim.vehicle.effects.library.thruster_misalignment import normals
from rov_sim.vehicle.innovations import PARTS, states_of
from run_bag import write_run


def test_commands_act_later_by_parts_of_a_period_and_readings_tell_of_earlier_states_by_the_rest() -> None:
    commands = np.array([0.0, 4.0, 3.0, 0.0, 1.0, 2.0, 5.0, 6.0]).reshape(2, PARTS, 1)
    log: Any = VehicleLogStub(period=0.04, commands=commands, lateness=np.zeros((2, 6)))
    for late, acting, rest in (
        (0.004, [0.0, 4.0, 3.0, 0.0, 1.0, 2.0, 5.0, 6.0], 0.1), (0.012, [0.0, 0.0, 4.0, 3.0, 0.0, 1.0, 2.0, 5.0], 0.05),
        (-0.012, [4.0, 3.0, 0.0, 1.0, 2.0, 5.0, 6.0, 6.0], -0.05),
        (0.05, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 4.0, 3.0], 0.0),
    ):  # fmt: skip
        moved = shifted(log, {("late", "commands"): late})
        assert moved.commands.ravel().tolist() == acting
        assert moved.lateness == pytest.approx(rest, abs=1e-9)
    assert shifted(log, {}) is log


@dataclass(frozen=True, kw_only=True, eq=False)
class VehicleLogStub:
    """What is shifted of a log."""

    period: float
    commands: np.ndarray
    lateness: np.ndarray
    count: int = 2
    thrusters: int = 1
    cut: int = 0


CHANNELS = np.array([0.004] * 3 + [0.003] * 3 + [0.05] * 3 + [0.006] + [0.008] * 3)
"""Deviations of the sealed world's sensors."""
TURNED = ("imu_misalignment", {"axis": "z"}, {"angle": -0.05})

SENSORS = {
    "gyro_scale": ("gyro_scale", None),
    "imu_turn": ("imu_misalignment", None),
    "imu_place": ("sensor_lever_arm", "imu"),
    "velocity_scale": ("velocity_scale", None),
    "velocity_turn": ("velocity_misalignment", None),
    "velocity_place": ("sensor_lever_arm", "velocity"),
    "depth_scale": ("depth_scale", None),
}
"""Effect and sensor by which the model has what the sealed world's sensors are off."""
FLOW = ("flow_loss", "flow_drag")
KEYS = ("c_u2", "delta_u2", "rotor", "thrust", FLOW, "k_v", "k_Uv", "k_Tv", "c_u1", "delta_u1", "k_Q")
"""Of the model, in the order of the sealed world's groups."""


def believed_as_it_is(draw: Draw, model: Model) -> dict[Any, float]:
    """Return the values of the unknowns that make the model the sealed world's vehicle."""
    numbers, factors = off(draw, model.vehicle)
    values: dict[Any, float] = {("vehicle", n): v - model.vehicle.values[n] for n, v in numbers.items()}
    for names, column in zip(KEYS, factors.T, strict=True):
        for name in (names,) if isinstance(names, str) else names:
            values |= {("own", name, i): float(f) - 1.0 for i, f in enumerate(column)}
    positions, axes = placed(draw, model.vehicle)
    first, second = (n.T for n in normals(np.array([e.axis for e in model.vehicle.layout]).T))
    for i, e in enumerate(model.vehicle.layout):
        moved, ahead = positions[i] - e.position, float(axes[i] @ e.axis)
        values["own", "first angle", i] = -float(np.arcsin(second[i] @ axes[i]))
        values["own", "second angle", i] = float(np.arctan2(first[i] @ axes[i], ahead))
        values |= {
            ("own", "first offset", i): float(first[i] @ moved),
            ("own", "second offset", i): float(second[i] @ moved),
        }
    inertia = slanted(draw, model.vehicle)
    values |= {("product", pair): inertia["xyz".index(pair[0]), "xyz".index(pair[1])] for pair in PRODUCTS}
    if "battery" in draw.missing:
        level, fall = rested(draw, 0)
        values |= {("charge", 0, "level"): float(level) - 1.0, ("charge", 0, "rate"): -float(fall)}
    else:
        metered_as = dict(zip(("nominal_voltage", "idle_current", "current_at_full"), metered(draw), strict=True))
        values |= {("power", n): float(v / getattr(model.sensors, n)) - 1.0 for n, v in metered_as.items()}
    values |= {("tilt", 0, axis): float(turn) for axis, turn in enumerate(levelled(draw, 0))}
    sensors = installed(draw)
    values |= {("late", "velocity"): sensors.velocity_late, ("late", "tachometer"): sensors.tachometer_late}
    for name, sizes in sensors._asdict().items():
        if name not in SENSORS:
            continue
        for axis, size in zip("xyz", np.atleast_1d(sizes), strict=False):
            effect, sensor = SENSORS[name]
            values["sensor", effect, sensor, None if effect == "depth_scale" else axis] = float(size)
    return values


@pytest.mark.parametrize("battery", [True, False])
@pytest.mark.parametrize(
    ("seed", "vehicle", "kind", "hidden"),
    [
        (1359, "bluerov2_heavy", "pulses", ()),  # idle thrusters in a stream
        (1334, "bluerov2_heavy", "pulses", ()),
        (1211, "ngs", "pulses", ()),
        (1211, "bluerov2_heavy", "sines", ()),  # under way from the first sample
        (1211, "bluerov2_heavy", "steps", (TURNED,)),
        (1211, "ngs", "steps", (("water_current", {}, {"north": 0.2, "east": -0.1}),)),
    ],
)
def test_innovations_of_the_right_model_are_no_larger_than_their_noise(
    seed: int, vehicle: str, kind: str, hidden: Any, tmp_path: Path, *, battery: bool
) -> None:
    missing = () if battery else ("battery",)
    draw = Draw(seed=seed, vehicle=vehicle, effects=hidden, kinds=(kind,), duration=45.0, missing=missing)
    model = load_model(vehicle)
    (topics,) = recorded(draw, model.vehicle, model.sets, model.sensors)
    (log,), model = read_logs([write_run(tmp_path / "run", topics)], model)
    size = np.array([draw.wrench] * 3 + [0.2 * draw.wrench] * 3)
    noises = first_noises(model, [log])._replace(wrench=size, time=draw.time, channels=CHANNELS)
    effects = [ActiveVehicleEffect(id=name, sizes=sizes, **place) for name, place, sizes in hidden]
    values = believed_as_it_is(draw, model)
    found = prepared_with(model, log, 0, noises, values, effects)
    for _ in range(2):
        found = prepared_with(model, log, 0, noises, values, effects, found.base.states)
    r = whitened(found, found.base)[round(rules.START / log.period) :]
    # readings at 100 Hz are means of several samples, quieter than one; biases of the start are in them
    assert found.base.done
    assert np.sqrt(np.mean(r[:, :13] ** 2, axis=0)).max() < 1.2
    assert np.sqrt(np.mean(r[:, 13 : 13 + model.thrusters] ** 2, axis=0)).max() < 1.2


def test_a_vehicle_under_way_from_its_first_sample_is_not_lost(tmp_path: Path) -> None:
    hidden: Any = (("imu_misalignment", {"axis": "z"}, {"angle": -0.051}),)
    draw = Draw(
        seed=1211, vehicle="bluerov2_heavy", effects=hidden, deviations=1.09, wrench=0.127, time=6.9, noise=0.43,
        kinds=("sines", "steps"),
    )  # fmt: skip
    model = load_model(draw.vehicle)
    dives = enumerate(recorded(draw, model.vehicle, model.sets, model.sensors))
    logs, model = read_logs([write_run(tmp_path / f"run_{k}", topics) for k, topics in dives], model)
    for run, log in enumerate(logs):
        size = np.array([draw.wrench] * 3 + [0.2 * draw.wrench] * 3)
        noises = first_noises(model, [log])._replace(wrench=size, time=draw.time, channels=draw.noise * CHANNELS)
        assert prepared_with(model, log, run, noises, {}).base.done


def test_an_imu_tells_as_much_just_before_and_after_its_readings_count_for_an_earlier_instant(tmp_path: Path) -> None:
    missing = ("velocity", "tachometer", "battery")
    draw = Draw(seed=7, vehicle="ngs", deviations=0.0, kinds=("steps",), duration=20.0, missing=missing)
    model = load_model(draw.vehicle)
    topics = [
        replace(topic, stamps=np.asarray(topic.stamps) + 20_000_000) if topic.name == "rov/imu" else topic
        for topic in recorded(draw, model.vehicle, model.sets, model.sensors)[0]
    ]
    (log,), model = read_logs([write_run(tmp_path / "run", topics)], model)
    assert log.period == pytest.approx(0.04)
    rarer = log.attitude.copy()
    rarer[::3] = np.nan  # in two instants of three
    log = replace(log, attitude=rarer)
    told, near = [], None
    for share in (0.37, 0.38):  # of a part and of two: the second stands a row earlier
        late = ActiveVehicleEffect(id="imu_delay", sizes={"time": share * log.period})
        near = prepared(model, [log], {}, [late], near)
        r = whitened(near[0], near[0].base)[:, :9]
        told.append((near[0].late, np.count_nonzero(r), log_likelihood(near[0])))
    (early, count, likely), (later, as_many, as_likely) = told
    assert (early, later) == (1, 2) and count == as_many
    assert as_likely == pytest.approx(likely, rel=0.01)


@pytest.mark.parametrize("of", ["speed", "battery"])
def test_readings_of_rotors_and_battery_are_likelier_with_their_own_noise_than_with_another(
    tmp_path: Path, of: str
) -> None:
    draw = Draw(seed=23, vehicle="ngs", deviations=0.0, kinds=("steps",), duration=20.0)
    model = load_model(draw.vehicle)
    (topics,) = recorded(draw, model.vehicle, model.sets, model.sensors)
    logs, model = read_logs([write_run(tmp_path / "run", topics)], model)
    (learned,) = prepared(model, logs, {})

    def likelihood(factor: float) -> float:
        noises = learned.noises._replace(**{of: factor * getattr(learned.noises, of)})
        found = prepared_with(model, logs[0], 0, noises, {}, states=learned.base.states)
        return -0.5 * float(np.sum(whitened(found, found.base) ** 2)) - 0.5 * log_determinant(found)

    assert likelihood(1.0) > max(likelihood(3.0), likelihood(1.0 / 3.0)) + 20.0


def test_no_other_noise_makes_readings_likelier_than_those_that_were_learned(tmp_path: Path) -> None:
    missing = ("velocity", "tachometer", "battery")
    draw = Draw(seed=21, vehicle="ngs", deviations=0.5, kinds=("steps",), duration=30.0, missing=missing)
    model = load_model(draw.vehicle)
    (topics,) = recorded(draw, model.vehicle, model.sets, model.sensors)
    logs, model = read_logs([write_run(tmp_path / "run", topics)], model)
    level = {("tilt", 0, axis): float(turn) for axis, turn in enumerate(levelled(draw, 0))}
    found = prepared(model, logs, level)
    best, noises, states = sum(map(log_likelihood, found)), learned_from(found), [p.base.states for p in found]
    blocks = _blocks(found)
    assert [block.of for block in blocks] == ["time", *["wrench"] * 6, *["channels"] * 4]
    for block in blocks:
        for factor in (0.5, 0.8, 1.25, 2.0):
            other = _all_prepared(model, logs, _scaled(model, noises, block, factor), level, (), states)
            assert sum(map(log_likelihood, other)) < best + 0.5
    again = prepared(model, logs, level, near=found)
    assert sum(map(log_likelihood, again)) > best - 0.5


def test_a_battery_whose_charge_is_being_found_is_no_noisier_for_that(tmp_path: Path) -> None:
    draw = Draw(seed=21, vehicle="ngs", kinds=("steps",), duration=30.0)  # its voltage is read with 0.02 V
    model = load_model(draw.vehicle)
    (topics,) = recorded(draw, model.vehicle, model.sets, model.sensors)
    logs, model = read_logs([write_run(tmp_path / "run", topics)], model)
    assert learned_from(prepared(model, logs, {})).battery[0] == pytest.approx(0.02, rel=0.15)


def test_a_rotor_that_is_not_driven_and_read_as_zero_is_at_rest() -> None:
    log: Any = SimpleNamespace(commands=held(np.array([[0.0, 0.0, 3.0]])), speeds=np.array([[1.0, 40.0, 1.0]]))
    noises: Any = SimpleNamespace(speed=np.array([1.2, 1.2, 1.2]))
    model: Any = SimpleNamespace(sets=[SimpleNamespace(coefficients=SimpleNamespace(delta_u1=-0.8, delta_u2=0.8))] * 3)
    assert at_rest(model, log, noises).tolist() == [[True, False, False]]


def test_a_rotor_that_has_stopped_is_not_stirred_by_its_tachometers_noise(tmp_path: Path) -> None:
    stopped: Any = ("thruster_failure", {"thruster": 3, "kind": "stopped"}, {"failed": 1.0})
    draw = Draw(seed=1750, vehicle="bluerov2_heavy", effects=(stopped,), kinds=("sines",), duration=20.0)
    model = load_model(draw.vehicle)
    (topics,) = recorded(draw, model.vehicle, model.sets, model.sensors)
    (log,), model = read_logs([write_run(tmp_path / "run", topics)], model)
    active = ActiveVehicleEffect(id=stopped[0], sizes=stopped[2], **stopped[1])
    found = prepared_with(model, log, 0, first_noises(model, [log]), {}, [active])
    speeds = np.abs(states_of(found.base.states).speeds)
    assert np.abs(log.speeds[:, 3]).max() > 3.0
    assert speeds[:, 3].max() == 0.0 and speeds[:, 2].max() > 50.0


def test_slopes_by_coarse_steps_are_those_by_fine_ones(tmp_path: Path) -> None:
    draw = Draw(seed=1211, vehicle="bluerov2_heavy", kinds=("pulses",), duration=20.0)
    model = load_model(draw.vehicle)
    (topics,) = recorded(draw, model.vehicle, model.sets, model.sensors)
    (log,), model = read_logs([write_run(tmp_path / "run", topics)], model)
    found = prepared_with(model, log, 0, first_noises(model, [log]), {})

    def changed(coarse: bool, values: Any, *on: ActiveVehicleEffect) -> Any:
        here, there = (filtered(model, found, v, o, coarse=coarse) for v, o in (({}, ()), (values, on)))
        return whitened(found, there) - whitened(found, here)

    friction = ActiveVehicleEffect(id="coulomb_friction", thruster=2, sizes={"deceleration": 60.0})
    for point in (({("own", "rotor", 1): 0.05},), ({("vehicle", "z_B"): 0.005},), ({}, friction)):
        fine, coarse = (changed(how, *point) for how in (False, True))
        assert np.linalg.norm(fine) > 1.0
        assert np.linalg.norm(coarse - fine) < 0.05 * np.linalg.norm(fine)


@pytest.mark.parametrize("run", [0, 1])
@pytest.mark.parametrize("whole", [("shared", "rotor"), ("shared", "thrust"), ("trim", "volume", 1)])
def test_what_is_shared_or_differs_from_run_to_run_changes_what_the_numbers_that_it_is_made_of_do(
    whole: Any, run: int, tmp_path: Path
) -> None:
    draw = Draw(seed=1211, vehicle="bluerov2_heavy", kinds=("pulses",), duration=20.0)
    model = load_model(draw.vehicle)
    (topics,) = recorded(draw, model.vehicle, model.sets, model.sensors)
    (log,), model = read_logs([write_run(tmp_path / "run", topics)], model)
    free = nuisances(model, [log, log])
    found = prepared_with(model, log, run, first_noises(model, [log]), {})
    here = whitened(found, filtered(model, found, {}))

    def column(key: Any) -> Any:
        return (whitened(found, filtered(model, found, {key: 0.02 * free[key]})) - here) / 0.02

    parts = sum_of(whole, run, free)
    assert len(parts) == (model.thrusters if whole[0] == "shared" else 1)
    expected = column(whole)
    made = sum(share * column(key) for key, share in parts.items())
    assert np.linalg.norm(expected) > 1.0
    assert np.linalg.norm(made - expected) < 0.01 * np.linalg.norm(expected)
