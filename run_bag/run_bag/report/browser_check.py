"""Look at a report in a headless Chromium: does it draw, does it fit, does it stay quiet. For tests."""

import base64
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .errors import BrowserMissing

LAPTOP = (1366, 768)
PHONE = (390, 844)
_FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
)
_UNDRAWN = """
const marks = [".scatterlayer path.js-line", ".scatterlayer path.point", ".barlayer path",
  ".heatmaplayer image", ".contourlayer path", ".pielayer path", ".violinlayer path",
  ".boxlayer path", ".gl-container canvas"].join(",");
return [...document.querySelectorAll(".plot")]
  .filter((box) => box.dataset.drawn !== "yes" || !box.querySelector(marks))
  .map((box) => box.id);
"""
_OVERFLOW = "return Math.max(document.scrollingElement.scrollWidth, window.innerWidth) - arguments[0];"
_REQUESTS = """return performance.getEntriesByType("resource").map((entry) => entry.name)
  .filter((name) => !/^(data|blob):/.test(name));"""


@dataclass(frozen=True, kw_only=True)
class BrowserFindings:
    """What a browser said about a report.

    Args:
        plots: number of plots in the page.
        undrawn: identifiers of plots without a single line, point, bar or image, at any width.
        errors: script errors and console messages of level SEVERE.
        overflow: (width, excess) in CSS pixels, for each width at which the page scrolls sideways.
        requests: addresses that the page tried to load.
    """

    plots: int
    undrawn: tuple[str, ...]
    errors: tuple[str, ...]
    overflow: tuple[tuple[int, int], ...]
    requests: tuple[str, ...]

    @property
    def ok(self) -> bool:
        """Tell whether there is nothing to complain about."""
        return not (self.undrawn or self.errors or self.overflow or self.requests)


def missing_browser() -> str:
    """Return a sentence that names what is missing to look at reports, or nothing when all is there."""
    missing = [] if _chromium() else ["chromium"]
    missing += [] if shutil.which("chromedriver") else ["chromedriver"]
    try:
        import selenium  # noqa: F401
    except ImportError:
        missing.append("the Python package selenium")
    return f"cannot look at reports in a browser: {', '.join(missing)} not installed" if missing else ""


def check_report(path: str | Path, sizes: Sequence[tuple[int, int]] = (LAPTOP, PHONE)) -> BrowserFindings:
    """Open a report at each size, draw all its plots and collect what is wrong.

    Args:
        path: the HTML file.
        sizes: (width, height) of the window in CSS pixels.

    Raises:
        BrowserMissing: when chromium, chromedriver or selenium is not installed.
    """
    undrawn: dict[str, None] = {}
    errors: dict[str, None] = {}
    requests: dict[str, None] = {}
    overflow, plots = [], 0
    with _browser() as driver:
        for width, height in sizes:
            _load(driver, Path(path), width, height)
            plots = int(driver.execute_script('return document.querySelectorAll(".plot").length;'))
            undrawn |= dict.fromkeys(driver.execute_script(_UNDRAWN))
            requests |= dict.fromkeys(driver.execute_script(_REQUESTS))
            errors |= dict.fromkeys(driver.execute_script("return window.reportErrors;"))
            errors |= dict.fromkeys(str(e["message"]) for e in driver.get_log("browser") if e["level"] == "SEVERE")
            excess = int(driver.execute_script(_OVERFLOW, width))
            if excess > 0:
                overflow.append((width, excess))
    return BrowserFindings(
        plots=plots,
        undrawn=tuple(undrawn),
        errors=tuple(errors),
        overflow=tuple(overflow),
        requests=tuple(requests),
    )


def screenshot(
    path: str | Path,
    png: str | Path,
    width: int = 1366,
    height: int = 768,
    full_page: bool = True,
    *,
    dark: bool = False,
    scroll_to: str = "",
) -> None:
    """Save a picture of a report with all plots drawn.

    Args:
        path: the HTML file.
        png: where the picture goes.
        width: of the window in CSS pixels.
        height: of the window in CSS pixels.
        full_page: the whole page instead of one window.
        dark: ask for the dark colour scheme.
        scroll_to: identifier of the element to show first, such as "figure-2".
    """
    with open_report(path, width, height, dark=dark) as driver:
        if scroll_to:
            driver.execute_script("document.getElementById(arguments[0]).scrollIntoView();", scroll_to)
            driver.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]));")
        shot = driver.execute_cdp_cmd("Page.captureScreenshot", {"captureBeyondViewport": full_page})
        Path(png).write_bytes(base64.b64decode(shot["data"]))


@contextmanager
def open_report(path: str | Path, width: int, height: int, *, dark: bool = False) -> Iterator[Any]:
    """Open a report with all plots drawn and hand over selenium's driver, for checks of a single page."""
    with _browser() as driver:
        _load(driver, Path(path), width, height, dark=dark)
        yield driver


def _load(driver: Any, path: Path, width: int, height: int, *, dark: bool = False) -> None:
    """Load the page at a size and wait until every plot is drawn."""
    driver.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 700},
    )
    driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": width < 700})
    driver.execute_cdp_cmd(
        "Emulation.setEmulatedMedia",
        {"features": [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]},
    )
    driver.get(path.resolve().as_uri())
    driver.execute_async_script("""
      const done = arguments[0];
      const settle = () => requestAnimationFrame(() => requestAnimationFrame(() => done(true)));
      const start = () => window.reportReady
        ? window.reportDrawAll().then(settle, settle) : setTimeout(start, 20);
      if (window.reportDrawAll) start(); else done(false);""")


@contextmanager
def _browser() -> Iterator[Any]:
    """Start a browser with an empty profile and end it afterwards."""
    missing = missing_browser()
    if missing:
        raise BrowserMissing(missing)
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    with tempfile.TemporaryDirectory(prefix="report_check_", ignore_cleanup_errors=True) as profile:
        options = webdriver.ChromeOptions()
        options.binary_location = _chromium() or ""
        for flag in (*_FLAGS, f"--user-data-dir={profile}"):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        driver = webdriver.Chrome(options=options, service=Service(executable_path=shutil.which("chromedriver")))
        try:
            driver.set_script_timeout(120)
            driver.set_page_load_timeout(120)
            yield driver
        finally:
            driver.quit()


def _chromium() -> str | None:
    return next(
        (found for name in ("chromium", "chromium-browser", "google-chrome") if (found := shutil.which(name))),
        None,
    )
