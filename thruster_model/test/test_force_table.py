"""A table of forces: hand values, its inverse, another implementation, and what it refuses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import RegularGridInterpolator

from thruster_model.errors import ForceTableError
from thruster_model.force_table import ForceTable
from thruster_model.force_table_quality import Drop, drops, left_out, monotone

COMMAND = [1100.0, 1300.0, 1460.0, 1500.0, 1540.0, 1700.0, 1900.0]
ROWS = {10.0: [-20.0, -6.0, 0.0, 0.0, 0.0, 8.0, 30.0], 20.0: [-40.0, -12.0, -2.0, 0.0, 0.0, 20.0, 50.0]}


def made(**changes):
    """A table of two voltages; changes replace what it is made of."""
    content = {
        "command": COMMAND,
        "command_unit": "µs",
        "stop": 1500.0,
        "supply": list(ROWS),
        "force": list(ROWS.values()),
        "source": "by hand",
    }
    return ForceTable(**{**content, **changes})


@st.composite
def tables(draw):
    """A table with random nodes whose force need not be monotone."""
    steps = st.floats(0.5, 50.0)
    above, below, voltages = (draw(st.lists(steps, min_size=n, max_size=6)) for n in (1, 1, 0))
    command = [*(-np.cumsum(below))[::-1], 0.0, *np.cumsum(above)]
    supply = np.cumsum([10.0, *voltages])
    size = st.one_of(st.just(0.0), st.floats(0.01, 100.0))
    force = []
    for _ in supply:
        reverse = [-draw(st.floats(0.01, 100.0)), *(-draw(size) for _ in below[1:])]
        force.append([*reverse, 0.0, *(draw(size) for _ in above[1:]), draw(st.floats(0.01, 100.0))])
    return ForceTable(command=command, command_unit="1", stop=0.0, supply=supply, force=force, source="drawn")


@pytest.mark.parametrize(
    ("command", "supply", "force"),
    [
        (1900.0, 10.0, 30.0),
        (1900.0, 15.0, 40.0),
        (1800.0, 10.0, 19.0),
        (1800.0, 12.5, 23.0),
        (1480.0, 20.0, -1.0),
        (1480.0, 15.0, -0.5),
        (1500.0, 13.7, 0.0),
        (1900.1, 10.0, np.nan),
        (1900.0, 20.1, np.nan),
        (1900.0, 9.9, np.nan),
        (np.nan, 10.0, np.nan),
        (1900.0, np.nan, np.nan),
        (np.inf, 10.0, np.nan),
    ],
)
def test_the_force_is_bilinear_and_nan_where_nobody_measured(command, supply, force):
    assert made().force_at(command, supply) == pytest.approx(force, rel=1e-12, nan_ok=True)


def test_clamped_the_nearest_measured_value_holds_and_nan_stays_nan():
    table = made()
    found = table.force_at([2500.0, 900.0, 1900.0, np.inf, np.nan], [10.0, 20.0, 99.0, 0.0, 10.0], outside="clamp")
    np.testing.assert_allclose(found, [30.0, -40.0, 50.0, 30.0, np.nan])
    with pytest.raises(ValueError, match="outside: expected 'nan' or 'clamp'; found 'hold'"):
        table.force_at(1500.0, 10.0, outside="hold")


def test_the_inverse_by_hand():
    table = made()
    assert table.command_for(4.0, 10.0) == pytest.approx(1620.0)
    assert table.command_for(-1.0, 20.0) == pytest.approx(1480.0)
    assert table.command_for(40.0, 15.0) == pytest.approx(1900.0)
    assert table.command_for(0.0, 15.0) == 1500.0
    assert np.isnan(table.command_for([30.1, -20.1, 1.0, 0.0, np.nan], [10.0, 10.0, 9.0, 9.0, 10.0])).all()
    clamped = table.command_for([99.0, -99.0, 8.0], [10.0, 20.0, 5.0], outside="clamp")
    np.testing.assert_allclose(clamped, [1900.0, 1100.0, 1700.0])


def test_of_two_commands_with_one_force_the_inverse_is_the_one_nearest_the_stop():
    dip = made(supply=[10.0], force=[[-20.0, -25.0, 0.0, 0.0, 10.0, 5.0, 30.0]])
    assert dip.command_for(8.0, 10.0) == pytest.approx(1532.0)
    assert dip.command_for(10.0, 10.0) == pytest.approx(1540.0)
    assert dip.command_for(11.0, 10.0) == pytest.approx(1748.0)
    assert dip.command_for(-99.0, 10.0, outside="clamp") == 1300.0
    assert dip.command_for(-22.0, 10.0) == pytest.approx(1460.0 - 160.0 * 22.0 / 25.0)


def test_a_thruster_of_one_direction_has_no_command_for_the_other():
    table = made(command=[1000.0, 1500.0, 2000.0], stop=1000.0, supply=[10.0], force=[[0.0, 0.0, 5.0]])
    assert np.isnan(table.command_for(-1.0, 10.0))
    assert table.command_for(-1.0, 10.0, outside="clamp") == 1000.0
    assert [float(end) for end in table.zero_band(10.0)] == [1000.0, 1500.0]


@settings(max_examples=150, deadline=None)
@given(tables(), st.floats(-1.0, 1.0), st.floats(0.0, 1.0))
def test_the_force_of_the_inverse_is_the_force_asked_for_and_no_command_nearer_gives_it(table, share, at):
    supply = np.clip(table.supply[0] + at * np.ptp(table.supply), table.supply[0], table.supply[-1])
    reverse, forward = table.largest_forces(supply)
    force = share * (forward if share > 0 else -reverse)
    command = table.command_for(force, supply)
    assert table.force_at(command, supply) == pytest.approx(force, rel=1e-7, abs=1e-9)
    nearer = command * np.linspace(0.0, 0.999, 200)
    assert np.all(np.abs(table.force_at(nearer, supply)) <= np.abs(force) + 1e-9)


@settings(max_examples=100, deadline=None)
@given(tables(), st.floats(0.0, 1.0))
def test_there_is_no_force_in_the_zero_band_and_some_beyond_it(table, at):
    supply = np.clip(table.supply[0] + at * np.ptp(table.supply), table.supply[0], table.supply[-1])
    low, high = table.zero_band(supply)
    assert np.all(table.force_at(np.linspace(low, high, 50), supply) == 0.0)
    for end, side in ((low, -1.0), (high, 1.0)):
        assert table.force_at(end + side * 0.25, supply) != 0.0


@settings(max_examples=50, deadline=None)
@given(tables(), st.integers(0, 2**32 - 1))
def test_scipy_interpolates_the_same(table, seed):
    if table.supply.size == 1:
        table = ForceTable(
            command=table.command, command_unit="1", stop=0.0, supply=[9.0, 11.0], source="twice",
            force=[table.force[0], 2 * table.force[0]],
        )  # fmt: skip
    rng = np.random.default_rng(seed)
    command = rng.uniform(table.command[0], table.command[-1], (7, 1))
    supply = rng.uniform(table.supply[0], table.supply[-1], 5)
    other = RegularGridInterpolator((table.supply, table.command), table.force)
    points = np.stack(np.broadcast_arrays(supply, command), axis=-1)
    np.testing.assert_allclose(table.force_at(command, supply), other(points), rtol=1e-9, atol=1e-9)


def test_a_batch_is_its_elements():
    table = made()
    force, supply = np.linspace(-45.0, 55.0, 21)[:, None], np.linspace(9.0, 21.0, 13)
    one = [[float(table.command_for(f, v)) for v in supply] for f in force[:, 0]]
    np.testing.assert_array_equal(table.command_for(force, supply), one)
    assert np.isnan(one).any()


def test_between_two_voltages_the_zero_band_is_what_both_have_in_common():
    low, high = made().zero_band([10.0, 10.001, 20.0, 21.0])
    np.testing.assert_array_equal(low, [1460.0, 1500.0, 1500.0, np.nan])
    np.testing.assert_array_equal(high, [1540.0, 1540.0, 1540.0, np.nan])


def test_the_table_of_one_voltage_is_the_table_at_that_voltage():
    table = made(speed=10.0 * np.array(list(ROWS.values())))
    one = table.at_supply(12.5)
    np.testing.assert_array_equal(one.force_at(COMMAND, 12.5), table.force_at(COMMAND, 12.5))
    assert one.value("speed", 1800.0, 12.5) == pytest.approx(230.0)
    assert np.isnan(one.force_at(1800.0, 12.6))
    assert table.at_supply(25.0, outside="clamp").force_at(1900.0, 25.0) == 50.0
    with pytest.raises(ForceTableError, match="supply: expected 10 to 20 V; found 25 V"):
        table.at_supply(25.0)
    with pytest.raises(ForceTableError, match="expected a table with 'power'; it holds force, speed"):
        table.value("power", 1500.0, 12.0)


def test_a_table_cannot_be_changed_from_outside():
    mine = np.array(list(ROWS.values()))
    table = made(force=mine)
    mine[:] = 0.0
    assert table.force_at(1900.0, 10.0) == 30.0
    with pytest.raises(ValueError, match="read-only"):
        table.force[0, 0] = 1.0


def test_dips_are_reported_and_removed_on_request():
    dip = made(supply=[10.0], force=[[-20.0, -25.0, 1.0, 0.0, 10.0, 6.0, 30.0]])
    assert drops(dip) == (
        Drop(10.0, 1100.0, 1300.0, -20.0, -25.0),
        Drop(10.0, 1460.0, 1500.0, 1.0, 0.0),
        Drop(10.0, 1540.0, 1700.0, 10.0, 6.0),
    )
    smooth = monotone(dip)
    np.testing.assert_allclose(smooth.force, [[-22.5, -22.5, 0.0, 0.0, 8.0, 8.0, 30.0]])
    assert drops(smooth) == ()
    assert drops(made()) == ()
    assert smooth.source == "by hand; made monotone by isotonic regression"


def test_the_error_at_a_voltage_left_out_is_that_of_its_neighbours():
    middle = 0.5 * np.sum(list(ROWS.values()), axis=0)
    middle[-1] -= 3.5
    rows = [*ROWS.values()]
    (found,) = left_out(made(supply=[10.0, 15.0, 20.0], force=[rows[0], middle, rows[1]]))
    assert found == pytest.approx((15.0, 3.5 / np.sqrt(7.0), 3.5, 1900.0))
    assert left_out(made()) == ()


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"command": [1100.0]}, r"command: expected at least 2 numbers in one row; found shape \(1,\)"),
        ({"command": COMMAND[::-1]}, "command: expected ascending numbers; found 1700 after 1900"),
        ({"supply": [10.0, np.inf]}, "supply: expected finite numbers; found inf"),
        ({"supply": [0.0, 10.0]}, "supply: expected voltages above 0 V; found 0 V"),
        ({"force": [[1.0, 2.0]]}, r"force: expected shape \(2, 7\), supply by command; found \(1, 2\)"),
        ({"force": [[1.0], [1.0, 2.0]]}, "force: expected numbers in rows of one length; found list"),
        ({"force": None}, "force: expected shape"),
        ({"power": np.full((2, 7), np.nan)}, "power: expected finite numbers; found nan at 10 V, 1100 µs"),
        ({"stop": 1510.0}, "stop: expected one of the commands; found 1510 µs, which is none of them"),
        ({"stop": 1300.0}, "force: expected 0 N at the stop; found -6 N at 10 V, 1300 µs"),
        ({"force": [[-v for v in row] for row in ROWS.values()]}, "a positive force at 10 V, 1900 µs; found -30 N"),
        ({"source": ""}, "source: expected a text; found none"),
    ],
)
def test_what_cannot_be_a_table_is_refused_with_a_sentence(changes, sentence):
    with pytest.raises(ForceTableError, match=sentence):
        made(**changes, origin="mine")


def test_all_that_is_wrong_is_said_at_once():
    with pytest.raises(ForceTableError) as caught:
        made(command=COMMAND[::-1], supply=[20.0, 10.0], source="")
    assert [problem.split(":")[0] for problem in caught.value.problems] == ["source", "command", "supply"]
