"""The diagnosis knows no effect by name: what is particular to one stands in its own file."""

import ast
from pathlib import Path

import pytest

import gap_diagnosis
from thruster_model.effects.stages import LIBRARY

PACKAGE = Path(gap_diagnosis.__file__).parent
FILES = sorted({*PACKAGE.glob("*.py"), *(PACKAGE / "report").glob("*.py")})


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_no_effect_is_known_by_name(file):
    tree = ast.parse(file.read_text())
    said = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)}
    assert not said & set(LIBRARY)
