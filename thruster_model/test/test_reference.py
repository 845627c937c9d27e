"""The reference in docs is what the definitions say."""

from pathlib import Path

from thruster_model.cli_reference import effects, reference
from thruster_model.effects.stages import LIBRARY
from thruster_model.models import MODELS

DOCS = Path(__file__).parents[2] / "docs"


def test_the_reference_in_docs_is_up_to_date():
    assert (DOCS / "models.md").read_text("utf-8") == reference()
    assert (DOCS / "effects.md").read_text("utf-8") == effects()


def test_every_effect_stands_in_the_reference_with_all_its_sizes():
    rows = {line.split("`")[1]: line for line in effects().splitlines() if line.startswith("| `")}
    assert set(rows) == set(LIBRARY)
    for name, effect in LIBRARY.items():
        assert all(f"{p.name} [{p.unit}]" in rows[name] for p in effect.parameters) and effect.title in rows[name]


def test_every_model_and_each_of_its_parameters_stands_in_the_reference():
    text = reference()
    for model in MODELS.values():
        section = text.split(f"## `{model.name}`")[1].split("\n## ")[0]
        assert all(f"| {name} |" in section for name in model.parameter_names)
