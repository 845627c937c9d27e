"""A whole report in a real browser."""

from pathlib import Path

import pytest

from run_bag.report.browser_check import LAPTOP, PHONE, check_report, missing_browser, open_report
from run_bag.report.example import example_report

pytestmark = pytest.mark.skipif(bool(missing_browser()), reason=missing_browser() or "browser present")


def test_every_plot_draws_without_error_request_or_sideways_scroll_on_laptop_and_phone(
    tmp_path: Path,
) -> None:
    findings = check_report(example_report().write(tmp_path / "example.html"))
    assert findings.plots == 8
    assert findings.ok, findings


def test_the_check_finds_what_is_wrong_with_a_page(tmp_path: Path) -> None:
    page = example_report().html()
    broken = page.replace(
        "</main>",
        '<div style="width:900px">wide</div><img src="http://127.0.0.1:9/x.png" alt="">'
        '<div class="plot" id="empty" data-height="9">'
        '<script type="application/json">{"data": [], "layout": {}}'
        "</script></div><script>missing();</script></main>",
    )
    (tmp_path / "broken.html").write_text(broken, encoding="utf-8")
    findings = check_report(tmp_path / "broken.html")
    assert findings.undrawn == ("empty",)
    assert [width for width, _ in findings.overflow] == [390]
    assert any("missing is not defined" in error for error in findings.errors)
    assert any("Content Security Policy" in error for error in findings.errors)


def test_a_finger_on_a_plot_scrolls_the_page(tmp_path: Path) -> None:
    path = example_report().write(tmp_path / "example.html")
    with open_report(path, *PHONE) as driver:
        driver.execute_script("document.getElementById('plot-2-1').scrollIntoView({block: 'center'});")
        before = driver.execute_script("return scrollY;")
        touches = [("touchStart", 420), *(("touchMove", y) for y in range(420, 120, -20)), ("touchEnd", None)]
        for kind, y in touches:
            points = [] if y is None else [{"x": 200, "y": y}]
            driver.execute_cdp_cmd("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        assert driver.execute_script("return scrollY;") > before + 150


def test_the_legend_hides_a_series_in_every_plot_of_its_figure(tmp_path: Path) -> None:
    path = example_report().write(tmp_path / "example.html")
    count = "return document.querySelectorAll('#figure-2 .js-line').length;"
    with open_report(path, *LAPTOP) as driver:
        before = driver.execute_script(count)
        driver.execute_script("document.querySelector('#figure-2 .key[data-group=\"as published\"]').click();")
        assert driver.execute_script(count) == before - 2


def test_the_path_in_space_can_be_turned_by_mouse_and_is_passed_over_by_a_finger(tmp_path: Path) -> None:
    path = example_report().write(tmp_path / "example.html")
    find = "return [...document.querySelectorAll('.plot')].find((box) => box.querySelector('.gl-container canvas'))"
    for size, mode in ((LAPTOP, "turntable"), (PHONE, False)):
        with open_report(path, *size) as driver:
            assert driver.execute_script(f"{find}._fullLayout.scene.dragmode;") == mode
