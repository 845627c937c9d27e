"""Units are known however people spell factors and powers."""

import pytest

from run_bag.importers.conversions import CONVERSIONS, conversion, is_unit, spelled
from run_bag.unit_spelling import factors_of, same_unit


@pytest.mark.parametrize(
    "text", ["m/s2", "m/s^2", "m/s**2", "m/s²", "m s-2", "m s^-2", "m·s⁻²", "m/s/s", "M/S2", "m/sec^2"]
)
def test_all_spellings_of_a_unit_are_that_unit(text: str) -> None:
    assert spelled(text) == "m/s^2"
    assert is_unit(text)
    assert conversion(text, "m/s^2") == (1.0, 0.0)


@pytest.mark.parametrize(
    ("text", "ours"),
    [
        ("rad.s-1", "rad/s"), ("°/s", "deg/s"), ("degrees/s", "deg/s"), ("cm/s2", "cm/s^2"), ("N*m", "N m"),
        ("N·m", "N m"), ("kg cm", "kgf cm"), ("lb ft", "lbf ft"), ("min⁻¹", "rpm"), ("KG F", "kg f"), ("MN M", "mN m"),
    ],
)  # fmt: skip
def test_factors_are_known_by_their_usual_names(text: str, ours: str) -> None:
    assert spelled(text) == ours


def test_the_table_s_own_spellings_are_kept() -> None:
    for name in {*CONVERSIONS, *(other for table in CONVERSIONS.values() for other in table)}:
        assert spelled(name) == name
        assert factors_of(name) is not None


@pytest.mark.parametrize(
    "text", ["s1", "M1", "kg/m s", "data[0]", "m/", "(m", "m^123", "2", "a_b", "", "x" * 5000 + "^"]
)
def test_names_and_what_may_be_meant_either_way_are_no_units(text: str) -> None:
    assert factors_of(text) is None
    assert text == "" or not is_unit(text)


def test_a_quantity_is_not_another_one() -> None:
    assert same_unit("kg m^-3", "kg/m^3")
    assert same_unit("kg/m3", "kg/m^3")
    assert same_unit("1/N/m/s2", "1/(N m s^2)")
    assert not same_unit("kg/m2", "kg/m^3")
    assert not same_unit("mm", "m")
    assert not same_unit("", "1")
    assert not same_unit("M", "m"), "a set is read as it is written"


@pytest.mark.parametrize(
    ("unit", "ours", "factor"),
    [
        ("dbar", "m", 1.019716), ("mbar", "m", 0.01019716), ("kPa", "m", 0.1019716), ("ozf", "N", 0.27801385),
        ("oz in", "N m", 0.007061552), ("mG", "m/s^2", 9.80665e-3), ("mg", "m/s^2", 9.80665e-3),
    ],
)  # fmt: skip
def test_depths_as_pressures_of_fresh_water_ounces_and_thousandths_of_g_become_ours(
    unit: str, ours: str, factor: float
) -> None:
    found = conversion(unit, ours)
    assert found is not None
    assert found.factor == pytest.approx(factor, rel=1e-6)
    assert found.offset == 0.0
    assert conversion(unit, "m/s") is None
