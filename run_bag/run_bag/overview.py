"""One page for a run or a folder of results: what each page in it says, with a link, and the runs that are there.

A report of ours is known by its generator; its title and what it says are in its head. Nothing else is asked of it, so
that every program's pages are found: fits, diagnoses, scores, replays, studies, drawn runs.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html.parser import HTMLParser
from pathlib import Path

from .errors import NotARunError, RunError
from .reader import read_recording
from .report import Column, Link, Report
from .report.page import GENERATOR

DEPTH = 6
"""Folders in folders that are looked through."""
HEAD = 1 << 16
"""Bytes of a page within which its head says what it is."""
BESIDE = (".yaml", ".json", ".md", ".csv")
RUN_FILES = (".mcap", ".db3")


@dataclass(frozen=True, kw_only=True)
class Page:
    """A report that was found: its file, its title, and what it says."""

    path: Path
    title: str
    text: str


class _Head(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.title, self.meta, self._in_title = "", {"generator": "", "description": ""}, False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self._in_title = tag == "title"
        if tag == "meta" and given.get("name") in self.meta:
            self.meta[str(given["name"])] = given.get("content") or ""

    def handle_data(self, data: str) -> None:
        self.title += data if self._in_title else ""

    def handle_endtag(self, tag: str) -> None:
        self._in_title = False


def page_at(path: Path) -> Page | None:
    """Return a page of ours, None where the file is none or cannot be read."""
    head = _Head()
    try:
        with path.open("rb") as file:
            head.feed(file.read(HEAD).decode("utf-8", "replace"))
    except OSError:
        return None
    if head.meta["generator"] != GENERATOR:
        return None
    return Page(path=path, title=head.title.strip() or path.name, text=head.meta["description"])


def is_run(path: Path) -> bool:
    """Tell whether a path is a run: a file of a bag, or a folder that has one."""
    if path.is_dir():
        return any(child.suffix in RUN_FILES for child in path.iterdir())
    return path.suffix in (*RUN_FILES, ".bag")


def contents(path: Path) -> tuple[list[Page], list[Path]]:
    """Return the pages and the runs at a path: of a run, itself and the pages beside it that have its name."""
    if is_run(path):
        name = path.name.removesuffix(".mcap")
        beside = [p for p in sorted(path.parent.iterdir()) if p.name == f"{name}.html" or p.name.startswith(f"{name}_")]
        pages = [page for p in beside for file in ([p] if p.is_file() else sorted(p.glob("*.html")))
                 if (page := page_at(file)) is not None]  # fmt: skip
        return pages, [path]
    if not path.is_dir():
        page = page_at(path)
        return ([] if page is None else [page]), []
    pages, runs = [], []
    for folder in _folders(path, DEPTH):
        if is_run(folder):
            runs.append(folder)
        else:
            pages += [page for file in sorted(folder.glob("*.html")) if (page := page_at(file)) is not None]
    return pages, runs


def _folders(path: Path, depth: int) -> Iterator[Path]:
    yield path
    if depth and not is_run(path):
        for child in sorted(path.iterdir()):
            if child.is_dir() and not child.is_symlink() and not child.name.startswith("."):
                yield from _folders(child, depth - 1)


def overview(paths: Sequence[Path], out: Path, title: str = "") -> Report:
    """Return the page that links what is at some paths; links lead from where `out` will be.

    Raises:
        RunError: there is nothing at a path, or neither a page nor a run.
    """
    pages: dict[Path, Page] = {}
    runs: dict[Path, None] = {}
    for path in paths:
        if not path.exists():
            raise NotARunError(f"{path}: expected a run, a report or a folder of them, found nothing there", path=path)
        found, there = contents(path.absolute())
        if not found and not there:
            text = f"{path}: expected a run, a report or a folder of them, found neither"
            raise RunError(f"{text}; `fit`, `diagnose` and `show` make reports", path=path)
        pages |= {page.path: page for page in found if page.path != out.absolute()}
        runs |= dict.fromkeys(there)
    report = Report(title or f"Overview of {', '.join(path.absolute().name for path in paths)}", _counted(pages, runs))
    if pages:
        report.section("Reports")
        report.links([_link(page, out) for page in pages.values()])
    if runs:
        report.section("Runs")
        rows = [_row(run, out, report) for run in runs]
        columns: list[Column | str] = ["run", Column(name="length", unit="s"), "messages", "what was run"]
        report.table(columns, rows, caption="Recordings, as `ros2 bag info` and `thruster show` take them.")
    return report


def _counted(pages: dict[Path, Page], runs: dict[Path, None]) -> str:
    return f"{len(pages)} report{'s' * (len(pages) != 1)}, {len(runs)} run{'s' * (len(runs) != 1)}"


def _relative(path: Path, out: Path) -> str:
    return Path(os.path.relpath(path, out.absolute().parent)).as_posix()


def _link(page: Page, out: Path) -> Link:
    beside = [_relative(file, out) for file in sorted(page.path.parent.iterdir()) if file.suffix in BESIDE]
    # a folder of many pages belongs to none of them
    alone = sum(1 for _ in page.path.parent.glob("*.html")) == 1
    return Link(label=page.title, path=_relative(page.path, out), text=page.text, beside=beside if alone else ())


def _row(run: Path, out: Path, report: Report) -> list[object]:
    name = _relative(run, out)
    try:
        recording = read_recording(run, set())
    except RunError as error:
        report.warning(f"{name}: cannot be read: {str(error).replace(str(run), run.name)}")
        return [name, None, None, "cannot be read"]
    what = {key: value for key, value in recording.metadata.items() if isinstance(value, str | int | float)}
    told = "; ".join(f"{key} {value}" for key, value in list(what.items())[:6]) or json.dumps(
        sorted(recording.metadata)
    )
    first = [s.first_log_time for s in recording.scans if s.first_log_time is not None]
    last = [s.last_log_time for s in recording.scans if s.last_log_time is not None]
    length = (max(last) - min(first)) * 1e-9 if first and last else None
    return [name, length, sum(s.message_count for s in recording.scans), told[:200]]
