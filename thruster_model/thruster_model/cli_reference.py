"""The reference of models and parameter sets as Markdown, from their definitions."""

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import get_args

from run_bag.command_line import user_arguments
from thruster_model.effects.chains import in_chain
from thruster_model.effects.effect import Block, Effect, EffectParameter
from thruster_model.effects.stages import LIBRARY, in_stage
from thruster_model.equations.classes import (
    AmbientInflowCoefficients,
    ForceTableCoefficients,
    StaticCoefficients,
    SteadyFlowCoefficients,
    TableCoefficients,
)
from thruster_model.model import ParameterDefinition
from thruster_model.models import MODELS, Model
from thruster_model.parameter_set import ParameterSet
from thruster_model.parameter_set_io import available_sets, load_parameter_set
from thruster_model.unmoved import unmoved

_STATES = {  # where axial flow or rotor speed follow at once, they are no states
    SteadyFlowCoefficients: "n [rad/s], U [m/s]",
    AmbientInflowCoefficients: "n [rad/s], U [m/s]",
    ForceTableCoefficients: "n [rad/s]",
    StaticCoefficients: "none",
    TableCoefficients: "none",
}
_READ_AS = {SteadyFlowCoefficients: "v, which follows at once", AmbientInflowCoefficients: "U, as `flow.ambient` is"}
"""What `flow.axial` is read as where the axial flow is no state."""
_NEXT_TO_0 = 1e-3
"""Share of a parameter's usual size below which a value's 5 % are nothing."""
_BLOCKS = {
    "log": "In the log", "command": "In the command", "rotor": "In the rotor", "thrust": "In thrust and torque",
    "flow": "In the flow", "sensor": "In the sensors",
}  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the reference; return the exit status."""
    parser = argparse.ArgumentParser(prog="reference", description=__doc__)
    parser.add_argument("--effects", action="store_true", help="that of the effects of a thruster, in their place")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="draw what each effect does to what sensors read")
    given = parser.parse_args(user_arguments(arguments))
    if given.picture is not None:
        from thruster_model.effect_signatures_io import draw_signatures  # kernels take seconds to load

        try:
            draw_signatures(given.picture)
        except (OSError, ValueError) as error:
            print(error, file=sys.stderr)
            return 1
        print(given.picture)
        return 0
    print(effects() if given.effects else reference(), end="")
    return 0


def effects() -> str:
    """Return the reference of the effects of a thruster, its sensors and its log."""
    lines = [
        "# Effects of a thruster",
        "",
        "Made by `ros2 run thruster_model reference --effects`. Each is one file in `thruster_model/effects/library`: "
        "switched on in a parameter set's YAML or by `--effect ID.SIZE=VALUE`, suspected by a diagnosis. Those of a "
        "whole vehicle: [vehicles.md](vehicles.md). How to add one: [extend.md](extend.md).",
        "",
        'A size has its unit, its plausible range and the value at which there is exactly no effect ("none at"), or '
        'that it has where none is given ("else"). "Alike": effects that recordings of one thruster cannot tell from '
        "it. A diagnosis estimates all sizes of an effect within their ranges, an onset too, and does not claim it "
        "where recordings ask for more. It finds by its runs and model whether an effect is parametric, as parameters "
        "far off could do the same, or structural, as they could not.",
        "",
        "A run starts, and its t is 0, with its first command, whatever the stamps are. What was before, for effects "
        "that remember: `thermal_fade` begins cold, `tank_recirculation` with U = 0, `load_cell_resonance` at rest. "
        "`tach_lag` and `flow_delay` begin at their first value. `command_delay` and `command_lag` begin with the u of "
        "[models.md](models.md): 0, or the first command where the rotor already turns.",
        "",
        "What each does to what sensors read, less what they read without it, at half its range (`reference --picture "
        "FILE`). The number is the largest change; grey: none.",
        "",
        "![Changes of rotor speed, axial and ambient flow, thrust and torque, a row an effect](effects.png)",
    ]
    heads = ["effect", "what it is", "equation", "sizes", "alike"]
    for block in get_args(Block):
        of_block = [effect for effect in LIBRARY.values() if effect.block == block]
        lines += ["", f"## {_BLOCKS[block]}", _row(heads), "|" + "---|" * len(heads)]
        lines += [_effect(effect) for effect in of_block]
        more = [*_of_block(block), *(f"`{effect.id}`: {effect.note}." for effect in of_block if effect.note)]
        lines += ["", *(f"- {each}" for each in more)] if more else []
    return "\n".join([*lines, *_unmoved()]) + "\n"


def _unmoved() -> list[str]:
    """Return the section on models that an effect changes nothing in, a row for all effects that are alike in this."""
    alike: dict[tuple[str, ...], list[str]] = {}
    for name, models in unmoved(map(load_parameter_set, available_sets())).items():
        alike.setdefault(models, []).append(name)
    heads = ["effects", "change nothing in the models"]
    rows = [[", ".join(f"`{each}`" for each in of) for of in (names, models)] for models, names in alike.items()]
    return [
        "",
        "## Which model knows which effect",
        "All other effects act in every [model](models.md); those of a sensor where the model has what it reads.",
        "",
        _row(heads),
        "|" + "---|" * len(heads),
        *map(_row, rows),
    ]


def _of_block(block: Block) -> list[str]:
    """Return what holds of all effects of a block."""
    if block == "log":
        return [
            "They are looked for in columns with one time as well: what is off is when a reading was made, beside the "
            "time of its row."
        ]
    if block == "command":
        return [
            f"Order: {_order(in_chain('command'))}; then the throttle u follows behind `command_lag`, at the slower of "
            "`throttle_rate_limit` and u_dot_max at most. Dead zone and gamma have this u.",
            "In models without gamma it is what drives the rotor: k_3 u, g(u), or x of `force_table`.",
        ]
    if block == "rotor":
        return [
            "k_n is k_1 in `bessa` and `two_state`. In `first_order` and `force_table` it is the `rate` of the term "
            "-rate n alone: more of it lowers the steady speed, too."
        ]
    if block == "thrust":
        last = in_stage("thrust_dynamics")
        order = _order([*(effect for effect in in_stage("loads") if effect not in last), *last])
        return [
            "The T that drives v and U is this one: where thrust is lost, the water is driven less, too. Q stays where "
            "an equation does not name it.",
            "v is the axial flow of the model: in `kim_chung` k_s U cos(inflow_angle) + k_r n, in `four_quadrant` U.",
            f"Order: {order}. Each takes the T that those before it have left.",
        ]
    if block == "sensor":
        return [
            *(
                f"Order of the {name}: {_order(in_chain('sensor', signal))}."
                for name, signal in (("tachometer", "speed"), ("velocimeter", "ambient"), ("load cell", "thrust"))
            ),
            "The equations are of readings without noise. In a recording it is there before rounding and threshold; "
            "`simulate` adds it behind them.",
            "Not in the library: a lag of the velocimeter, and one of the load cell other than its resonance.",
        ]
    return []


def _order(effects: Sequence[Effect]) -> str:
    return ", ".join(f"`{effect.id}`" for effect in effects)


def _effect(effect: Effect) -> str:
    switches = effect.parameters if effect.apart else effect.parameters[:1]
    sizes = "; ".join(_size(p, switch=p in switches) for p in effect.parameters)
    alike = ", ".join(f"`{twin.partition(':')[0]}`" for twin in effect.twins)
    return _row([f"`{effect.id}`", effect.title, effect.equation, sizes, alike or "-"])


def _size(p: EffectParameter, *, switch: bool) -> str:
    """Return a size; `switch`: there is no effect where it is neutral."""
    sign = "±" if p.both_signs else ""
    neutral = f"none at {p.neutral:g}" if switch else f"else {p.neutral:g}"
    return f"{p.name} [{p.unit}], {p.meaning}: {sign}{p.lower:g} to {p.upper:g}, {neutral}"


def reference() -> str:
    """Return the whole reference."""
    head = (
        "# Models and parameter sets\n\n"
        "Made by `ros2 run thruster_model reference`; numbers of equations are the thesis'. Input of every model: the "
        "throttle u [V], positive forward. Outputs: rotor speed n [rad/s], thrust T [N], torque Q [N m] and, where the "
        'model has them, axial flow v and ambient flow U [m/s]. "Fitted" parameters are identified, the others given.\n'
        "\n"
        "Where there is a u_dot_max, u follows its command at that rate at most; elsewhere u is the command. It begins "
        "at 0, or where the rotor "
        "already turns at the first command. All equations have this u. No fit and no diagnosis adjusts u_dot_max: at "
        "100 V/s a step of 3 V takes 30 ms. State yours where your controller is faster, 1e5 for a step at once. A "
        "slower one is the effect `throttle_rate_limit`. Which effect changes nothing in which model: [effects.md]"
        "(effects.md#which-model-knows-which-effect). A fit, a check and a diagnosis take all of these "
        "models. Random pushes of a diagnosis act on states: a model without one has none.\n"
        "\n"
        '"Usual" is the size and the sign that a parameter has as a rule; ± may be either. A set may state up to 1000 '
        "times as much, or 0, with that sign. A velocimeter goes to the channel of the flow that it stands in: "
        "`flow.axial` at the propeller, `flow.ambient` around it; one alone will do.\n"
        "\n"
        "On a vehicle k_U, k_UU and k_TU have no part, as its motion makes U (4.20), nor has c_Q of `first_order`, "
        "`bessa` and `yoerger`: a propeller's torque on it is `reaction_torque` of [its set](vehicles.md). A "
        "thrusters' set still states them, as it may be used on a bench: write any number above 0, or name a "
        "[`base`](check_and_sets.md#write-a-set) and leave them out.\n"
    )
    sets = {name: load_parameter_set(name) for name in available_sets()}
    return head + "".join(_model(model, sets) for model in MODELS.values())


def _model(model: Model, sets: Mapping[str, ParameterSet]) -> str:
    state = _STATES.get(model.kind, "n [rad/s], v [m/s], U [m/s]" if model.has_flow else "n [rad/s]")
    lines = [
        f"\n## `{model.name}`: {model.title}\n",
        f"State: {state}.  ",
        f"Flow of a recording: {_flow_read(model)}.  ",
        f"Cannot: {model.cannot}\n",
        *("```text", *model.equations, "```\n"),
    ]
    own = {name: s for name, s in sets.items() if s.model_name == model.name}
    heads = ["parameter", "meaning", "unit", "usual", "fitted", *(f"`{name}`" for name in own)]
    lines += [_row(heads), "|" + "---|" * len(heads)]
    for d in model.parameters:
        values = [f"{s.parameters[d.name].value:.6g} ({s.parameters[d.name].source})" for s in own.values()]
        lines.append(_row([d.name, d.meaning, d.unit, _usual(d), "no" if d.role == "given" else "yes", *values]))
    lines += [f"\nSet `{name}`: {s.name}; {s.source}.{_exact(s, model)}" for name, s in own.items()]
    return "\n".join(lines) + "\n"


def _flow_read(model: Model) -> str:
    """Return which channels of the flow a fit and a diagnosis compare with a model."""
    if not model.has_flow:
        return "none; `flow.axial` and `flow.ambient` are left out, as are the effects of a velocimeter"
    return f"`flow.axial` as {_READ_AS.get(model.kind, 'v')}; `flow.ambient` as U"


def _usual(d: ParameterDefinition) -> str:
    """Return the usual size of a parameter with the signs that it may have."""
    sign = "+" if d.lower >= 0.0 else "−" if d.upper <= 0.0 else "±"
    return f"{sign}{d.scale:g}"


def _exact(own: ParameterSet, model: Model) -> str:
    """Return which parameters of a set a fit moves and no diagnosis does: 5 % of 0, or of next to nothing, is none."""
    fitted = [(d, own.parameters[d.name]) for d in model.parameters if d.role != "given"]
    names = [d.name for d, p in fitted if abs(p.value) < _NEXT_TO_0 * d.scale and not p.standard_deviation]
    if not names:
        return ""
    told = f"{', '.join(names[:-1])} and {names[-1]} are" if len(names) > 1 else f"{names[0]} is"
    return (
        f" A diagnosis that begins here takes what is 0 or next to it as exact: {told} moved by a `fit` alone. State a "
        "`standard_deviation` of each in [a set of yours](check_and_sets.md#write-a-set) where it may differ."
    )


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


if __name__ == "__main__":
    sys.exit(main())
