"""What is not known of the flow through a thruster that a stream meets."""

import numpy as np
import pytest
from scipy.optimize import brentq

from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.inflow import Inflow, inflow
from rov_sim.vehicle.plant import VehicleSettings
from thruster_model.pipeline import derivative, outputs

K, PERIOD, RISING, VERTICAL = 250, 0.04, 0.3, 4
MODEL = load_model("bluerov2_heavy")
SETTINGS = VehicleSettings(
    coefficients=MODEL.vehicle.coefficients, thrusters=tuple(each.coefficients for each in MODEL.sets)
)
OWN = SETTINGS.thrusters[VERTICAL]


def found_at(speed: float, upwards: float, before: Inflow | None = None) -> Inflow:
    """Return what is found at this speed of all rotors [rad/s] while the vehicle rises [m/s], from no flow on."""
    n, nu = np.full((K, SETTINGS.count), speed), np.zeros((K, 6))
    nu[:, 2] = -upwards
    return inflow(SETTINGS, nu, n, np.zeros(n.shape), PERIOD, None if before is None else before.last)


def steady(speed: float, low: float, high: float) -> float:
    """Return the flow between these [m/s] that stays at a speed [rad/s]."""
    return float(brentq(lambda v: derivative(speed, v, RISING, 0.0, OWN)[1], low, high))


def in_doubt(speed: float, *flows: float) -> float:
    """Return the deviation [N] of a thrust that may be anywhere between those at two flows [m/s]."""
    low, high = (outputs(speed, v, RISING, 0.0, OWN)[2] for v in flows)
    return abs(high - low) / np.sqrt(12.0)


def test_at_rest_in_a_stream_the_flow_is_anywhere_between_none_and_what_the_stream_carries() -> None:
    found = found_at(0.0, RISING)
    assert found.doubts[:, VERTICAL].max() == pytest.approx(in_doubt(0.0, 0.0, steady(0.0, 0.1, RISING)), rel=0.01)
    assert not found_at(0.0, 0.0).doubts.any()


def test_two_flows_that_a_slow_propeller_leaves_stay_in_doubt_once_they_have_parted() -> None:
    parted = found_at(0.0, RISING)
    found, ends = found_at(-100.0, RISING, parted), (steady(-100.0, -0.1, 0.0), steady(-100.0, 0.1, RISING))
    assert found.last[VERTICAL] == pytest.approx(ends, abs=1e-4)
    assert found.doubts[-1, VERTICAL] == pytest.approx(in_doubt(-100.0, *ends), rel=1e-3)
    assert not found_at(-100.0, RISING).doubts.any()  # the propeller alone has decided
