"""Which effects are looked for: none that the sensors at hand cannot tell from a healthy vehicle."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gap_diagnosis.vehicle import hypotheses as searched
from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.filtering import prepared_with
from gap_diagnosis.vehicle.hypotheses import described, hypotheses
from gap_diagnosis.vehicle.learning import first_noises
from gap_diagnosis.vehicle.log_io import read_logs
from gap_diagnosis.vehicle.refining import Problem
from gap_diagnosis.vehicle.screening import Screen
from rov_sim.vehicle.effects.active import VEHICLE_LIBRARY, ActiveVehicleEffect, body_with
from rov_sim.vehicle.plant import simulate
from rov_sim.vehicle.settings import vehicle_settings
from rov_sim.vehicle.truth import at_rest
from run_bag import write_run
from thruster_model.effects.effect import Suspected
from thruster_model.effects.stages import LIBRARY

MODEL = load_model("ngs")
BLIND = dict.fromkeys(("attitude", "gyro", "accelerometer", "depth", "velocity", "tachometer", "battery"), False)


@pytest.mark.parametrize(
    ("sensors", "parts"),
    [
        (("gyro",), ()),
        (("gyro", "attitude", "accelerometer", "tachometer"), ()),
        (("gyro", "depth"), ("down",)),
        (("gyro", "depth", "velocity"), ("north", "east", "down")),
    ],
)
def test_a_current_is_looked_for_as_far_as_motion_over_ground_is_told(
    sensors: tuple[str, ...], parts: tuple[str, ...]
) -> None:
    found = [h for h in hypotheses(MODEL, {**BLIND, **dict.fromkeys(sensors, True)}) if h.effect == "water_current"]
    assert [h.parameters for h in found] == ([parts] if parts else [])
    assert all(set(h.active(h.probe).sizes) == set(parts) for h in found)


def test_a_vehicle_that_drifts_with_a_current_turns_and_accelerates_as_in_water_at_rest() -> None:
    N, current = MODEL.thrusters, (0.2, -0.1, 0.05)
    throttles = np.repeat(np.random.default_rng(2).uniform(-3.0, 3.0, (10, N)), 25, axis=0)
    settings = vehicle_settings(MODEL.vehicle, list(MODEL.sets), initial=at_rest(N))
    effect = ActiveVehicleEffect(id="water_current", sizes=dict(zip(("north", "east", "down"), current, strict=True)))
    drifting = settings.initial._replace(velocity=np.array([*current, 0.0, 0.0, 0.0]))
    moved = replace(settings, coefficients=body_with(settings.coefficients, [effect]), initial=drifting)
    calm, carried = simulate(settings, throttles, 0.04), simulate(moved, throttles, 0.04)
    np.testing.assert_allclose(carried.velocity[:, 3:], calm.velocity[:, 3:], atol=1e-6)
    np.testing.assert_allclose(carried.attitude, calm.attitude, atol=1e-6)
    assert np.abs(carried.velocity[:, :3] - calm.velocity[:, :3]).max() > 0.1


def test_a_new_effect_of_a_vehicle_is_looked_for_wherever_its_file_says(monkeypatch: pytest.MonkeyPatch) -> None:
    new = replace(
        VEHICLE_LIBRARY["velocity_misalignment"],
        id="velocity_cross_talk",
        suspected=(Suspected(sizes={"angle": (0.2, 0.02)}, only={"axis": ("x", "z")}, read_by="velocity"),),
    )
    monkeypatch.setattr(searched, "VEHICLE_LIBRARY", {**VEHICLE_LIBRARY, new.id: new})
    found = [h for h in hypotheses(MODEL, {**BLIND, "velocity": True}) if h.effect == new.id]
    assert [(h.axis, h.scale, h.probe, h.lower, h.upper) for h in found] == [
        (axis, (0.2,), (0.02,), (new.parameters[0].lower,), (new.parameters[0].upper,)) for axis in ("x", "z")
    ]
    assert not [h for h in hypotheses(MODEL, BLIND) if h.effect == new.id]


def test_what_only_shows_as_it_begins_is_none_for_a_diagnosis_and_needs_its_sensor() -> None:
    there = {**BLIND, "depth": True, "attitude": True}
    sudden = {h.effect for h in hypotheses(MODEL, there, sudden=True)}
    assert sudden == {"depth_bias", "heading_bias"}
    assert not sudden & {h.effect for h in hypotheses(MODEL, there)}
    assert [h.effect for h in hypotheses(MODEL, {**BLIND, "depth": True}, sudden=True)] == ["depth_bias"]


def test_an_effect_that_is_suspected_by_what_is_no_size_of_it_is_refused() -> None:
    with pytest.raises(ValueError, match="velocity_scale: suspected: expected parameters among share; found size"):
        replace(VEHICLE_LIBRARY["velocity_scale"], suspected=(Suspected(sizes={"size": (1.0, 0.1)}),))
    with pytest.raises(ValueError, match="velocity_scale: suspected: expected parameters among share; found onset"):
        replace(
            VEHICLE_LIBRARY["velocity_scale"], suspected=(Suspected(sizes={"share": (1.0, 0.1)}, about={"onset": 1.0}),)
        )


@pytest.mark.parametrize(("effect", "values", "beside"), [("cavitation", 5, -2.0), ("brake_asymmetry", 2, -0.1)])
def test_where_an_effect_begins_is_fitted_about_several_values_within_its_range(
    effect: str, values: int, beside: float
) -> None:
    found = [h for h in hypotheses(MODEL, BLIND) if h.effect == effect and h.thruster == 2]
    onset = described(effect).parameters[1]
    assert len(found) == values and len({h.error for h in found}) == 1
    biases = [h for h in hypotheses(MODEL, dict.fromkeys(BLIND, True)) if h.effect == "imu_bias" and h.axis == "x"]
    assert len({h.place for h in biases}) == 1 and len({h.error for h in biases}) == 2
    for h in found:
        assert h.parameters == ("share", "onset")
        assert h.active((0.3, beside)).sizes == {"share": 0.3, "onset": h.about[1] + beside}
        assert [h.active((0.3, far)).sizes["onset"] for far in (-1e3, 1e3)] == [onset.lower, onset.upper]


@pytest.mark.parametrize(
    "effect", [e for e in (*LIBRARY.values(), *VEHICLE_LIBRARY.values()) if e.suspected], ids=lambda e: e.id
)
def test_no_effect_is_looked_for_with_a_number_of_its_form_fixed(effect: Any) -> None:
    for suspected in effect.suspected:
        formed = {p.name for p in effect.parameters if p.neutral not in (None, 0.0) and np.isfinite(p.neutral)}
        assert formed - {effect.parameters[0].name} <= set(suspected.sizes)


def test_cavitation_is_found_with_the_speed_at_which_it_begins(tmp_path: Path) -> None:
    hidden = ("cavitation", {"thruster": 2}, {"share": 0.6, "onset": 77.0})
    draw = Draw(seed=19, vehicle="ngs", effects=(hidden,), deviations=0.0, kinds=("steps",), duration=40.0)
    (topics,) = recorded(draw, MODEL.vehicle, MODEL.sets, MODEL.sensors)
    (log,), model = read_logs([write_run(tmp_path / "run", topics)], MODEL)
    screen = Screen(model=model, runs=[prepared_with(model, log, 0, first_noises(model, [log]), {})], values={})
    fits = [
        Problem(screen=screen, nuisances={}, effects=(h,)).fit(np.zeros(0), [(0.3, 0.0)])
        for h in hypotheses(model, log.there)
        if h.effect == "cavitation" and h.thruster == 2
    ]
    (found,) = max(fits, key=lambda fit: fit.log_evidence).effects
    assert found.told == pytest.approx((0.6, 77.0), rel=0.1)
