"""The one reader of YAML: core schema of YAML 1.2, and a sentence for whatever is meant ill."""

import math
import time

import pytest

from safe_files.errors import YamlError
from safe_files.yaml_io import YamlLimits, parse_yaml, read_yaml


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("017", 17), ("0o17", 15), ("0x1F", 31), ("-3", -3), ("1:30", "1:30"), ("1_000", "1_000"), ("1e-3", 1e-3),
        ("5.", 5.0), (".5", 0.5), ("-.inf", -math.inf), ("yes", "yes"), ("TRUE", True), ("~", None), ("", None),
        ("2024-01-01", "2024-01-01"), ('"1"', "1"), ("'true'", "true"), ("<<", "<<"),
    ],
)  # fmt: skip
def test_scalars_mean_what_the_core_schema_of_yaml_1_2_says(text, value):
    found = parse_yaml(f"a: {text}", "x.yaml")["a"]
    assert found == value and type(found) is type(value)


def test_collections_nest_and_anchors_without_use_do_no_harm():
    assert parse_yaml("a: &x [1, {b: [2]}]\nc:\n- d: 3\n  e:\n- 4\n", "x") == {
        "a": [1, {"b": [2]}],
        "c": [{"d": 3, "e": None}, 4],
    }
    assert math.isnan(parse_yaml(".nan", "x")) and parse_yaml("# nothing", "x") is None


BOMB = "a: &a [x, x]\n" + "".join(f"{b}: &{b} [*{a}, *{a}]\n" for a, b in zip("abcdefgh", "bcdefghi", strict=True))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (BOMB, "x.yaml, line 2: expected the value itself, found the alias *a"),
        ("a: &a {b: *a}", "line 1: expected the value itself, found the alias *a"),
        ("a: 1\nb: 2\na: 3", "line 3: expected each key once, found 'a' again"),
        ("b: {c: 1, c: 2}", "line 1: expected each key once, found 'c' again"),
        ("a: !!python/object:os.system x", "line 1: expected no tag, found tag:yaml.org,2002:python/object:os.system"),
        ("a: 1\n---\nb: 1", "expected one document, found a second one"),
        ("[" * 100_000, "expected at most 32 levels, found more"),
        ("- " * 100_000, "expected at most 32 levels, found more"),
        ("{" * 100_000, "expected a text or number as a key, found a collection"),
        ("a: " + "1" * 400, "expected a whole number below 2^63, found 1111"),
        ("a: " + "1" * 5000, "expected a number of at most 400 digits, found 5000"),
        ("a: 1e999", "expected a number that a computer has, found 1e999"),
        (
            "x: 1\na: {column: U1 [V], unit: V}",
            "line 2: expected YAML; found what is none: expected ',' or '}', but got '['",
        ),
        ("a: {column: U1 [V], unit: V}", "; text with brackets, braces, commas, colons or % goes in quotes: 'U1 [V]'"),
        ("a: {column: imu: x, unit: V}", "goes in quotes: 'U1 [V]'"),
        ("a: {column: %, unit: V}", "goes in quotes: 'U1 [V]'"),
        ("a: [1, 2", "line 1: expected YAML; found what is none"),
        ("a:\tb", "expected YAML; found what is none"),
        ('a: "\\', "expected YAML; found what is none"),
        ("a: \x00", "expected YAML; found what is none"),
        ("%YAML 9.9\n---\na: 1", "expected YAML; found what is none"),
        ("? [a]\n: 1", "expected a text or number as a key"),
    ],
    ids=str,
)
def test_what_could_mean_two_things_or_grow_is_refused_with_its_line(text, sentence):
    begin = time.perf_counter()
    with pytest.raises(YamlError) as error:
        parse_yaml(text, "x.yaml")
    assert sentence in str(error.value)
    assert time.perf_counter() - begin < 10.0


def test_files_are_bounded_in_bytes_values_and_depth(tmp_path):
    file = tmp_path / "x.yaml"
    file.write_text("a: [1, 2, 3]")
    for limits, what in (
        (YamlLimits(size=5), "at most 5 bytes"),
        (YamlLimits(nodes=3), "at most 3 values"),
        (YamlLimits(depth=1), "at most 1 levels"),
    ):
        with pytest.raises(YamlError, match=what):
            read_yaml(file, limits)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (None, "x.yaml: expected a YAML file; cannot be read: No such file"),
        (b"a: 1\nb: \xff\xfe", "x.yaml, line 2: expected UTF-8, found the byte 0xff"),
        ("a: 1".encode("utf-16"), "x.yaml, line 1: expected UTF-8, found the byte 0xff"),
    ],
)
def test_a_file_that_cannot_be_read_is_named(tmp_path, content, sentence):
    file = tmp_path / "x.yaml"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(YamlError) as error:
        read_yaml(file)
    assert sentence in str(error.value)
