"""Makers' files, our own file and the command line."""

import csv
import warnings

import numpy as np
import openpyxl
import pytest
import yaml

from run_bag.report.browser_check import check_report, missing_browser
from thruster_model import cli_force_table
from thruster_model.errors import ForceTableError
from thruster_model.force_table_io import dump_force_table, load_force_table, parse_force_table
from thruster_model.force_table_map_io import read_column_map
from thruster_model.force_table_sheets_io import read_force_table

HEADINGS = (" PWM", "RPM", "U (V)", "kgf ")
MAP = {
    "name": "test",
    "source": "made up",
    "sheets": "[0-9]+ V",
    "command": {"column": "PWM", "unit": "µs", "stop": 1500},
    "supply": {"column": "U (V)", "unit": "V"},
    "force": {"column": "kgf", "unit": "N", "scale": 9.80665, "zero_up_to": 0.2},
    "speed": {"column": "RPM", "unit": "rad/s", "scale": 0.104719755, "signed": False},
}
BY_SHEET = {"sheet": "([0-9.]+) V", "unit": "V"}


def rows(volts):
    """The rows of one voltage, force in kgf, with 0.01 kgf of a scale's noise at rest."""
    return [
        (1100, 100 * volts, volts, -0.01 * volts**2),
        (1400, 0, volts, -0.01),
        (1500, 0, volts, 0.01),
        (1900, 120 * volts, volts, 0.02 * volts**2),
    ]


def spreadsheet(path, sheets):
    """Write an xlsx with an empty sheet first, and return its path."""
    book = openpyxl.Workbook()
    book.active.title = "READ ME"
    for name, cells in sheets.items():
        sheet = book.create_sheet(name)
        for row in cells:
            sheet.append(row)
    book.save(path)
    return path


def written(folder, **changes):
    """Write the map with changes (None removes a key), and return its path."""
    content = {k: v for k, v in {**MAP, **changes}.items() if v is not None}
    path = folder / "map.yaml"
    path.write_text(yaml.safe_dump(content, allow_unicode=True), "utf-8")
    return path


@pytest.fixture
def maker(tmp_path):
    """An xlsx of three voltages."""
    sheets = {f"{v} V": [HEADINGS, *rows(v)] for v in (10, 12, 16)}
    return spreadsheet(tmp_path / "maker.xlsx", sheets)


@pytest.mark.parametrize("supply", [MAP["supply"], BY_SHEET])
def test_a_spreadsheet_is_read_in_si_units_wherever_it_states_its_supply(maker, tmp_path, supply):
    table = read_force_table(maker, read_column_map(written(tmp_path, supply=supply)))
    assert table.supply.tolist() == [10.0, 12.0, 16.0]
    assert table.command.tolist() == [1100.0, 1400.0, 1500.0, 1900.0]
    np.testing.assert_allclose(table.force[0], [-9.80665, 0.0, 0.0, 19.6133])
    np.testing.assert_allclose(table.speed[0], 0.104719755 * np.array([-1000.0, 0.0, 0.0, 1200.0]))
    assert (table.name, table.source, table.command_unit) == ("test", "made up; maker.xlsx", "µs")
    assert table.quantities == ("force", "speed")


def test_a_csv_of_all_voltages_in_any_order_is_the_same_table(maker, tmp_path):
    path = tmp_path / "all.csv"
    with path.open("w", newline="", encoding="utf-8-sig") as file:
        csv.writer(file).writerows([HEADINGS, *rows(16), [], *rows(10)[::-1], *rows(12)])
    columns = read_column_map(written(tmp_path))
    one, other = read_force_table(path, columns), read_force_table(maker, columns)
    for name in ("command", "supply", "force", "speed"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-14)  # xlsx: 16 digits


def test_our_file_gives_the_same_numbers_back(maker, tmp_path):
    table = read_force_table(maker, read_column_map(written(tmp_path)))
    again = parse_force_table(dump_force_table(table), origin="again")
    for name in ("command", "supply", "force", "speed"):
        np.testing.assert_array_equal(getattr(again, name), getattr(table, name))
    for name in ("name", "source", "command_unit", "stop", "quantities"):
        assert getattr(again, name) == getattr(table, name)


@pytest.mark.parametrize(
    ("sheets", "sentences"),
    [
        ({"10 V": [HEADINGS]}, ["sheet '10 V': expected a line of headings and rows of numbers; found 1 rows"]),
        ({"ten": [HEADINGS]}, ["expected sheets named as '[0-9]+ V'; found 'READ ME', 'ten'"]),
        (
            {"10 V": [("PWM", "rpm", "U (V)", "kgf"), *rows(10)]},
            ["sheet '10 V', row 1: expected a column 'RPM' (speed); found 'PWM', 'rpm', 'U (V)', 'kgf'"],
        ),
        ({"10 V": [(*HEADINGS, "RPM"), *rows(10)]}, ["'kgf', 'RPM' (more than once)"]),
        (
            {"10 V": [HEADINGS, (1100, "n/a", 10, None), *rows(10)[1:], (1950, True, 10, 3.0)]},
            [
                "sheet '10 V', row 2: expected a number in 'kgf'; found nothing",
                "sheet '10 V', row 2: expected a number in 'RPM'; found 'n/a'",
                "sheet '10 V', row 6: expected a number in 'RPM'; found True",
            ],
        ),
        (
            {"10 V": [HEADINGS, *rows(10), rows(10)[0]]},
            ["row 6: expected each command once at a voltage; found 10 V, 1100 µs also in sheet '10 V', row 2"],
        ),
        (
            {"10 V": [HEADINGS, *rows(10)], "12 V": [HEADINGS, *rows(12)[1:]]},
            ["at 12 V: expected the 4 commands of the other voltages; 1 are missing, first 1100 µs"],
        ),
        ({"10 V": [HEADINGS, *((1600 + i, "x", 10, 1) for i in range(50))]}, ["row 21", "and 30 more"]),
        ({"10 V": [HEADINGS, *rows(10)[:2], *rows(10)[3:]]}, ["stop: expected one of the commands; found 1500 µs"]),
    ],
)
def test_a_wrong_spreadsheet_is_refused_with_sheet_and_row(tmp_path, sheets, sentences):
    path = spreadsheet(tmp_path / "maker.xlsx", sheets)
    with pytest.raises(ForceTableError) as caught:
        read_force_table(path, read_column_map(written(tmp_path)))
    for sentence in sentences:
        assert sentence in str(caught.value)
    assert all(line.startswith(f"{path}: ") for line in str(caught.value).splitlines())


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("a.ods", b"", "expected a .csv or .xlsx file; found '.ods'"),
        ("a.xlsx", b"no archive", "expected an xlsx file; found File is not a zip file"),
        ("a.csv", "PWM (µs)".encode("latin-1"), "expected a csv file in UTF-8; found"),
        ("a.csv", b"", "sheet 'a': expected a line of headings"),
    ],
)
def test_what_is_no_table_at_all_is_refused(tmp_path, name, content, sentence):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(ForceTableError) as caught:
        read_force_table(path, read_column_map(written(tmp_path)))
    assert sentence in str(caught.value)


def test_a_spreadsheet_cut_short_is_refused(maker, tmp_path):
    maker.write_bytes(maker.read_bytes()[:-200])
    with pytest.raises(ForceTableError, match="expected an xlsx file; found"):
        read_force_table(maker, read_column_map(written(tmp_path)))


def test_a_sheet_without_a_voltage_in_its_name_is_refused(tmp_path):
    path = spreadsheet(tmp_path / "maker.xlsx", {"ten": [HEADINGS, *rows(10)]})
    with pytest.raises(ForceTableError, match="sheet 'ten': expected the voltage in its name"):
        read_force_table(path, read_column_map(written(tmp_path, supply=BY_SHEET, sheets="ten")))


def test_a_name_of_a_sheet_or_file_that_is_longer_than_any_is_refused(maker, tmp_path):
    columns = read_column_map(written(tmp_path, supply=BY_SHEET))
    text = ",".join(HEADINGS) + "\n" + "".join(",".join(map(str, row)) + "\n" for row in rows(12))
    for length, refused in [(100, False), (101, True)]:
        path = tmp_path / f"{'x' * (length - 4)}12 V.csv"
        path.write_text(text, "utf-8")
        if not refused:
            assert read_force_table(path, columns).supply.tolist() == [12.0]
            continue
        with pytest.raises(ForceTableError, match="expected a name of at most 100 characters; found 101"):
            read_force_table(path, columns)
        assert read_force_table(path, read_column_map(written(tmp_path))).supply.tolist() == [12.0]
    book = openpyxl.load_workbook(maker)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that other programs may not read it
        book["10 V"].title = "1" * 40 + " V"
        book.save(maker)
    with pytest.raises(ForceTableError, match="expected a name of at most 31 characters; found 42"):
        read_force_table(maker, columns)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"force": None}, "key 'force': missing"),
        ({"thrust": {}}, "key 'thrust': unknown; known are name, source"),
        ({"name": 3}, "key 'name': expected a text; found 3"),
        ({"sheets": "["}, "key 'sheets': expected a regular expression; found '['"),
        ({"sheets": "([0-9]+)+ V"}, "found '([0-9]+)+ V': it repeats so much that a name may take minutes"),
        ({"supply": {"sheet": "([0-9]*)*V", "unit": "V"}}, "key 'supply.sheet': expected a regular expression; found"),
        ({"power": "P"}, "key 'power': expected column and unit; found 'P'"),
        ({"power": {"column": "P", "unit": "W", "signed": False}}, "key 'power.signed': unknown"),
        ({"power": {"unit": "W"}}, "key 'power': expected column; found none"),
        ({"power": {"column": 5, "unit": "W"}}, "key 'power.column': expected a text; found 5"),
        ({"power": {"column": "P", "unit": "kW"}}, "key 'power.unit': expected 'W', with a scale that brings there"),
        ({"power": {"column": "P", "unit": "W", "scale": 0}}, "key 'power.scale': expected a number other than 0"),
        ({"power": {"column": "P", "unit": "W", "scale": "k"}}, "key 'power.scale': expected a number; found 'k'"),
        ({"supply": {**BY_SHEET, "column": "U"}}, "key 'supply': expected column or sheet; found column and sheet"),
        ({"supply": {"sheet": "V", "unit": "V"}}, "with the voltage in brackets, such as '([0-9.]+) V'; found 'V'"),
        ({"command": {"column": "PWM", "unit": "µs"}}, "key 'command.stop': expected a number; found none"),
        ({"command": {"column": "PWM", "stop": 1500}}, "key 'command.unit': expected a unit; found None"),
        ({"force": {"column": "F", "unit": "N", "zero_up_to": -1}}, "key 'force.zero_up_to': expected a number >= 0"),
        ({"speed": {"column": "n", "unit": "rad/s", "signed": "no"}}, "key 'speed.signed': expected true or false"),
    ],
)
def test_a_wrong_map_is_refused_with_its_key(tmp_path, changes, sentence):
    path = written(tmp_path, **changes)
    with pytest.raises(ForceTableError) as caught:
        read_column_map(path)
    assert f"{path}: " in str(caught.value)
    assert sentence in str(caught.value)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("[1]", "expected a mapping at the top; found list"),
        ("a: [", "line 1: expected YAML; found"),
        ("force: 3", "key 'force': expected unit, value; found int"),
        ("force: {unit: kgf, value: []}", "key 'force.unit': expected 'N'; found 'kgf'"),
        ("command: {unit: 1, value: [], stop: x}", "key 'command.stop': expected a number; found 'x'"),
        ("thrust: 3", "key 'thrust': unknown; known are name"),
    ],
)
def test_a_wrong_file_of_ours_is_refused(text, sentence):
    with pytest.raises(ForceTableError) as caught:
        parse_force_table(text, origin="mine")
    assert f"mine: {sentence}" in str(caught.value)


def test_the_command_line_writes_table_and_report_and_says_what_the_table_is(maker, tmp_path, capsys):
    out = tmp_path / "table.yaml"
    words = [str(maker), "--map", str(written(tmp_path)), "--out", str(out), "--report"]
    assert cli_force_table.main(words) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "test: 3 supply voltages, 4 commands, force, speed"
    assert lines[1] == "10 V: no force from 1400 to 1500 µs; largest +19.6 / -9.8 N"
    assert lines[4] == "12 V left out and interpolated: RMSE 0.88 N, largest error +1.57 N at 1900 µs"
    assert lines[-2:] == [str(out), str(tmp_path / "table.html")]
    assert load_force_table(out).supply.tolist() == [10.0, 12.0, 16.0]
    assert cli_force_table.main(words) == 1
    assert f"{out}: exists and is not overwritten" in capsys.readouterr().err
    if missing_browser():
        pytest.skip(missing_browser())
    findings = check_report(tmp_path / "table.html")
    assert (findings.errors, findings.undrawn, findings.requests, findings.overflow) == ((), (), (), ())
    assert findings.plots == 2


def test_the_command_line_writes_nothing_of_a_wrong_file(maker, tmp_path, capsys):
    words = ["--map", str(written(tmp_path, power={"column": "P", "unit": "W"})), "--out", str(tmp_path / "t.yaml")]
    assert cli_force_table.main([str(maker), *words]) == 1
    assert "row 1: expected a column 'P' (power)" in capsys.readouterr().err
    assert not (tmp_path / "t.yaml").exists()
