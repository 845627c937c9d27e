"""What is uncertain without being a gap: parameters within their deviations, sensors as they are calibrated and
mounted, biases of each run's start.

What all thrusters share deviates by `SHARED`, what each has of its own by `OWN`: a hierarchy, so that a loss of one
thruster and a wrong common coefficient do not compete.
"""

from collections.abc import Sequence

import numpy as np

from gap_diagnosis.vehicle.hypotheses import hypotheses
from gap_diagnosis.vehicle.instants import CLOCKS
from gap_diagnosis.vehicle.log import VehicleLog, told_in
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.rules import (
    CHARGED,
    EMPTYING,
    OWN,
    PLACED,
    POINTED,
    SHARED,
    SLANTED,
    TIMING,
    TRIMMED,
    VOLTMETER,
)
from gap_diagnosis.vehicle.unknowns import PLACING, PRODUCTS, Key
from rov_sim.vehicle.effects.body_axes import axis_pair

__all__ = ["nuisances"]

_GYRO, _FORCE, _TILT = 0.002, 0.04, 0.01
"""[rad/s, m/s^2] Deviations of an inertial sensor's biases from start to start: twice a middling data sheet's; [rad]
that of the turn by which its filter errs."""
_POWER = {"nominal_voltage": 0.1, "idle_current": 1.0, "current_at_full": 0.5}
_GIVEN = ("gravity", "density", "reaction_torque")


def nuisances(model: Model, logs: Sequence[VehicleLog]) -> dict[Key, float]:
    """Return deviations by key (see `model`) of all that is uncertain in these recordings."""
    vehicle = model.vehicle
    trimmed = float(TRIMMED * np.cbrt(vehicle.values["volume"]))
    deviations = {name: vehicle.deviation(name) for name in vehicle.parameters}
    said = {name for name, p in vehicle.parameters.items() if p.value or p.standard_deviation is not None}
    deviations |= {f"{a}_G": trimmed for a in "xyz" if f"{a}_G" not in said}
    lifting, lifted = "volume", TRIMMED * vehicle.values["volume"]
    if "net_buoyancy" in deviations:
        lifting, lifted = "net_buoyancy", TRIMMED * vehicle.coefficients.buoyancy
        if vehicle.parameters[lifting].standard_deviation is None:  # a share of what is left says nothing
            deviations[lifting] = lifted
    found: dict[Key, float] = {
        ("vehicle", name): deviation for name, deviation in deviations.items() if name not in _GIVEN and deviation > 0.0
    }
    groups = model.groups()
    for group in groups:
        shares = [
            p.standard_deviation / abs(p.value)
            for p in model.stated(group)
            if p.standard_deviation is not None and p.value
        ]
        found["shared", group] = max(shares) if shares else SHARED
    found |= {("own", group, i): OWN for group in groups for i in range(model.thrusters)}
    placed = float(PLACED * np.cbrt(vehicle.values["volume"]))
    wide = {"rad": POINTED, "m": placed}
    found |= {("own", name, i): wide[unit] for name, unit in PLACING.items() for i in range(model.thrusters)}
    moments = vehicle.coefficients.mass_matrix.diagonal()
    for pair, axes in PRODUCTS.items():
        found["product", pair] = SLANTED * float(np.sqrt(np.prod(moments[list(axis_pair(axes))])))
    for k, log in enumerate(logs):
        if log.there["gyro"]:
            found |= {("gyro", k, a): _GYRO for a in range(3)}
        if log.there["accelerometer"]:
            found |= {("force", k, a): _FORCE for a in range(3)}
        if log.there["attitude"]:
            found |= {("tilt", k, a): _TILT for a in range(3)}
        if not np.isfinite(log.battery[:, 0]).any():
            found |= {("charge", k, "level"): CHARGED, ("charge", k, "rate"): EMPTYING}
    for k in range(1, len(logs)):
        against = np.sqrt(1.0 + 1.0 / k)  # of one run against the mean of k
        found["trim", lifting, k] = float(against * lifted)
        found |= {("trim", f"{a}_G", k): float(against * trimmed) for a in "xyz"}
    there = told_in(logs)
    tried = hypotheses(model, there)
    found |= {("sensor", h.effect, h.sensor, h.axis): h.tolerance for h in tried if h.tolerance}
    found |= {("late", what): TIMING for what in ("commands", "imu", *(clock for clock in CLOCKS if there[clock]))}
    if there["battery"]:
        found |= {("power", name): share for name, share in _POWER.items()}
        if model.volts_of_table:
            found["power", "nominal_voltage"] = VOLTMETER
    return found
