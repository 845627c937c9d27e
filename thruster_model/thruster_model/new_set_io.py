"""The text of a new parameter set to be edited: each parameter with its meaning, unit and range as comments."""

import textwrap
from pathlib import Path

import yaml

from thruster_model.errors import ParameterSetError
from thruster_model.models import MODELS, Model, ParameterDefinition
from thruster_model.parameter_set import ParameterSet
from thruster_model.parameter_set_io import available_sets, dump_parameter_set, load_parameter_set

__all__ = ["commented", "new_set"]

_WIDTH = 118


def new_set(model: str, base: str | None = None, folder: Path = Path()) -> str:
    """Return the commented YAML text of a new set, which the reader of sets takes as it is.

    Args:
        model: name of the model; its values are those of the set of the same name.
        base: a set of that model, by name or file, on which the new one stands: its parameters are listed as comments,
            to be changed by uncommenting them.
        folder: of the new set, from which a base's file is looked for.

    Raises:
        ParameterSetError: unknown model, or a base that cannot be read or is of another model.
    """
    if model not in MODELS:
        raise ParameterSetError("new set", [f"expected a model, one of {', '.join(MODELS)}; found '{model}'"])
    name = model if base is None else base
    stands_on = load_parameter_set(name if name in available_sets() else folder / name)
    if stands_on.model_name != model:
        raise ParameterSetError(str(base), [f"expected a set of model '{model}'; found '{stands_on.model_name}'"])
    head = commented(*_head(MODELS[model], complete=base is None))
    return head + (_complete(stands_on) if base is None else _on_base(stands_on, base))


def _head(model: Model, *, complete: bool) -> list[str]:
    if complete:
        told = "All values are those of the set of the model's name: replace them, and each `source`, by your own."
    else:
        told = (
            "What is not named here is the base's. Take the # off the parameters that differ, and write your numbers."
        )
    return [
        f"A parameter set of the model {model.name}: {model.title}.",
        model.cannot,
        "Its equations:",
        *(f"  {equation}" for equation in model.equations),
        told,
        "`standard_deviation` says how far a value may be off: one sigma, half of what a data sheet calls its "
        "tolerance. A diagnosis takes 5 % of the value where there is none, so that a 0 is exact.",
    ]


def _complete(start: ParameterSet) -> str:
    lines = []
    inside = False
    for line in dump_parameter_set(start).split("\n"):
        inside = line == "parameters:" if line and not line.startswith(" ") else inside
        name = line.strip().removesuffix(":")
        if inside and line.startswith("  ") and not line.startswith("   "):
            lines.append(f"  # {_meaning(start.model.definition(name))}")
        lines.append(line)
    return "\n".join(lines)


def _on_base(base: ParameterSet, name: str) -> str:
    stated = {"base": name, "name": f"{base.name}, changed", "source": "who measured what differs, and how"}
    lines = [yaml.safe_dump(stated, sort_keys=False, width=1000, allow_unicode=True) + "parameters:"]
    for key, parameter in base.parameters.items():
        lines += [f"  # {_meaning(base.model.definition(key))}", f"  # {key}: {parameter.value!r}"]
    return "\n".join(lines) + "\n"


def _meaning(definition: ParameterDefinition) -> str:
    limits = f"{definition.lower:g} to {definition.upper:g}"
    given = "; given, never fitted" if definition.role == "given" else ""
    return f"{definition.meaning} [{definition.unit}], {limits}{given}"


def commented(*sentences: str) -> str:
    return "".join(f"# {line}\n" for sentence in sentences for line in textwrap.wrap(sentence, _WIDTH))
