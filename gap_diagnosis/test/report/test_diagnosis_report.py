"""The report of a diagnosis: its sections for every verdict, its numbers, and how it draws in a browser."""

import html
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from gap_diagnosis.blind_check.generator import Truth, generate
from gap_diagnosis.blind_check.signals import rich_campaign
from gap_diagnosis.diagnosis import Diagnosis, diagnose
from gap_diagnosis.diagnosis_json import as_json
from gap_diagnosis.preparing import recording_of
from gap_diagnosis.report import diagnosis_report
from gap_diagnosis.report.experiment import add_next_experiment
from gap_diagnosis.report.telling import telling_runs
from gap_diagnosis.report.unexplained import add_unexplained
from run_bag.report import Report
from run_bag.report.browser_check import check_report, missing_browser
from thruster_model.effects.stages import LIBRARY
from thruster_model.parameter_set_io import load_parameter_set, parse_parameter_set

SIGNALS = {"speed": "n", "ambient": "ambient", "thrust": "thrust", "torque": "torque"}
SUSPECTED = ("coulomb_friction", "thrust_loss", "brake_asymmetry")
ALWAYS = ["Verdict", "What would settle it", "Take it with you", "Provenance"]
ANALYSED = [
    "Verdict",
    "Where the gap goes",
    "Before and after",
    "How far",
    "Where",
    "Which",
    "What stays unexplained",
    "Re-tuned parameters",
    "What would settle it",
    "Take it with you",
    "Provenance",
]


def recorded(effects, signals=SIGNALS, duration=12.0, runs=("steps", "multisine")):
    parameters = dict(load_parameter_set("hl").values)
    campaign = rich_campaign(np.random.default_rng(4), duration=duration)
    truth = Truth(model="hl", parameters=parameters, effects=effects)
    generated = generate(truth, {name: campaign[name] for name in runs}, closed_loop=False, seed=5)
    recordings = []
    for run in generated:
        given = {signal: (run.recorded[name].time, run.recorded[name].values) for signal, name in signals.items()}
        throttle = run.recorded["throttle"]
        recordings.append(recording_of(run.name, (throttle.time, throttle.values), given))
    return recordings


def diagnosed(recordings):
    excluded = tuple(name for name in LIBRARY if name not in SUSPECTED)
    return diagnose(recordings, load_parameter_set("hl"), excluded=excluded)


def content_of(found, **more):
    runs = [r.name for r in found.problem.recordings] if found.problem else ["short"]
    return as_json(found, runs=runs, parameter_set="hl", version="0.0.0", seed=3, **more)


def with_verdict(found, verdict) -> Diagnosis:
    """Return the same investigation with another verdict, which claims nothing."""
    kept = {kind: rows for kind, rows in found.predictions.items() if kind != "with_effect"}
    errors = replace(
        found.errors,
        total=replace(found.errors.total, with_effect=None),
        channels={name: replace(each, with_effect=None) for name, each in found.errors.channels.items()},
    )
    other = replace(found.verdict, verdict=verdict, claims=(), chosen=None)
    return replace(found, verdict=other, shrinks=(), predictions=kept, errors=errors)


@pytest.fixture(scope="module")
def effect():
    return diagnosed(recorded({"coulomb_friction": {"deceleration": 150.0}}))


@pytest.fixture(scope="module")
def few_channels():
    return diagnosed(recorded({}, {"speed": "n"}, duration=8.0, runs=("steps",)))


@pytest.fixture(scope="module")
def not_enough():
    return diagnosed(recorded({}, duration=3.0, runs=("constant",)))


@pytest.fixture(scope="module")
def content(effect):
    return content_of(effect)


@pytest.fixture(scope="module")
def report(effect, content):
    return diagnosis_report(effect, content)


@pytest.fixture(scope="module")
def page(report):
    return page_of(report)


def page_of(report):
    """Return the page up to its scripts, without the data of the plots."""
    return re.sub(r'<script type="application/json">.*?</script>', "", report.html().partition("</main>")[0])


def sections(page):
    return [html.unescape(text) for text in re.findall(r"<h2 id=[^>]*>(.*?)</h2>", page)]


def cells(page):
    """Return the first cell of every table row and the others as text without signs."""
    found = {}
    for row in re.findall(r"<tr>(.*?)</tr>", page):
        texts = [re.sub(r"<[^>]*>", "", re.sub(r'<span class="(sign|spoken)".*?</span>', "", c)) for c in
                 re.findall(r"<t[hd][ >].*?</t[hd]>", row)]  # fmt: skip
        found.setdefault(html.unescape(texts[0]), [html.unescape(text) for text in texts[1:]])
    return found


def value(text):
    return float(text.replace("−", "-"))


def test_a_claimed_effect_has_all_sections_in_the_order_of_the_reader(effect, page):
    assert effect.verdict.verdict == "effect"
    assert sections(page) == ANALYSED


@pytest.mark.parametrize("verdict", ["no_gap", "parameters", "cannot_tell"])
def test_a_verdict_without_a_chosen_effect_has_the_same_sections(effect, verdict):
    other = with_verdict(effect, verdict)
    page = page_of(diagnosis_report(other, content_of(other)))
    assert sections(page) == ANALYSED
    assert "With effect" not in cells(page)["Channel"]


def test_not_enough_data_has_its_reasons_and_no_pictures(not_enough):
    content = content_of(not_enough)
    assert content["verdict"] == "not_enough_data"
    page = page_of(diagnosis_report(not_enough, content))
    titles = sections(page)
    assert titles[1:] == ALWAYS and "warning" in titles[0]
    assert all(html.escape(reason) in page for reason in not_enough.reasons)
    assert '<div class="plot"' not in page


def test_one_channel_of_one_run_is_enough_for_a_report(few_channels):
    page = page_of(diagnosis_report(few_channels, content_of(few_channels)))
    assert set(ANALYSED) <= set(sections(page))
    assert "Thrust" not in cells(page) and "Rotor speed" in cells(page)


def test_the_four_numbers_are_those_of_the_json(content, page):
    table = cells(page)
    errors = {"Total, noise-weighted": content["gap"]["total"]}
    titles = {"state.n": "Rotor speed", "flow.ambient": "Ambient flow", "load.wrench.force.x": "Thrust"}
    for channel, each in content["gap"]["channels"].items():
        errors[titles.get(channel.split("/")[1], "Torque")] = each
    assert len(errors) == 5
    for name, each in errors.items():
        shown = [value(text) for text in table[name][1:5]]
        expected = [each[kind] for kind in ("as_is", "retuned", "with_effect", "noise_floor")]
        assert shown == pytest.approx(expected, rel=6e-3), name


def test_probabilities_parameters_and_sizes_are_those_of_the_json(content, page):
    table = cells(page)
    likely = {each["id"]: each["probability"] for each in content["candidates"]}
    assert f"{likely['coulomb_friction']:.2f}" in table["Dry friction of the rotor"]
    for name, each in content["retuned_parameters"].items():
        assert value(table[name][0]) == pytest.approx(each["nominal"], rel=6e-4)
        assert value(table[name][2]) == pytest.approx(each["value"], rel=6e-4)
    size = content["effects"][0]["parameters"]["deceleration"]
    assert f"{size['value']:.4g} ± {size['std']:#.2g} rad/s²" in page


def test_what_a_candidate_explains_is_the_fall_of_its_whitened_residuals(effect, page):
    none, chosen = effect.investigation.none.fitted, effect.verdict.chosen.fitted
    rows = np.concatenate([np.r_[e.rows] for e in effect.problem.series if e.signal == "speed"])
    fall = np.sum(none.white[rows] ** 2) - np.sum(chosen.white[rows] ** 2)
    title = LIBRARY["coulomb_friction"].title
    explained = re.findall(rf'<th scope="row"[^>]*>{title}</th><td[^>]*>(−?\d+)</td>', page)
    assert [value(text) for text in explained] == [pytest.approx(fall, abs=0.6)]


def test_the_embedded_parameter_set_switches_the_effect_on(content, page):
    texts = [html.unescape(text) for text in re.findall(r"<pre[^>]*>(.*?)</pre>", page, re.DOTALL)]
    sizes = parse_parameter_set(texts[0], origin="report").effects.sizes
    assert sizes["coulomb_friction"]["deceleration"] == content["effects"][0]["parameters"]["deceleration"]["value"]
    assert json.loads(texts[1]) == content


PROGRAMME = {"time": [0.0, 1.0, 2.0], "throttle": [0.0, 2.0, 0.0]}
SEPARATES = [{"candidates": ["coulomb_friction", "none"], "distance": 7.26}]


@pytest.mark.parametrize(
    ("more", "rows"),
    [
        ({"file": "next.csv", "separates": SEPARATES, "programme": PROGRAMME}, [["7.3"]]),
        (
            {"file": "next.csv", "separates": [{**SEPARATES[0], "distance_now": 0.5}], "programme": None},
            [["7.3", "0.5"]],
        ),
        ({"file": None, "separates": [], "programme": None}, []),
    ],
)
def test_a_next_experiment_is_shown_with_what_it_has(content, more, rows):
    report = Report("A page")
    add_next_experiment(report, {**content, "next_experiment": {"sentence": "Play this next.", **more}})
    page = page_of(report)
    assert "Play this next." in page
    assert [row for key, row in cells(page).items() if "against" in key] == rows
    assert ('<div class="plot"' in page) == (more["programme"] is not None)


def test_the_telling_window_is_where_the_error_falls(effect):
    problem, noise = effect.problem, effect.investigation.noise
    wrong = problem.measured.copy()
    each = next(e for e in problem.series if e.recording == 1)
    time = problem.recordings[1].experiment.measurements[each.signal].time
    wrong[each.rows] += 10.0 * noise.level(each.signal) * ((time > 4.0) & (time < 6.0))
    first = telling_runs(problem, noise, wrong, problem.measured, window=3.0)[0]
    assert first.recording == 1 and first.start <= 4.0 and first.stop >= 6.0
    assert first.drop == pytest.approx(100.0 * np.sum((time > 4.0) & (time < 6.0)))


@pytest.mark.skipif(bool(missing_browser()), reason=missing_browser() or "browser present")
def test_every_plot_draws_without_error_request_or_sideways_scroll(report, tmp_path):
    findings = check_report(report.write(tmp_path / "effect.html"))
    assert findings.plots >= 8 and findings.ok, findings


def test_residuals_are_drawn_of_what_was_measured_though_a_push_on_something_else_shows(few_channels):
    features = [
        {"signal": "thrust", "depends_on": "a random push that grows with |n|", "gain": 30.0},
        {"signal": "speed", "depends_on": "|n| beyond 90 % of its largest", "gain": 20.0},
    ]
    report = Report("Report", "", {})
    add_unexplained(report, few_channels, {"unexplained": features})
    text = report.html()
    assert "residual of rotor speed" in text and "residual of thrust" not in text
