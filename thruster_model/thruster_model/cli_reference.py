"""Command line: the reference of models and parameter sets as Markdown, from their definitions."""

import argparse
import sys
from collections.abc import Mapping, Sequence

from run_bag.command_line import user_arguments
from thruster_model.equations.classes import (
    AmbientInflowCoefficients,
    ForceTableCoefficients,
    StaticCoefficients,
    SteadyFlowCoefficients,
    TableCoefficients,
)
from thruster_model.models import MODELS, Model
from thruster_model.parameter_set import ParameterSet
from thruster_model.parameter_set_io import available_sets, load_parameter_set

_STATES = {  # where axial flow or rotor speed follow at once, they are no states
    SteadyFlowCoefficients: "n [rad/s], U [m/s]",
    AmbientInflowCoefficients: "n [rad/s], U [m/s]",
    ForceTableCoefficients: "n [rad/s]",
    StaticCoefficients: "none",
    TableCoefficients: "none",
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the reference; return the exit status."""
    argparse.ArgumentParser(prog="reference", description=__doc__).parse_args(user_arguments(arguments))
    print(reference(), end="")
    return 0


def reference() -> str:
    """Return the whole reference."""
    head = (
        "# Models and parameter sets\n\n"
        "Made by `ros2 run thruster_model reference`; equation numbers are the thesis'. Input of every model: the "
        "throttle u [V], positive forward. Outputs: rotor speed n [rad/s], thrust T [N], torque Q [N m] and, where the "
        'model has them, axial flow v and ambient flow U [m/s]. "Fitted" parameters are identified, the others given.\n'
    )
    sets = {name: load_parameter_set(name) for name in available_sets()}
    return head + "".join(_model(model, sets) for model in MODELS.values())


def _model(model: Model, sets: Mapping[str, ParameterSet]) -> str:
    state = _STATES.get(model.kind, "n [rad/s], v [m/s], U [m/s]" if model.has_flow else "n [rad/s]")
    lines = [
        f"\n## `{model.name}`: {model.title}\n",
        f"Equations: {model.equations}.  ",
        f"State: {state}.  ",
        f"Cannot: {model.cannot}\n",
    ]
    own = {name: s for name, s in sets.items() if s.model_name == model.name}
    heads = ["parameter", "meaning", "unit", "fitted", *(f"`{name}`" for name in own)]
    lines += [_row(heads), "|" + "---|" * len(heads)]
    for d in model.parameters:
        values = [f"{s.parameters[d.name].value:.6g} ({s.parameters[d.name].source})" for s in own.values()]
        lines.append(_row([d.name, d.meaning, d.unit, "no" if d.role == "given" else "yes", *values]))
    lines += [f"\nSet `{name}`: {s.name}; {s.source}." for name, s in own.items()]
    return "\n".join(lines) + "\n"


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


if __name__ == "__main__":
    sys.exit(main())
