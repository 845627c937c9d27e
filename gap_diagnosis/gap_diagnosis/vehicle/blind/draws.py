"""What a sealed case hides and how it is excited, drawn from a seed."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

__all__ = ["OUTSIDE_TOO", "Draw", "drawn"]

EFFECTS: dict[str, tuple[tuple[str, float, float], ...]] = {
    # effect -> parameter, least and largest size; a place is drawn by what it acts on
    "thrust_loss": (("share", 0.15, 0.7),),
    "thrust_asymmetry": (("share", 0.2, 0.5),),
    "throttle_gain": (("share", 0.15, 0.5),),
    "dead_zone_shift": (("voltage", 0.15, 0.4),),
    "viscous_friction": (("share", 0.2, 0.8),),
    "coulomb_friction": (("deceleration", 150.0, 500.0),),
    "command_delay": (("time", 0.04, 0.2),),
    "command_lag": (("time", 0.05, 0.3),),
    "cavitation": (("share", 0.3, 1.0), ("onset", 65.0, 135.0)),
    "thermal_fade": (("share", 0.25, 0.5), ("time_constant", 12.0, 75.0)),
    "thruster_failure": (),
    "thruster_polarity": (),
    "thruster_swap": (),
    "thruster_misalignment": (("angle", 0.12, 0.3),),
    "hull_interaction": (("share", 0.25, 0.6),),
    "thruster_interaction": (("share", 0.3, 0.6),),
    "reaction_torque": (("share", 0.5, 1.0),),
    "supply_sag": (("share", 0.15, 0.5),),
    "added_mass": (("share", 0.5, 0.8),),
    "linear_drag": (("share", 0.7, 0.8),),
    "quadratic_drag": (("share", 0.6, 0.8),),
    "buoyancy_offset": (("force", 1.5, 10.0),),
    "payload": (("mass", 0.3, 2.0),),
    "cg_shift": (("x", 0.01, 0.03), ("y", 0.01, 0.03)),
    "water_current": (("north", 0.05, 0.3), ("east", 0.05, 0.3)),
    "tether_drag": (("length", 10.0, 60.0),),
    "gyro_scale": (("share", 0.05, 0.2),),
    "imu_delay": (("time", 0.04, 0.2),),
    "imu_bias": (("rate", 0.01, 0.05),),
    "imu_misalignment": (("angle", 0.05, 0.25),),
    "velocity_delay": (("time", 0.1, 0.6),),
    "velocity_scale": (("share", 0.08, 0.25),),
    "velocity_misalignment": (("angle", 0.06, 0.25),),
    "magnetic_disturbance": (("angle", 0.1, 0.4),),
    "cb_shift": (("x", 0.025, 0.045), ("y", 0.025, 0.045)),
    "ram_drag": (("diameter", 0.05, 0.15),),
}
LATER = ("ram_drag",)
"""Drawn in place of others, about as often as each, so that seeds without them keep what they had."""
SIGNED = (
    "thrust_asymmetry", "dead_zone_shift", "thruster_misalignment", "buoyancy_offset", "cg_shift", "water_current",
    "gyro_scale", "imu_bias", "imu_misalignment", "velocity_scale", "velocity_misalignment", "magnetic_disturbance",
    "cb_shift",
)  # fmt: skip
ONE_SIGN = ("dead_zone_shift", "thrust_asymmetry")
"""The library has them with one sign only."""
OF_THRUSTER = (
    "thrust_loss", "thrust_asymmetry", "throttle_gain", "dead_zone_shift", "viscous_friction", "coulomb_friction",
    "command_delay", "command_lag", "cavitation", "thermal_fade", "thruster_failure", "thruster_polarity",
    "thruster_misalignment", "hull_interaction", "thruster_swap", "thruster_interaction",
)  # fmt: skip
OUTSIDE = ("lift", "breathing_thrust", "leak")
OUTSIDE_TOO = ("sliding_water", "moving_arm", "vibration")
"""Half of the cases outside have one of these: what remembers, what moves by itself, what a sensor takes for motion."""
SETS = ("bluerov2_heavy", "ngs")
KINDS = ("steps", "sines", "pulses")
PERIODS = (0.02, 0.04, 0.05, 0.1)
"""[s] Between commands."""
EVERY = {"imu": 0.01, "depth": 0.1, "velocity": 0.2, "tachometer": 0.04, "battery": 0.2}
"""[s] Between readings."""


@dataclass(frozen=True, kw_only=True)
class Draw:
    """One case before it is simulated.

    Attributes:
        seed: of everything.
        vehicle: name of the believed set.
        effects: (id, target, sizes) each; none: no gap beyond the parameters.
        outside: of `OUTSIDE` or `OUTSIDE_TOO`, or "".
        deviations: parameters are off by so many of their deviations.
        wrench: deviation of the force [N]; the moment's is a fifth of it in N m; time: its correlation time [s].
        noise: factor of the sensors' noises.
        kinds: of the runs; duration [s] of each.
        begins: run and time [s] in it from which on its only effect, a loss of thrust, is there, and the last run with
            it; None: it is there all along.
        missing: sensors that are not there.
        period: between commands [s]; every: between readings, by sensor [s]; whole: tachometers tell whole rpm.
    """

    seed: int
    vehicle: str
    effects: tuple[tuple[str, Mapping[str, Any], Mapping[str, float]], ...] = ()
    outside: str = ""
    deviations: float = 1.0
    wrench: float = 0.15
    time: float = 3.0
    noise: float = 1.0
    kinds: tuple[str, ...] = ("steps", "sines")
    duration: float = 45.0
    begins: tuple[int, float, int] | None = None
    missing: tuple[str, ...] = field(default=())
    period: float = 0.04
    every: Mapping[str, float] = field(default_factory=lambda: EVERY)
    whole: bool = False


def _place(rng: np.random.Generator, effect: str, thrusters: int) -> dict[str, Any]:
    axes = ("surge", "sway", "heave", "roll", "pitch", "yaw")
    target: dict[str, Any] = {}
    if effect in OF_THRUSTER:
        target["thruster"] = int(rng.integers(thrusters))
    if effect in ("thruster_swap", "thruster_interaction"):
        i, j = map(int, rng.choice(thrusters, 2, replace=False))
        target["thruster"], target["other"] = (min(i, j), max(i, j)) if effect == "thruster_swap" else (i, j)
    if effect == "thruster_failure":
        target["kind"] = "stopped"
    if effect == "thruster_misalignment":
        target["kind"] = str(rng.choice(("first_normal", "second_normal")))
    if effect in ("added_mass", "linear_drag", "quadratic_drag"):
        target["axis"] = str(rng.choice(axes[:3] if effect == "linear_drag" else axes))
    if effect in ("imu_misalignment", "velocity_misalignment", "imu_bias"):
        target["axis"] = str(rng.choice(("x", "y", "z")))
    return target


def drawn(seed: int, *, only: str | None = None) -> Draw:
    """Return the case of a seed; `only`: its kind instead of a drawn one: none, one, pair, outside, or
    failing, a loss of thrust that begins in mid-run."""
    rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(77,)))
    vehicle = str(rng.choice(SETS))
    thrusters = {"bluerov2_heavy": 8, "ngs": 6}[vehicle]
    kind = only or str(rng.choice(("none", "one", "pair", "outside"), p=(0.2, 0.55, 0.1, 0.15)))
    names = [n for n in EFFECTS if n not in LATER and (n != "reaction_torque" or vehicle == "ngs")]
    count = {"none": 0, "one": 1, "pair": 2, "outside": 0, "failing": 1}[kind]
    missing: tuple[str, ...] = ()
    if rng.random() < 0.35:
        missing = ("velocity", "tachometer", "battery") if rng.random() < 0.5 else ("velocity",)
    if "velocity" in missing:
        names = [n for n in names if not n.startswith("velocity")]
    begins: tuple[int, float, int] | None = None
    kinds: tuple[str, ...] = KINDS
    if kind == "failing":  # pulses would not tell when
        kinds = KINDS[:2]
        names, onset = ["thrust_loss"], np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(91,)))
        run = int(onset.integers(2))
        begins = run, float(onset.uniform(8.0, 37.0)), int(onset.integers(run, 2))
    effects = []
    later = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(90,)))
    for effect in map(str, rng.choice(names, count, replace=False)):
        sizes = {}
        for parameter, low, high in EFFECTS[effect]:
            sign = rng.choice((-1.0, 1.0)) if effect in SIGNED and effect not in ONE_SIGN else 1.0
            sizes[parameter] = float(sign * rng.uniform(low, high))
        if effect == "payload":
            sizes |= {a: float(rng.uniform(-0.25, 0.25)) for a in "xyz"}
        if effect == "tether_drag":
            anchor = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(87,)))
            sizes |= {"x": float(anchor.uniform(-0.3, 0.0)), "y": float(anchor.uniform(-0.1, 0.1))}
            sizes |= {"z": float(rng.uniform(-0.2, 0.2))}
        effects.append((effect, _place(rng, effect, thrusters), sizes))
        if begins is None and later.random() < len(LATER) / len(EFFECTS):
            effect = str(later.choice(LATER))
            effects[-1] = (effect, {}, {name: float(later.uniform(low, high)) for name, low, high in EFFECTS[effect]})
    outside = str(rng.choice(OUTSIDE)) if kind == "outside" else ""
    other = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(88,)))
    if outside and other.random() < 0.5:
        outside = str(other.choice(OUTSIDE_TOO))
    return Draw(
        seed=seed, vehicle=vehicle, effects=tuple(effects), outside=outside,
        deviations=float(rng.uniform(0.4, 1.2)), wrench=float(rng.uniform(0.02, 0.4)),
        time=float(np.exp(rng.uniform(np.log(0.5), np.log(10.0)))), noise=float(np.exp(rng.uniform(-1.1, 1.1))),
        kinds=tuple(str(k) for k in rng.choice(kinds, 2, replace=False)), begins=begins, missing=missing,
        period=float(rng.choice(PERIODS)),
        every={
            "imu": float(rng.choice((0.01, 0.02, 0.024, 0.04))), "depth": float(rng.choice((0.1, 0.2))),
            "velocity": float(rng.choice((0.124, 0.2))), "tachometer": float(rng.choice((0.04, 0.05, 0.1))),
            "battery": 0.2,
        },
        whole=bool(rng.random() < 0.5),
    )  # fmt: skip
