"""The command line from runs to results: files, report, and a sentence instead of a traceback."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from run_bag import write_run
from run_bag.report.browser_check import check_report, missing_browser
from thruster_model import cli_fit
from thruster_model.identification.fit_report import quality
from thruster_model.parameter_set_io import load_parameter_set


def sweep(amplitude, slow):
    """A second and a half of rest, then a throttle through the dead zone in both directions [V]."""
    return lambda t: (t > 1.5) * amplitude * np.sin(slow * (t - 1.5)) * np.cos(0.23 * (t - 1.5))


@pytest.fixture(scope="module")
def recordings(recorded_run, tmp_path_factory):
    """Three short runs of a thruster whose input gains are 8 % above the published ones."""
    published = load_parameter_set("hl")
    gains = {name: 1.08 * published.values[name] for name in ("c_u1", "c_u2")}
    truth = published.with_values(gains, source="truth").values
    rng = np.random.default_rng(1)
    folder = tmp_path_factory.mktemp("runs")
    return [
        str(recorded_run(folder / "axial", sweep(2.8, 1.1), 8.0, truth, rng, flow="axial")),
        str(recorded_run(folder / "ambient", sweep(-2.5, 1.9), 8.0, truth, rng, flow="ambient")),
        str(recorded_run(folder / "other", sweep(2.2, 1.5), 8.0, truth, rng, flow="axial")),
    ]


@pytest.fixture(scope="module")
def runs(recordings):
    """The two that are fitted."""
    return recordings[:2]


@pytest.fixture(scope="module")
def outcome(runs, recordings, tmp_path_factory):
    """Exit status and folder of a fit of two models, with a third run to predict only."""
    out = tmp_path_factory.mktemp("fit") / "out"
    status = cli_fit.main([*runs, "--model", "simplified", "hl", "--out", str(out), "--validate", recordings[2]])
    return status, out


def test_what_a_damaged_run_lost_is_said_on_the_screen_too(runs, tmp_path, capsys):
    (data,) = Path(runs[0]).glob("*.mcap")
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(data.read_bytes()[: 2 * data.stat().st_size // 3])
    cli_fit.main([str(cut), runs[1], "--model", "simplified", "--out", str(tmp_path / "out")])
    assert "warning: cut: cut.mcap: cut off inside the record" in capsys.readouterr().err


def test_all_results_are_there_and_nothing_else(outcome):
    status, out = outcome
    assert status == 0
    assert sorted(p.name for p in out.iterdir()) == ["fit.json", "hl.yaml", "report.html", "simplified.yaml"]


def test_the_page_begins_with_a_verdict_in_words_of_its_own_numbers(outcome):
    page = (outcome[1] / "report.html").read_text("utf-8").partition("</main>")[0]
    models = json.loads((outcome[1] / "fit.json").read_text())["models"]
    verdict = page[page.index(">Verdict</h2>") : page.index(">Data against fits</h2>")]
    for model, name in zip(models, ("simplified", "HL"), strict=True):
        error = next(c["error"] for c in model["errors"] if c["signal"] == "total")
        assert f"{name}, fitted, describes these runs {quality(error)}: {error:.2g} times their noise" in verdict
    assert "hl.yaml" in verdict


@pytest.mark.parametrize(
    ("error", "words"),
    [(1.0, "to within their noise"), (1.5, "fairly"), (2.99, "fairly"), (3.0, "poorly"), (np.nan, "not at all")],
)
def test_a_fit_is_called_poor_from_three_times_the_noise(error, words):
    assert quality(error) == words


def test_the_fitted_set_finds_the_gains(outcome):
    _, out = outcome
    fitted, published = load_parameter_set(str(out / "hl.yaml")), load_parameter_set("hl")
    for name in ("c_u1", "c_u2"):
        ratio = fitted.values[name] / fitted.values["k_n"] * published.values["k_n"] / published.values[name]
        assert ratio == pytest.approx(1.08, abs=0.03), name
    assert fitted.source == "fitted to axial, ambient"


def test_the_summary_says_what_was_fitted_to_what_and_how_well(outcome):
    _, out = outcome
    summary = json.loads((out / "fit.json").read_text("utf-8"))
    provenance = summary["provenance"]
    assert provenance["runs"] == ["axial", "ambient"]
    assert provenance["runs predicted only"] == ["other"]
    assert provenance["method"] == "least-squares"
    assert set(provenance["start"]) == {"simplified", "hl"}
    simplified, hl = summary["models"]
    assert (simplified["model"], hl["model"]) == ("simplified", "hl")
    assert [e["signal"] for e in simplified["errors"]] == ["speed", "thrust", "torque", "total"]
    assert [e["signal"] for e in hl["errors"]] == ["speed", "axial", "ambient", "thrust", "torque", "total"]
    assert hl["units"] == {"speed": "rad/s", "axial": "m/s", "ambient": "m/s", "thrust": "N", "torque": "N m"}
    total = hl["errors"][-1]
    assert total["error"] == pytest.approx(1.0, abs=0.15)
    assert total["reference"] > 3.0 * total["error"]
    assert hl["errors_other_runs"][-1]["error"] == pytest.approx(1.0, abs=0.2)
    assert hl["errors_left_out"] is None
    assert hl["noise"]["thrust"] == pytest.approx(0.1, rel=0.3)
    names = [d["name"] for d in hl["parameters"]]
    assert set(names) == set(load_parameter_set("hl").values) - {"u_dot_max"}
    assert all(d["status"] and d["sentence"] for d in hl["parameters"])


def test_the_report_opens_in_a_browser_without_errors_and_with_all_plots_drawn(outcome):
    if missing_browser():
        pytest.skip(missing_browser())
    findings = check_report(outcome[1] / "report.html")
    assert findings.errors == ()
    assert findings.undrawn == ()
    assert findings.requests == ()
    assert findings.overflow == ()
    assert findings.plots >= 10


def test_the_lines_on_the_terminal_say_how_well_and_where(runs, tmp_path, capsys):
    words = [runs[0], "--model", "simplified", "--stages", "thesis", "--out", str(tmp_path / "out")]
    assert cli_fit.main(words) == 0
    written = capsys.readouterr()
    first, last = written.out.splitlines()
    assert first.startswith("simplified: noise-weighted error ")
    told = written.err.splitlines()
    assert len(told) >= 2 and any("simplified" in line for line in told), "what it is at, also where nobody sees a bar"
    assert last == str(tmp_path / "out" / "report.html")


def test_a_fit_that_determines_nothing_is_written_and_ends_with_1(runs, tmp_path, capsys, monkeypatch):
    def open_everywhere(study):
        models = [
            replace(m, result=replace(m.result, determinations=tuple(
                replace(d, status="flat") for d in m.result.determinations
            )))
            for m in study.models
        ]  # fmt: skip
        return replace(study, models=tuple(models))

    found = cli_fit.run_study
    monkeypatch.setattr(cli_fit, "run_study", lambda *given, **named: open_everywhere(found(*given, **named)))
    words = [runs[0], "--model", "simplified", "--stages", "thesis", "--out", str(tmp_path / "out")]
    assert cli_fit.main(words) == 1
    assert "fit: expected runs that determine a parameter; these determine none" in capsys.readouterr().err
    assert (tmp_path / "out/report.html").is_file()


@pytest.mark.parametrize("words", [["runs/log", "--vehicle", "ngs", "--out", "fit"], ["--help"]])
def test_who_fits_a_vehicle_is_told_by_what(capsys, words):
    with pytest.raises(SystemExit):
        cli_fit.main(words)
    assert "thruster fit --vehicle SET ..., or ros2 run gap_diagnosis fit_vehicle" in " ".join(
        "".join(capsys.readouterr()).split()
    )


def refused(words, capsys, sentence):
    """Exit status 1, the sentence on stderr, nothing else and no traceback."""
    assert cli_fit.main([str(word) for word in words]) == 1
    written = capsys.readouterr()
    assert sentence in written.err
    assert "Traceback" not in written.err
    assert written.out == ""


def test_a_folder_with_files_in_it_is_not_written_to(runs, tmp_path, capsys):
    (tmp_path / "notes.txt").write_text("mine")
    sentence = f"{tmp_path}: expected a new or empty folder; found files in it"
    refused([*runs, "--out", tmp_path], capsys, sentence)
    assert [p.name for p in tmp_path.iterdir()] == ["notes.txt"]


def test_a_start_of_another_model_is_refused(runs, tmp_path, capsys):
    sentence = "--start hq: expected a set of model 'hl'; found 'hq'"
    refused([*runs, "--start", "hq", "--out", tmp_path / "out"], capsys, sentence)
    assert not (tmp_path / "out").exists()


def test_a_start_that_does_not_exist_is_refused_with_what_is_known(runs, tmp_path, capsys):
    refused(
        [*runs, "--start", "none", "--out", tmp_path / "out"],
        capsys,
        "hl, hl_bench, hq, hq_bench, kim_chung",
    )


def test_runs_that_cannot_be_read_are_all_named(runs, tmp_path, capsys):
    (tmp_path / "text.mcap").write_text("no recording")
    words = [tmp_path / "absent", runs[0], tmp_path / "text.mcap", "--out", tmp_path / "out"]
    refused(words, capsys, f"{tmp_path / 'absent'}: no such file or directory\n{tmp_path / 'text.mcap'}")
    assert not (tmp_path / "out").exists()


def test_a_run_for_validation_that_cannot_be_read_is_named(runs, tmp_path, capsys):
    words = [*runs, "--validate", tmp_path / "absent", "--out", tmp_path / "out"]
    refused(words, capsys, f"{tmp_path / 'absent'}: no such file or directory")


def test_a_run_without_excitation_is_refused(bench_topic, tmp_path, capsys):
    time = np.arange(0.0, 4.0, 0.01)
    noise = np.random.default_rng(1).standard_normal(time.size)
    topics = [
        bench_topic("thruster_0/throttle", "Throttle", time, {"commanded": np.zeros(time.size)}),
        bench_topic("thruster_0/state", "ThrusterState", time, {"n": noise}),
    ]
    still = write_run(tmp_path / "still", topics)
    refused([still, "--out", tmp_path / "out"], capsys, "the throttle is zero throughout all runs")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["run"], "the following arguments are required: --out"),
        (["run", "--out", "x", "--model", "cubic"], "invalid choice: 'cubic'"),
        (["--out", "x"], "the following arguments are required: RUN"),
    ],
)
def test_wrong_words_are_refused_with_the_usage(words, sentence, capsys):
    with pytest.raises(SystemExit) as stop:
        cli_fit.main(words)
    assert stop.value.code == 2
    assert sentence in capsys.readouterr().err


def test_a_run_that_the_model_predicts_nothing_of_is_refused_as_validation(runs, bench_topic, tmp_path, capsys):
    time = np.arange(0.0, 4.0, 0.04)
    noise = 0.005 * np.random.default_rng(1).standard_normal(time.size)
    topics = [
        bench_topic("thruster_0/throttle", "Throttle", time, {"commanded": np.where(time > 2.0, 1.0, 0.0)}),
        bench_topic("thruster_0/flow", "FlowVelocity", time, {"axial": noise}),
    ]
    flow = write_run(tmp_path / "flow", topics)
    words = [
        runs[0],
        "--model",
        "simplified",
        "--stages",
        "thesis",
        "--validate",
        flow,
        "--out",
        tmp_path / "out",
    ]
    refused(words, capsys, "flow: nothing to predict: expected one of speed, thrust, torque; found axial")


def test_a_run_given_twice_or_to_be_fitted_and_predicted_is_refused(runs, tmp_path, capsys):
    refused([*runs, runs[0], "--out", tmp_path / "out"], capsys, "given twice; the same data would count twice")
    both = [*runs, "--validate", runs[1], "--out", tmp_path / "out"]
    refused(both, capsys, "to be fitted and to be predicted only; expected one of the two")


@pytest.mark.parametrize("after", [0.5, 1.1, 1.9, 2.6])
def test_an_interrupted_fit_says_so_in_one_sentence_and_leaves_nothing(after, runs, tmp_path):
    """Interrupted at any time: raised where a kernel's result becomes a named tuple it would bring the process down."""
    code = f"""
import os, signal, threading
from thruster_model import cli_fit
from thruster_model.identification.fit_report import quality
import sys
from dataclasses import replace
sys.argv = ["fit", *{runs!r}, "--model", "hq", "airfoil", "table", "--hold-out", "--out", {str(tmp_path / "out")!r}]
threading.Timer({after}, os.kill, (os.getpid(), signal.SIGINT)).start()
sys.exit(cli_fit.main())
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 130
    assert done.stderr.splitlines()[-1] == "interrupted: nothing was written"  # what it was at stands before
    assert done.stderr.count("interrupted") == 1 and "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []
