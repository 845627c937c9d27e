"""The page: self-contained, escaped, warnings first, headings in order, never overwritten unasked."""

import base64
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from run_bag.report import Axis, Report, ReportError, ReportExists, Series, curves
from run_bag.report.figure import script_safe

NASTY = '</script><img src="http://evil.example/x.png" onerror="alert(1)"><b>&amp;'
X, Y = Axis(name="time", unit="s"), Axis(name="thrust", unit="N")


class Elements(HTMLParser):
    """Every element with its attributes, and the text outside scripts and styles."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self._silent = False
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))
        self._silent = tag in ("script", "style")

    def handle_endtag(self, tag: str) -> None:
        self._silent = False

    def handle_data(self, data: str) -> None:
        self.text += "" if self._silent else data


def full_report(word: str) -> Report:
    report = Report(word, word, {word: [word, {word: word}]})
    report.section(word)
    report.subsection(word)
    report.paragraph(word)
    report.key_values({word: word})
    report.table([word, "b"], [[word, 1.0]], caption=word, notes=[word])
    report.figure(curves([Series(name=word, x=[0, 1], y=[1, 2])], x=X, y=Y), caption=word, alt=word)
    report.download(word, "a.yaml", word)
    report.warning(word)
    return report


def test_nothing_is_fetched_from_anywhere() -> None:
    elements = Elements(full_report("plain").html()).found
    for tag, attributes in elements:
        for name in ("src", "href", "srcset", "action", "data", "poster"):
            assert re.match(r"data:|#|$", attributes.get(name) or ""), (tag, attributes)
        assert tag not in ("iframe", "object", "embed", "base")
    policies = [a["content"] for t, a in elements if a.get("http-equiv") == "Content-Security-Policy"]
    assert policies and (policies[0] or "").startswith("default-src 'none'")


def test_plotly_is_embedded_once_and_only_when_there_is_a_plot() -> None:
    report = full_report("plain")
    for _ in range(3):
        report.figure(curves([Series(name="a", x=[0, 1], y=[1, 2])], x=X, y=Y), caption="c", alt="a")
    assert re.findall(r"\* plotly\.js \((\w+) - minified\) v", report.html()) == ["cartesian"]
    assert report.html().count('class="library"') == 1
    without = Report("No plots").html()
    assert "minified" not in without and 'class="library"' not in without
    assert len(without) < 40_000


def test_no_text_can_become_markup() -> None:
    plain, nasty = Elements(full_report("plain").html()), Elements(full_report(NASTY).html())
    assert [tag for tag, _ in nasty.found] == [tag for tag, _ in plain.found]
    assert nasty.text.count(NASTY) == plain.text.count("plain")


def test_embedded_data_cannot_end_their_script() -> None:
    assert script_safe('{"name": "</script><!--"}') == '{"name": "\\u003c/script>\\u003c!--"}'


def test_warnings_are_counted_and_stand_before_all_content() -> None:
    report = Report("Title")
    report.section("First section")
    report.warning("one")
    report.paragraph("text")
    report.warning("two")
    text = Elements(report.html()).text
    main = text[text.index("Plots need JavaScript.") :]
    assert main.index("2 warnings") < main.index("one") < main.index("two") < main.index("First section")


def test_more_than_three_warnings_are_folded_and_none_is_lost() -> None:
    report = Report("Title")
    for word in ("one", "two", "three", "four", "five"):
        report.warning(word)
    page = report.html()
    shown, folded = page[page.index('<section class="warnings"') : page.index("</section>")].split("<details>")
    assert ["5 warnings" in shown, "three" in shown, "four" in shown] == [True, True, False]
    assert "<summary>2 more</summary><ul><li>four</li><li>five</li></ul></details>" in folded


def test_a_report_without_warnings_says_so() -> None:
    assert "No warnings." in Elements(Report("Title").html()).text


def test_headings_are_in_order_and_their_anchors_unique() -> None:
    report = Report("Title", provenance={"version": "1"})
    for _ in range(3):
        report.section("Same")
        report.subsection("Same")
    elements = Elements(report.html()).found
    levels = [int(tag[1]) for tag, _ in elements if re.fullmatch(r"h[1-6]", tag)]
    assert levels == [1, 2, 3, 2, 3, 2, 3, 2]
    identifiers = [a["id"] for _, a in elements if "id" in a]
    assert len(set(identifiers)) == len(identifiers)
    targets = {(a["href"] or "")[1:] for t, a in elements if t == "a" and (a["href"] or "").startswith("#")}
    assert targets <= set(identifiers)


def test_a_downloaded_text_is_the_text_that_was_given() -> None:
    text = "k_n: 11.62  # 1/s, ± 0.11\n</script>\n"
    report = Report("Title")
    report.download("Parameters", "set.yaml", text)
    links = [a for t, a in Elements(report.html()).found if t == "a" and "download" in a]
    assert [a["download"] for a in links] == ["set.yaml"]
    assert base64.b64decode((links[0]["href"] or "").partition(",")[2]).decode() == text


def test_an_existing_file_is_kept_unless_replacing_is_asked_for(tmp_path: Path) -> None:
    target = tmp_path / "report.html"
    target.write_text("precious")
    with pytest.raises(ReportExists, match=r"expected no file there, found one; pass replace=True"):
        Report("Title").write(target)
    assert target.read_text() == "precious"
    Report("Title").write(target, replace=True)
    assert "<h1>Title</h1>" in target.read_text(encoding="utf-8")
    assert list(tmp_path.iterdir()) == [target]


def test_the_same_content_gives_the_same_bytes() -> None:
    assert full_report("a").html() == full_report("a").html()


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Report(" "), "expected a title"),
        (lambda: Report("T").subsection("s"), "expected a section before it"),
        (lambda: Report("T").download("d", "../x", ""), "expected a plain file name"),
        (lambda: Report("T").figure([], caption="c", alt="a"), "expected plots, a caption"),
        (
            lambda: Report("T").figure(curves([Series(name="a", x=[0], y=[0])], x=X, y=Y), caption="c", alt=""),
            "alternative text",
        ),
    ],
)
def test_what_would_make_a_poor_report_is_refused(build, message: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ReportError, match=message):
        build()
