"""House words in reports: explained once a page, in running text alone, and never as markup."""

import re

import pytest

from run_bag.report import Report
from run_bag.report.glossary import WORDS, explained


def dfns(html: str) -> list[str]:
    return re.findall(r"<dfn[^>]*>([^<]*)</dfn>", html)


def test_a_word_is_explained_where_it_first_stands_on_the_page() -> None:
    report = Report("Free runs", "")
    report.section("What free runs say")
    report.paragraph("Errors of free runs, re-tuned.\n\nA free run <b> of runs left out.")
    report.paragraph("re-tuned, with an innovation.")
    page = report.html()
    assert dfns(page) == ["free runs", "re-tuned", "left out", "innovation"]
    assert f'data-told="{WORDS["free run"]}">free runs</dfn>' in page
    assert "&lt;b&gt;" in page and "<b>" not in page.partition("<main")[2]


@pytest.mark.parametrize(
    ("text", "found"),
    [("carefree runs, administration, NISI", []), ("free-run errors; NIS.", ["free-run", "NIS"]), ("", []),
     ("held out & left out", ["held out", "left out"])],
)  # fmt: skip
def test_only_whole_words_are_found(text: str, found: list[str]) -> None:
    html = explained(text, set())
    assert sorted(dfns(html)) == sorted(found)
    assert re.sub(r"<[^>]*>", "", html) == text.replace("&", "&amp;")


def test_what_was_told_is_not_told_again() -> None:
    told = {"free run"}
    assert dfns(explained("a free run, re-tuned", told)) == ["re-tuned"] and told == {"free run", "re-tuned"}
