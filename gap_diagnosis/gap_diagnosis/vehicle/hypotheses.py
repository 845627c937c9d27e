"""What may be wrong: every effect of both libraries on every thruster, pair, axis and sensor that it can act on."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations, permutations
from typing import Any

import numpy as np

from gap_diagnosis.vehicle.model import Model
from rov_sim.vehicle.effects.active import VEHICLE_LIBRARY, ActiveVehicleEffect
from thruster_model.effects import stages

__all__ = ["HULL_REACH", "SENSORS_OF", "WIRING", "Hypothesis", "described", "hypotheses"]


def described(effect: str) -> Any:
    """Return an effect as its library describes it, that of the vehicle or that of a thruster."""
    return VEHICLE_LIBRARY.get(effect) or stages.LIBRARY[effect]


@dataclass(frozen=True, kw_only=True)
class Hypothesis:
    """One effect on one part of the vehicle.

    Attributes:
        effect, thruster, other, axis, sensor, kind: as of an `ActiveVehicleEffect`.
        parameters: those that are fitted; of a size each.
        scale: deviations that are expected of them.
        probe: sizes at which they are tried.
        lower, upper: their range.
        fixed: the other parameters.
        carrier: parameter that the later ones multiply (a mass at a place), or "".
        switch: whether it is either on or off.
        grid: sizes to fit from where the neutral one is infinite; it is then screened at its probe alone.
    """

    effect: str
    thruster: int | None = None
    other: int | None = None
    axis: str | None = None
    sensor: str | None = None
    kind: str | None = None
    parameters: tuple[str, ...]
    scale: tuple[float, ...]
    probe: tuple[float, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    fixed: Mapping[str, float] = field(default_factory=dict, hash=False)
    carrier: str = ""
    switch: bool = False
    grid: tuple[float, ...] = ()

    @property
    def place(self) -> tuple[Any, ...]:
        """Identifier and what it acts on, which a diagnosis must get right."""
        return self.effect, self.thruster, self.other, self.axis, self.sensor, self.kind

    @property
    def most(self) -> float:
        """Magnitude of the largest size that its first parameter may have."""
        return max(abs(self.lower[0]), abs(self.upper[0]))

    @property
    def units(self) -> dict[str, str]:
        """Unit of each parameter of the effect."""
        return {p.name: p.unit for p in described(self.effect).parameters}

    @property
    def words(self) -> str:
        """Name of it in a sentence."""
        parts = [self.kind, self.axis, self.sensor]
        where = ", ".join(str(p).replace("_", " ") for p in parts if p)
        thruster = "" if self.thruster is None else f" of thruster {self.thruster}"
        pair = "" if self.other is None else f" and {self.other}"
        return f"{described(self.effect).title}{thruster}{pair}{' (' + where + ')' if where else ''}"

    def active(self, sizes: tuple[float, ...]) -> ActiveVehicleEffect:
        """Return it switched on, sizes held within their range."""
        held = {
            n: float(np.clip(s, a, b))
            for n, s, a, b in zip(self.parameters, sizes, self.lower, self.upper, strict=True)
        }
        return ActiveVehicleEffect(
            id=self.effect, sizes={**self.fixed, **held}, thruster=self.thruster, other=self.other, axis=self.axis,
            sensor=self.sensor, kind=self.kind,
        )  # fmt: skip


_OWN: dict[str, tuple[tuple[str, float, float], ...]] = {
    # effect of a thruster -> parameter, expected deviation, probe
    "thrust_loss": (("share", 0.3, 0.05),),
    "propeller_fouling": (("share", 0.3, 0.1),),
    "thrust_asymmetry": (("share", 0.25, 0.05),),
    "throttle_gain": (("share", 0.25, 0.05),),
    "dead_zone_shift": (("voltage", 0.2, 0.05),),
    "viscous_friction": (("share", 0.4, 0.05),),
    "coulomb_friction": (("deceleration", 200.0, 60.0),),
    "rotor_inertia": (("share", 0.6, 0.1),),
    "brake_asymmetry": (("share", 0.4, 0.1),),
    "start_hysteresis": (("voltage", 0.25, 0.2),),
    "command_delay": (("time", 0.1, 0.02),),
    "command_lag": (("time", 0.15, 0.03),),
    "throttle_rate_limit": (("rate", 15.0, 10.0),),
    "throttle_saturation": (("limit", 1.0, 2.0),),
    "thermal_fade": (("share", 0.3, 0.1),),
    "axial_flow_loss": (("share", 0.7, 0.2),),
    "quadratic_flow_loss": (("coefficient", 200.0, 40.0),),
    "flow_reversal_loss": (("share", 0.5, 0.2),),
    "entrained_water": (("impulse", 0.01, 0.003),),
    "cavitation": (("share", 0.5, 0.1),),
    "flow_lag": (("share", 1.5, 0.3),),
    "tach_scale": (("share", 0.15, 0.03),),
    "tach_lag": (("time", 0.2, 0.05),),
}  # fmt: skip
_NEEDS_SPEED = ("tach_scale", "tach_lag")
_GRIDS = {"throttle_rate_limit": (40.0, 20.0, 10.0, 5.0, 2.5), "throttle_saturation": (4.0, 3.0, 2.5, 2.0, 1.5, 1.0)}
_BODY: dict[str, tuple[tuple[str, float, float], ...]] = {
    "added_mass": (("share", 0.4, 0.05),),
    "linear_drag": (("share", 0.5, 0.1),),
    "quadratic_drag": (("share", 0.5, 0.1),),
    "buoyancy_offset": (("force", 5.0, 0.3),),
    "cg_shift": (("x", 0.02, 0.003), ("y", 0.02, 0.003), ("z", 0.02, 0.003)),
    "payload": (("mass", 1.0, 0.1), ("x", 0.3, 0.2), ("y", 0.3, 0.2), ("z", 0.3, 0.2)),
    "tether_drag": (("length", 30.0, 5.0), ("x", 0.3, 0.2), ("y", 0.3, 0.2), ("z", 0.3, 0.2)),
    "water_current": (("north", 0.2, 0.03), ("east", 0.2, 0.03), ("down", 0.1, 0.03)),
    "water_density": (("share", 0.03, 0.01),),
    "supply_sag": (("share", 0.25, 0.05),),
    "gyro_scale": (("share", 0.1, 0.02),),
    "imu_misalignment": (("angle", 0.1, 0.01),),
    "imu_delay": (("time", 0.1, 0.02),),
    "velocity_delay": (("time", 0.3, 0.05),),
    "velocity_misalignment": (("angle", 0.1, 0.01),),
    "velocity_scale": (("share", 0.1, 0.02),),
    "depth_scale": (("share", 0.05, 0.01),),
    "sensor_lever_arm": (("offset", 0.2, 0.03),),
    "magnetic_disturbance": (("angle", 0.2, 0.02),),
    "hull_interaction": (("share", 0.3, 0.05),),
    "reaction_torque": (("share", 0.5, 0.1),),
    "thruster_interaction": (("share", 0.3, 0.1),),
}  # fmt: skip
_LOG: dict[str, tuple[tuple[str, float, float], ...]] = {
    "log_alignment": (("throttle", 0.05, 0.01),),
    "clock_drift": (("rate", 0.002, 0.0003),),
}
_TURNED = (("angle", 0.15, 0.02),)
_MOVED = (("x", 0.07, 0.01), ("y", 0.07, 0.01), ("z", 0.07, 0.01))
_CARRIERS = {"payload": "mass", "tether_drag": "length"}
_FIXED = {"cavitation": {"onset": 100.0}, "thermal_fade": {"time_constant": 30.0}}
SENSORS_OF = {
    "velocity_delay": "velocity", "velocity_misalignment": "velocity", "velocity_scale": "velocity",
    "gyro_scale": "gyro", "imu_delay": "gyro", "magnetic_disturbance": "attitude", "depth_scale": "depth",
    "tach_scale": "tachometer", "tach_lag": "tachometer",
}  # fmt: skip
"""What an effect of a sensor cannot be shown without."""
HULL_REACH = 0.3
"""Share of a thruster's axis along surge, sway or heave from which on its wake may meet the hull on that axis."""
WIRING = ("thruster_swap", "thruster_polarity")
"""Which command drives which thruster, and which way round."""
_AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")


def _made(effect: str, entries: tuple[tuple[str, float, float], ...], **target: Any) -> Hypothesis:
    known = {p.name: p for p in described(effect).parameters}
    lower = []
    for name, _, _ in entries:
        p = known[name]
        lower.append(-p.upper if getattr(p, "both_signs", False) else min(p.lower, p.neutral))
    return Hypothesis(
        effect=effect,
        parameters=tuple(n for n, _, _ in entries),
        scale=tuple(s for _, s, _ in entries),
        probe=tuple(p for _, _, p in entries),
        lower=tuple(lower),
        upper=tuple(known[n].upper for n, _, _ in entries),
        fixed=_FIXED.get(effect, {}),
        carrier=_CARRIERS.get(effect, ""),
        grid=_GRIDS.get(effect, ()),
        **target,
    )


def _switch(effect: str, **target: Any) -> Hypothesis:
    name = {"thruster_swap": "swapped", "thruster_polarity": "reversed", "thruster_failure": "failed"}[effect]
    return Hypothesis(
        effect=effect, parameters=(), scale=(), probe=(), lower=(), upper=(), fixed={name: 1.0}, switch=True, **target
    )  # fmt: skip


def hypotheses(model: Model, there: Mapping[str, bool]) -> list[Hypothesis]:
    """Return all hypotheses that these sensors (`VehicleLog.there`) could show anything of."""
    found = []
    for each in (*_all(model), *_currents(there)):
        needed = SENSORS_OF.get(each.effect)
        if each.sensor is not None:
            needed = {"imu": "accelerometer"}.get(each.sensor, each.sensor)
        if each.effect == "imu_bias":
            needed = "gyro" if each.parameters == ("rate",) else "accelerometer"
        if needed is None or there.get(needed, False):
            found.append(each)
    return found


def _currents(there: Mapping[str, bool]) -> Iterator[Hypothesis]:
    """Yield the current of the water, as far as a sensor tells motion over ground.

    How a vehicle moves through the water, and all that gyro and accelerometer read of it, is the same in any steady
    current (Galileo): without such a sensor a current is but another motion at the start. A depth tells what is vertical.
    """
    told = {"north", "east", "down"} if there.get("velocity") else {"down"} if there.get("depth") else set()
    entries = tuple(entry for entry in _BODY["water_current"] if entry[0] in told)
    if entries:
        yield _made("water_current", entries)


def _all(model: Model) -> Iterator[Hypothesis]:
    N = model.thrusters
    flows = any(getattr(s.coefficients, "k_Tv", 0.0) for s in model.sets)
    for effect, entries in _OWN.items():
        if effect in ("quadratic_flow_loss", "axial_flow_loss", "flow_lag", "flow_reversal_loss") and not flows:
            continue
        for i in (None, *range(N)):
            if effect in (*_GRIDS, *_NEEDS_SPEED) and i is None:
                continue
            yield _made(effect, entries, thruster=i)
    for i in range(N):
        yield _switch("thruster_polarity", thruster=i)
        yield _switch("thruster_failure", thruster=i, kind="stopped")
        for kind in ("first_normal", "second_normal"):
            yield _made("thruster_misalignment", _TURNED, thruster=i, kind=kind)
        yield _made("thruster_misalignment", _MOVED, thruster=i, kind="position")
        reach = np.abs(model.vehicle.configuration[:3, i])
        for k in np.flatnonzero(reach > HULL_REACH):
            yield _made("hull_interaction", _BODY["hull_interaction"], thruster=i, axis=_AXES[int(k)], kind="both")
        if model.vehicle.layout[i].turn and model.vehicle.values.get("reaction_torque", 0.0) > 0.0:
            yield _made("reaction_torque", _BODY["reaction_torque"], thruster=i)
    if all(t.turn for t in model.vehicle.layout) and model.vehicle.values.get("reaction_torque", 0.0) > 0.0:
        yield _made("reaction_torque", _BODY["reaction_torque"])
    for i, j in combinations(range(N), 2):
        yield _switch("thruster_swap", thruster=i, other=j)
    for i, j in permutations(range(N), 2):
        yield _made("thruster_interaction", _BODY["thruster_interaction"], thruster=i, other=j)
    for effect in ("added_mass", "linear_drag", "quadratic_drag"):
        for axis in _AXES:
            yield _made(effect, _BODY[effect], axis=axis)
    for effect in (
        "buoyancy_offset", "cg_shift", "payload", "tether_drag", "water_density", "supply_sag",
        "imu_delay", "velocity_delay", "magnetic_disturbance", "depth_scale",
    ):  # fmt: skip
        yield _made(effect, _BODY[effect])
    # commands that are stamped too early act late, which is their delay
    yield replace(_made("log_alignment", _LOG["log_alignment"]), lower=(0.0,))
    yield _made("clock_drift", _LOG["clock_drift"])
    for a, b in (("surge", "pitch"), ("sway", "roll"), ("sway", "yaw"), ("heave", "pitch"), ("surge", "heave")):
        translation = sum(x in _AXES[:3] for x in (a, b))
        size = {2: 6.0, 1: 1.5, 0: 0.3}[translation]
        yield _made("added_mass_coupling", (("size", 0.25 * size, 0.02 * size),), axis=f"{a}-{b}")
    for a, b in permutations(_AXES, 2):
        translation = sum(x in _AXES[:3] for x in (a, b))
        size = {2: 10.0, 1: 2.0, 0: 0.3}[translation]
        yield _made("drag_coupling", (("size", size, 0.1 * size),), axis=f"{a}-{b}")
    for axis in ("x", "y", "z"):
        for effect in ("gyro_scale", "imu_misalignment", "velocity_misalignment", "velocity_scale"):
            yield _made(effect, _BODY[effect], axis=axis)
        for sensor in ("imu", "velocity", "depth"):
            yield _made("sensor_lever_arm", _BODY["sensor_lever_arm"], axis=axis, sensor=sensor)
        yield _made("imu_bias", (("rate", 0.02, 0.002),), axis=axis)
        yield _made("imu_bias", (("force", 0.3, 0.03),), axis=axis)
    for effect in ("gyro_scale", "velocity_scale"):
        yield _made(effect, _BODY[effect])
