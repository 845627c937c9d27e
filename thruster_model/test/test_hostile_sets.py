"""Sets, tables and maps with anything at any place: sentences that name the file, never a traceback."""

import copy
import math
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from safe_files.yaml_io import parse_yaml
from thruster_model.errors import ThrusterModelError
from thruster_model.force_table import ForceTable
from thruster_model.force_table_io import dump_force_table, parse_force_table
from thruster_model.force_table_map_io import read_column_map
from thruster_model.parameter_set_io import dump_parameter_set, load_parameter_set, parse_parameter_set
from thruster_model.vehicle_set_io import dump_vehicle_set, load_vehicle_set, parse_vehicle_set

MANY = 400
ODD: list[Any] = [
    None,
    True,
    "",
    "x",
    "1.5",
    "nan",
    0,
    -1,
    1e300,
    math.nan,
    math.inf,
    2**62,
    [],
    [1],
    {},
    {"a": 1},
    [[]],
]
FORCE = [[-2.0, 0.0, 3.0], [-3.0, 0.0, 4.0]]
TABLE = ForceTable(command=[1100.0, 1500.0, 1900.0], supply=[10.0, 12.0], force=FORCE, command_unit="µs", stop=1500.0,
                   name="a", source="b", origin="c")  # fmt: skip
COLUMNS = Path(__file__).resolve().parents[1] / "config" / "t200_columns.yaml"


def column_map(text: str, origin: str) -> object:
    Path(origin).write_text(text, "utf-8")
    return read_column_map(Path(origin))


READERS: dict[str, tuple[Callable[[], str], Callable[[str, str], object]]] = {
    "parameter set": (
        lambda: (
            dump_parameter_set(load_parameter_set("hq")) + "command: {unit: µs, stop: 1500, per_volt: 80, "
            "lowest: 1100, highest: 1900}\neffects: {coulomb_friction.deceleration: 60}\n"
        ),
        lambda text, origin: parse_parameter_set(text, origin=origin),
    ),
    "vehicle set": (
        lambda: dump_vehicle_set(load_vehicle_set("ngs")),
        lambda text, origin: parse_vehicle_set(text, origin=origin),
    ),
    "force table": (lambda: dump_force_table(TABLE), lambda text, origin: parse_force_table(text, origin=origin)),
    "column map": (lambda: COLUMNS.read_text("utf-8"), column_map),
}


def places(document: Any) -> list[tuple[Any, Any]]:
    """Return (collection, key) of every value."""
    found = []
    for key, value in document.items() if isinstance(document, dict) else enumerate(document):
        found.append((document, key))
        if isinstance(value, dict | list):
            found += places(value)
    return found


@pytest.mark.parametrize("kind", READERS)
def test_an_odd_value_anywhere_is_a_sentence_that_names_the_file(kind, tmp_path):
    dump, read = READERS[kind]
    good = parse_yaml(dump(), kind)
    rng, origin = random.Random(kind), str(tmp_path / "mine.yaml")
    for _ in range(MANY):
        document = copy.deepcopy(good)
        inside, key = rng.choice(places(document))
        if rng.random() < 0.2:
            del inside[key]
        else:
            inside[key] = rng.choice(ODD)
        text = yaml.safe_dump(document, allow_unicode=True)
        try:
            read(text, origin)
        except ThrusterModelError as error:
            assert "mine.yaml" in str(error), text


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("model: hl\nmodel: hq", "line 2: expected each key once, found 'model' again"),
        ("model: &a hl\nname: *a", "found the alias"),
        ("parameters: {k_n: {value: '13', unit: 1/s, source: x}}", "expected a number; found '13'"),
        ("parameters: {k_n: {value: null, unit: 1/s, source: x}}", "expected a number; found None"),
        ("parameters: {k_n: {value: 1:30, unit: 1/s, source: x}}", "expected a number; found '1:30'"),
        ("parameters: {k_n: {value: " + "9" * 400 + ", unit: 1/s, source: x}}", "expected a whole number below 2^63"),
        ("[" * 5000, "expected at most 32 levels"),
    ],
)
def test_a_set_that_could_mean_two_things_is_refused(text, sentence):
    with pytest.raises(ThrusterModelError) as error:
        parse_parameter_set(text, origin="mine.yaml")
    assert "mine.yaml: " in str(error.value) and sentence in str(error.value)


def test_a_set_in_another_encoding_is_refused_with_its_name(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_bytes("model: hl".encode("utf-16"))
    with pytest.raises(ThrusterModelError, match=r"mine.yaml: expected a YAML file in UTF-8"):
        load_parameter_set(file)
