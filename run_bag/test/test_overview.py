"""One page that links what programs have left in a folder."""

import re
from html import unescape
from urllib.parse import unquote

import pytest
from foreign_recordings import table

from run_bag.cli_overview import main
from run_bag.cli_show import main as show
from run_bag.importers.cli_recording import main as import_recording
from run_bag.report import Report


def page(path, title, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    report = Report(title)
    report.section("Verdict")
    report.key_values({"answer": text, "what to do": "Nothing."})
    report.paragraph("Details.")
    report.write(path)


@pytest.fixture
def results(tmp_path):
    """A run with its drawing, a fit, two diagnoses, a page of somebody else's, and what a program was killed in."""
    folder = tmp_path / "mine"
    folder.mkdir()
    (tmp_path / "map.yaml").write_text(
        "time: {column: 1, unit: ms}\nthruster_0/state.n: {column: rpm, unit: rpm}\n"
        "thruster_0/throttle.commanded: {column: 2, unit: us, stop: 1500, per_volt: 80, hold: previous}\n"
    )
    file = table(tmp_path / "x.csv")
    assert import_recording([str(file), "--map", str(tmp_path / "map.yaml"), "--out", str(folder / "log")]) == 0
    assert show([str(folder / "log")]) == 0
    page(folder / "fit/report.html", "Fit of hl", "hl is good: 1.2 times the noise.")
    (folder / "fit/hl.yaml").write_text("model: hl")
    page(folder / "a <b>: c/report.html", "Diagnosis <1>", 'A delay & a "gap".')
    page(folder / "before/report.html", "Diagnosis 2", "No gap.")
    (folder / "before/diagnosis.json").write_text("{}")
    (folder / "note.html").write_text("<title>Of somebody else</title>")
    (folder / ".hidden").mkdir()
    page(folder / ".hidden/report.html", "Hidden", "Not whole.")
    return folder


def told(path):
    """Return links (target, label), and the page's text."""
    html = path.read_text("utf-8")
    found = re.findall(r'<a href="(\./[^"]*)">(.*?)</a>', html)
    return {unquote(unescape(target)): unescape(label) for target, label in found}, html


def test_a_folders_page_says_what_each_report_found_and_every_link_leads_there(results, capsys):
    capsys.readouterr()
    assert main([str(results)]) == 0
    out = results / "overview.html"
    assert capsys.readouterr().out.strip() == str(out)
    links, html = told(out)
    assert links == {
        "./log.html": "Run log", "./fit/report.html": "Fit of hl", "./fit/hl.yaml": "hl.yaml",
        "./a <b>: c/report.html": "Diagnosis <1>", "./before/report.html": "Diagnosis 2",
        "./before/diagnosis.json": "diagnosis.json",
    }  # fmt: skip
    assert all((results / target).is_file() for target in links)
    assert "hl is good: 1.2 times the noise." in html
    assert "A delay &amp; a &quot;gap&quot;." in html
    assert "4 reports, 1 run" in html
    assert "recording, imported" in html, "what the run says of itself"
    assert str(results) not in html, "no folder of the machine's"


def test_a_runs_page_links_what_lies_beside_it_under_its_name(results):
    page(results / "log_scores/report.html", "Scores of log", "Well followed.")
    page(results / "other_scores/report.html", "Scores of other", "Badly.")
    assert main([str(results / "log")]) == 0
    links, html = told(results / "log_overview.html")
    assert links == {"./log.html": "Run log", "./log_scores/report.html": "Scores of log"}
    assert "Well followed." in html


def test_several_places_make_one_page_with_links_from_where_it_lies(results, tmp_path):
    (tmp_path / "pages").mkdir()
    out = tmp_path / "pages/all.html"
    given = [str(results / "fit"), str(results / "before/report.html"), "--out", str(out), "--title", "All of it"]
    assert main(given) == 0
    links, html = told(out)
    assert {"./../mine/fit/report.html", "./../mine/before/report.html"} <= set(links)
    assert "<h1>All of it</h1>" in html


def test_a_run_that_cannot_be_read_is_said_and_the_others_are_listed(results):
    (results / "cut").mkdir()
    (results / "cut/cut.mcap").write_bytes(b"no bag")
    assert main([str(results)]) == 0
    html = told(results / "overview.html")[1]
    assert "cut: cannot be read" in html
    assert "Fit of hl" in html


def test_what_cannot_be_is_a_sentence_and_nothing_is_written(results, tmp_path, capsys):
    (tmp_path / "empty").mkdir()
    (results / "overview.html").write_text("mine")
    for given, status, sentence in [
        ([results], 1, "overview.html exists; nothing is overwritten: say another --out"),
        ([tmp_path / "nothing"], 1, "found nothing there"),
        ([tmp_path / "empty"], 1, "expected a run, a report or a folder of them, found neither; `fit`, `diagnose`"),
        ([results / "note.html"], 1, "found neither"),
        ([results, results / "fit"], 2, "expected --out FILE.html, as there are 2 paths"),
        ([results / "fit", "--out", tmp_path / "no/x.html"], 1, "expected an existing folder"),
    ]:
        capsys.readouterr()
        assert main([str(each) for each in given]) == status
        assert sentence in capsys.readouterr().err
    assert (results / "overview.html").read_text() == "mine"
    assert not (results / "fit/overview.html").exists() and not (tmp_path / "empty/overview.html").exists()
