"""Which effects are looked for: none that the sensors at hand cannot tell from a healthy vehicle."""

from dataclasses import replace

import numpy as np
import pytest

from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.hypotheses import hypotheses
from rov_sim.vehicle.effects.active import ActiveVehicleEffect, body_with
from rov_sim.vehicle.plant import simulate
from rov_sim.vehicle.settings import vehicle_settings
from rov_sim.vehicle.truth import at_rest

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
