"""Tables: aligned numbers, units, marks that do not rest on colour."""

import numpy as np
import pytest

from run_bag.report import Cell, Column, Report, ReportError
from run_bag.report.numbers import column_decimals, format_number


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (11.618, "11.62"),
        (-0.36, "−0.3600"),
        (9400, "9400"),
        (np.int64(-3), "−3"),
        (np.float32(0.5), "0.5000"),
        (1.13e-11, "1.130×10⁻¹¹"),
        (-2.5e9, "−2.500×10⁹"),
        (123456.0, "123456"),
        (0.0, "0.000"),
        (float("nan"), "–"),
        (None, "–"),
        (float("-inf"), "−∞"),
    ],
)
def test_a_number_is_written_with_four_significant_digits(value: object, text: str) -> None:
    assert format_number(value) == text


def test_a_column_of_one_quantity_gets_one_number_of_decimals() -> None:
    assert column_decimals([4.21, 0.842, 12.0, float("nan"), None, "x"], 3) == 1
    assert column_decimals([1e-11, 5.0], 3) is None


def page(columns, rows) -> str:  # type: ignore[no-untyped-def]
    report = Report("T")
    report.table(columns, rows, caption="c")
    return report.html()


def test_units_stand_in_the_heading_and_headings_are_scoped() -> None:
    html = page([Column(name="run"), Column(name="thrust", unit="N")], [["a", 1.25], ["b", 12.5]])
    assert '<th scope="col" class="number">thrust <span class="unit">[N]</span></th>' in html
    assert '<th scope="row">a</th><td class="number">1.25</td>' in html
    assert '<td class="number">12.50</td>' in html


def test_columns_with_a_gap_stay_numbers_and_say_what_is_missing() -> None:
    html = page(["run", "x"], [["a", None], ["b", 2.0]])
    assert '<td class="number"><span title="not available">–</span></td>' in html


def test_marks_are_spoken_and_explained() -> None:
    html = page(["run", "x"], [["a", Cell(1.0, "best")], ["b", Cell(2.0, "worse")]])
    assert '<span class="spoken"> (best)</span>' in html
    assert "✓ best · ▲ worse" in html


def test_rows_that_do_not_match_the_columns_are_all_named() -> None:
    with pytest.raises(ReportError, match=r"expected 2 cells.*row 0 has 1; row 2 has 3"):
        page(["a", "b"], [[1], [1, 2], [1, 2, 3]])
