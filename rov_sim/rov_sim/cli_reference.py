"""The reference of vehicles and of a vehicle's unmodelled effects as Markdown, from their definitions."""

import argparse
import sys
from collections.abc import Sequence

from rov_sim.vehicle.effects.active import VEHICLE_LIBRARY
from rov_sim.vehicle.effects.effect import VehicleEffect
from rov_sim.vehicle.sensors.settings_io import usual_settings
from run_bag.command_line import user_arguments
from thruster_model.effects.effect import EffectParameter
from thruster_model.vehicle_coefficients import STIR
from thruster_model.vehicle_layout import FRAMES
from thruster_model.vehicle_parameters import AXES, DEFAULTS, REQUIRED, defined, definition_of
from thruster_model.vehicle_set import VehicleSet
from thruster_model.vehicle_set_io import available_vehicles, load_vehicle_set

_EQUATIONS = (
    "M = M_RB + A             A, L, Q: about the origin, as all positions are",
    "M_RB = [m I, -m S(r_G); m S(r_G), I_O]   I_O: inertia about the origin; S(a) b = a x b  (2.7)",
    "M dnu_r/dt = -C(nu_r) nu_r - (L + Q |nu_r|) nu_r - g + sum_i [axis_i; position_i x axis_i] T_i",
    "nu_r = [velocity - R^T current; rate]    through the water, body axes; R: body to earth",
    "C(nu_r) nu_r = [rate x a; rate x b + velocity_r x a],  [a; b] = M nu_r  (2.12)",
    "g = -[(W - B) down; (W r_G - B r_B) x down]   down: R^T (0, 0, 1)  (2.18)",
    "W = mass gravity, B = density volume gravity",
    "U_i = [axis_i; position_i x axis_i]^T nu_r   the flow at thruster i, U of its model in place of (4.5)  (4.20)",
)
_MORE = (
    "net_buoyancy", "x_G", "y_G", "z_G", "x_B", "y_B", "I_xy", "I_xz", "I_yz", "density", "gravity", "reaction_torque",
)  # fmt: skip
"""What a set may state, beside entries of matrices."""
_SENSORS = """
## Sensors of a simulation

What a file of `--sensors` may state, each entry with value, unit and source; left out, it is as here. A diagnosis \
reads [a few of them](own_dive.md) alone. `rotation` is roll, pitch, yaw (3-2-1) from the body's axes to the sensor's. \
`phase` is the instant of the first reading, `delay` how long after its instant a reading comes. `lost_share` of the \
readings hold nothing, `lost_length` in a row. A `noise` is a standard deviation from reading to reading, a `bias` \
constant, a `bias_deviation` what is added to it at random, once in a run. A list has a value for each axis of the \
sensor; one value holds for all.

"""
_IDLE = (
    "An idle thruster in a stream: v = 0 is an equilibrium of (4.4) that no water keeps. So where n and v "
    f"are exactly 0, as before a first command, and k_Uv k_w |U| > k_v, a step begins with v = {STIR:g} m/s sgn(U), "
    "and v grows by (4.4). Of a rotor that has turned n and v come near 0 and never there: a stream the other way does "
    "not turn its v.\n"
)
_SUPPLY = """\
### Supply

```text
V = V_0 - R sum_k i_k   R: 0 without the effect `supply_sag`; gamma times V / V_n for each thruster
i_k = |gamma_k n_k| / (gamma_full n_full)   of thruster k: 1 at full throttle and speed
```

V_n is `nominal_voltage` of the [sensors' file](own_dive.md). V_0, the battery's voltage at rest, is V_n in a \
simulation. A diagnosis follows it slowly where `rov/battery` logs it; elsewhere [its level and its \
rate](vehicle_gap.md#what-is-believed) are uncertain. A healthy battery's sensor reads V and, negative while it is \
drawn, -(`idle_current` + `current_at_full` times the mean of i_k). In i_k, gamma is that at V_n. By model it is, with \
what multiplies it by V / V_n:

| models | gamma | gamma_full | n_full |
|---|---|---|---|
| `force_table` | x; its curves are read at V / V_n in place of a product | x at 5 V, or at -5 V where larger | \
largest speed of the table, at any supply, times `command_scale` |
| `first_order` | g(u) | g(5 V), alike | g(5 V) |
| `bessa`, `two_state`, `yoerger` | k_3 u | 5 V k_3 | as in [effects.md](effects.md#in-the-command) |
| `static_dead_band`, `static_quadratic`, `table` | they have no rotor: i_k is 0 | - | - |
| all others | gamma(u) | gamma(5 V), alike | as in effects.md |

Currents of a force table, and `state.current` of thrusters, have no part in it.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the reference; return the exit status."""
    argparse.ArgumentParser(prog="reference", description=__doc__).parse_args(user_arguments(arguments))
    print(reference(), end="")
    return 0


def reference() -> str:
    """Return the whole reference."""
    head = (
        "# Vehicles and their effects\n\n"
        "Made by `ros2 run rov_sim reference`. Body axes x forward, y starboard, z down; thrusters count from 0. A "
        "standard deviation that no source states is 5 % of the value; of 0 it is none, which a fit and a diagnosis "
        "take for exact. Thrusters' models: [models.md](models.md). "
        "A propeller's hand is `right` where it turns clockwise, seen along its axis, while it pushes along it; its "
        "torque acts on the vehicle where the effect `reaction_torque` is on.\n"
    )
    water = ", ".join(f"{key} {value:g} {defined(key).unit}" for key, value in DEFAULTS.items())
    equations = (
        "\n## Equations\n\n"
        "Numbers in brackets are the thesis'. g stands with a minus where it acts, so weight pushes down. "
        f"Where a set does not state them: {water}; all else that a set may leave "
        "out is zero.\n\n" + "\n".join(("```text", *_EQUATIONS, "```")) + "\n\n" + _IDLE + "\n" + _SUPPLY
    )
    vehicles = _parameters() + "".join(_vehicle(name, load_vehicle_set(name)) for name in available_vehicles())
    frames = (
        "\n## Frames of ArduSub\n\nWhich way a positive command of motor 1, 2, ... pushes; 45 degrees between two "
        "directions. Motor 1 is `thruster_0`.\n\n| frame | motors |\n|---|---|\n"
    ) + "".join(f"{_row([f'`{name}`', '; '.join(map(_way, axes))])}\n" for name, axes in FRAMES.items())
    heads = ["effect", "what it is", "enters", "equation", "parameters", "acts on"]
    lines = [
        "\n## Effects of a vehicle\n",
        "Switched on in a vehicle's set under `effects`, with those of single thrusters (`ambient_current`, "
        "`tank_recirculation` and those of a load cell excepted). What it acts on stands beside its `id`: `{id: "
        "drag_coupling, axis: sway-yaw, parameters: {size: {value: 3, unit: N s}}}`. Axes of the body are surge, sway, "
        "heave, roll, pitch and yaw, those of a sensor x, y and z. Without an optional place it acts on all.\n",
        _row(heads),
        "|" + "---|" * len(heads),
        *(_effect(effect) for effect in VEHICLE_LIBRARY.values()),
        "",
        "- Where those of a thruster act, and in which order: [effects.md](effects.md). They change the T that drives "
        "v in (4.4); losses of thrust in this table do not.",
        *(f"- `{effect.id}`: {effect.note}." for effect in VEHICLE_LIBRARY.values() if effect.note),
    ]
    return head + equations + vehicles + frames + "\n".join(lines) + "\n" + _sensors()


def _parameters() -> str:
    """Return what a set may state beside what it must, with units; entries of matrices by their units."""
    rows = [_row([f"`{name}`", defined(name).meaning, defined(name).unit]) for name in _MORE]
    for kind, word in (("A", "added mass"), ("L", "linear drag"), ("Q", "quadratic drag")):
        own: dict[str, list[str]] = {}
        for name in (f"{kind}_{a}{b}" for a in AXES for b in AXES if a != b):
            if (definition := definition_of(name)) is not None:
                own.setdefault(definition.unit, []).append(f"`{name}`")
        rows += [_row([", ".join(names), f"{word} beside the diagonal", unit]) for unit, names in own.items()]
    heads = ["parameter", "meaning", "unit"]
    return (
        f"\n## What a set may state\n\nRequired are {', '.join(f'`{name}`' for name in REQUIRED)}, in the units of the "
        "tables below. In place of `volume` a set may state `net_buoyancy`: of a trimmed vehicle it is known far "
        "better than mass and volume are. A unit may be spelt in any usual way: `kg/m^3`, `kg/m3`, `kg m^-3`. The "
        "origin is yours to choose. Put it near the centre of mass: A, L and Q are about it, as in literature, "
        "and what is beside their diagonals grows with the distance.\n\n"
        + "\n".join([_row(heads), "|" + "---|" * len(heads), *rows])
        + "\n"
    )


def _sensors() -> str:
    """Return the settings of sensors that hold where a file leaves them out."""
    rows = [
        _row([sensor, f"`{key}`", _value(entry["value"]), entry["unit"], entry["source"]])
        for sensor, entries in usual_settings().items()
        for key, entry in entries.items()
    ]
    heads = ["sensor", "entry", "value", "unit", "source"]
    return _SENSORS + "\n".join([_row(heads), "|" + "---|" * len(heads), *rows]) + "\n"


def _value(value: object) -> str:
    """Return a value as YAML has it, of lists the numbers."""
    if isinstance(value, bool):
        return str(value).lower()
    return ", ".join(f"{x:g}" for x in value) if isinstance(value, list) else f"{value:g}"


def _vehicle(name: str, vehicle: VehicleSet) -> str:
    heads = ["parameter", "meaning", "value", "std", "unit", "source"]
    lines = [f"\n## `{name}`: {vehicle.name}\n", f"{vehicle.source}. Thrusters' set: `{vehicle.model}`.\n"]
    lines += [_row(heads), "|" + "---|" * len(heads)]
    for key, p in vehicle.parameters.items():
        deviation = f"{vehicle.deviation(key):.3g}"
        lines.append(_row([key, defined(key).meaning, f"{p.value:.6g}", deviation, p.unit, p.source]))
    heads = ["thruster", "position [m]", "axis", "hand"]
    lines += ["", _row(heads), "|" + "---|" * len(heads)]
    for thruster in vehicle.layout:
        position, axis = (", ".join(f"{x:.6g}" for x in each) for each in (thruster.position, thruster.axis))
        lines.append(_row([thruster.name, position, axis, thruster.hand or "not known"]))
    return "\n".join(lines) + "\n"


def _way(axis: Sequence[float]) -> str:
    """Return a direction in body axes in words."""
    words = (("backward", "forward"), ("port", "starboard"), ("up", "down"))
    return " and ".join(both[x > 0.0] for x, both in zip(axis, words, strict=True) if x)


def _effect(effect: VehicleEffect) -> str:
    needed, more = (", ".join(_target(effect, each) for each in own) for own in (effect.needs, effect.may_take))
    targets = [each for each in (needed, f"optional: {more}" if more else "") if each]
    return _row(
        [
            f"`{effect.id}`",
            effect.title,
            effect.block,
            effect.equation,
            "; ".join(_parameter(p) for p in effect.parameters),
            "; ".join(targets) or "the vehicle",
        ]
    )


def _target(effect: VehicleEffect, target: str) -> str:
    """Return what an effect acts on, with what may be chosen."""
    choices = effect.choices.get(target, ())
    if target != "axis" or not choices:
        return f"{target} ({', '.join(choices)})" if choices else target
    return f"axis (two, as {choices[0]})" if "-" in choices[0] else f"axis ({choices[0]} to {choices[-1]})"


def _parameter(p: EffectParameter) -> str:
    sign = "±" if p.both_signs else ""
    return f"{p.name} [{p.unit}] {sign}{p.lower:g} to {p.upper:g}"


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


if __name__ == "__main__":
    sys.exit(main())
