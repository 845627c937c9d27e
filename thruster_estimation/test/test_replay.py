"""Recorded runs through observers: which sample belongs to which step, scores, files, and errors as sentences."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from thruster_truth import BENCH_HL, DT, HL, Array, truth

from run_bag import Topic, read_run, write_run
from run_bag.importers.bench import find, import_recording
from run_bag.importers.options import BenchOptions
from thruster_estimation.belief import initial_belief
from thruster_estimation.cli_replay import main
from thruster_estimation.errors import EstimationError
from thruster_estimation.offline import observe
from thruster_estimation.replay import Job, replay
from thruster_estimation.replay_io import read_signals, signals_of
from thruster_estimation.settings import BENCH, bench_settings

COUNT = 150
THROTTLES = 2.5 * np.sin(0.08 * np.arange(COUNT) + 0.4)


@pytest.fixture(scope="module")
def states() -> Array:
    return truth(THROTTLES, (0.0, 0.0, 0.0), HL)


def topic(name: str, kind: str, stamps: Array, **fields: Array) -> Topic:
    ticks = np.round(1e9 * (1.0 + stamps)).astype(np.int64)
    return Topic(name=f"thruster_0/{name}", type=f"thruster_msgs/{kind}", stamps=ticks, fields=fields)


@pytest.fixture(scope="module")
def run(states: Array, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Throttle k acts from k DT on; the state at (k + 1) DT is measured there, signed, without noise."""
    folder = tmp_path_factory.mktemp("runs") / "made"
    when, measured = DT * np.arange(COUNT), DT * (1 + np.arange(COUNT))
    one = np.ones(COUNT, dtype=np.uint8)
    write_run(folder, [
        topic("throttle", "Throttle", when, commanded=THROTTLES),
        topic("state", "ThrusterState", measured, n=states[:, 0], sign_source=one),
        topic("flow", "FlowVelocity", measured - 0.01, ambient=states[:, 2], axial=states[:, 1]),
        topic("truth", "ThrusterTruth", measured, n=states[:, 0], axial=states[:, 1], ambient=states[:, 2]),
    ])  # fmt: skip
    return folder


def test_a_run_without_noise_replays_to_the_truth_so_throttle_and_samples_fit_together(run: Path) -> None:
    (signals,) = read_signals([run])
    assert not signals.unsigned and signals.time.size == COUNT and np.allclose(signals.dt[1:], DT)
    np.testing.assert_allclose(signals.u_before[1:], THROTTLES[1:], atol=1e-9)
    np.testing.assert_allclose(signals.u_after[:-1], THROTTLES[1:], atol=1e-9)
    outcome = replay(signals, Job("ekf", "hl", bench_settings("ekf"), HL))
    scores = {(s.against, s.state): s for s in outcome.scores}
    assert set(scores) == {
        ("measured, one step ahead", "n"), ("measured, one step ahead", "U"), ("measured", "v"),
        ("truth", "n"), ("truth", "v"), ("truth", "U"),
    }  # fmt: skip
    # one period of misalignment of the throttle would leave more than 2 rad/s
    assert scores["measured, one step ahead", "n"].rmse < 0.3 and scores["truth", "v"].rmse < 0.02
    assert outcome.nis is not None and outcome.nis < 0.1 and outcome.gated_n == 0.0 and outcome.valid == 1.0


def test_the_throttle_that_acted_is_its_mean_over_the_period(run: Path) -> None:
    loaded = read_run(run)
    fast = DT / 4 * np.arange(4 * COUNT)
    values = np.repeat(THROTTLES, 4) + np.tile([0.1, -0.1, 0.3, -0.3], COUNT)
    ticks = np.round(1e9 * (1.0 + fast)).astype(np.int64)
    name = "thruster_0/throttle.commanded"
    channel = type(loaded[name])(name=name, stamps=ticks, values=values, unit="V")
    signals = signals_of(replace(loaded, channels={**loaded.channels, name: channel}))
    np.testing.assert_allclose(signals.u_before[1:], THROTTLES[1:], atol=1e-6)


def test_a_fast_tachometer_is_thinned_and_a_spike_or_a_missing_flow_is_not_measured(tmp_path: Path) -> None:
    when = 0.001 * np.arange(1000)
    slow = 0.1 * np.arange(10)
    write_run(tmp_path / "fast", [
        topic("throttle", "Throttle", when, commanded=np.full(1000, 2.0)),
        topic("state", "ThrusterState", when, n=np.full(1000, -50.0)),
        topic("flow", "FlowVelocity", slow, ambient=np.where(slow == 0.3, np.nan, 0.05), axial=np.full(10, np.nan),
              spike=(np.arange(10) == 5)),
    ])  # fmt: skip
    (signals,) = read_signals([tmp_path / "fast"])
    assert np.allclose(np.diff(signals.time), 0.04) and signals.unsigned and np.all(signals.y_n == 50.0)
    seen = np.flatnonzero(np.isfinite(signals.y_U))
    assert 8 <= seen.size <= 9 and not np.any(abs(signals.time[seen] - 0.52) < 1e-6)
    (thinner,) = read_signals([tmp_path / "fast"], period=0.1)
    assert np.allclose(np.diff(thinner.time), 0.1)


def test_estimates_in_a_run_are_compared_at_their_own_instants(run: Path, tmp_path: Path) -> None:
    (signals,) = read_signals([run])
    settings = bench_settings("ekf", form=BENCH)._replace(unsigned=0)
    start = initial_belief(deviation_n=3**0.5, deviation_v=0.005**0.5, deviation_U=0.005**0.5)
    own = observe(signals.y_n, signals.y_U, signals.u_after, DT, start, settings, HL)
    stamps = signals.time + read_run(run).start * 1e-9 - 1.0 + DT
    loaded = read_run(run)
    logged = topic("estimate", "ThrusterEstimate", stamps, n=own.n, v=own.v + 0.01, ambient=own.U)
    write_run(tmp_path / "logged", [
        topic("throttle", "Throttle", DT * np.arange(COUNT), commanded=THROTTLES),
        topic("state", "ThrusterState", DT * (1 + np.arange(COUNT)), n=loaded["thruster_0/state.n"].values,
              sign_source=np.ones(COUNT, dtype=np.uint8)),
        topic("flow", "FlowVelocity", DT * (1 + np.arange(COUNT)), ambient=loaded["thruster_0/flow.ambient"].values),
        logged,
    ])  # fmt: skip
    (with_log,) = read_signals([tmp_path / "logged"])
    outcome = replay(with_log, Job("ekf", "hl", bench_settings("ekf", form=BENCH), HL))
    found = {s.state: s for s in outcome.scores if s.against == "logged"}
    assert found["n"].samples == COUNT and found["n"].rmse < 1e-6
    assert found["v"].rmse == pytest.approx(0.01, abs=1e-6)


def test_the_benchs_own_recording_is_reproduced_from_the_imported_run(
    thruster_bench_data: Path, tmp_path: Path
) -> None:
    recording = next(g for g in find([thruster_bench_data / "closed_loop"]).groups if g.stem == "CL2stateKF1Sine")
    imported = import_recording(recording, tmp_path, BenchOptions())
    (signals,) = read_signals([imported.directory])
    assert signals.logged_by == "ekf" and signals.unsigned
    outcome = replay(signals, Job("ekf", "hl_bench", bench_settings("ekf", form=BENCH), BENCH_HL))
    found = {s.state: s for s in outcome.scores if s.against == "logged"}
    # the input map was re-tuned on the day: n differs, v and U hardly
    assert found["U"].samples == 251 and found["U"].largest < 5e-3 and found["n"].rmse < 3.0


def test_the_command_line_prints_a_table_and_writes_report_and_json(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "results"
    arguments = [str(run), "--estimator", "ekf", "nlo", "kfnlo", "speed-ekf", "--model", "hl", "hq", "--gate", "25"]
    assert main([*arguments, "--speed-noise", "2", "--out", str(out)]) == 0
    shown = capsys.readouterr().out
    assert "ekf, hl" in shown and "kfnlo, hq" in shown and "n ahead" in shown and "to truth" in shown
    results = json.loads((out / "replay.json").read_text("utf-8"))["results"]
    assert len(results) == 8 and results[0]["settings"]["r_n"] == 4.0 and results[0]["settings"]["patience"] == 0.5
    nlo = next(r for r in results if r["estimator"] == "nlo")
    assert nlo["settings"]["largest_innovation"] is None and nlo["nis_per_degree"] is not None
    page = (out / "report.html").read_text("utf-8")
    assert "square errors of the observers" in page and "speed-ekf, hq" in page
    assert sorted(p.name for p in out.iterdir()) == ["replay.json", "report.html"]


def test_the_throttle_is_what_the_device_got_once_it_got_something(states: Array, tmp_path: Path) -> None:
    measured = DT * (1 + np.arange(COUNT))
    sent = np.append([np.nan, np.nan], 0.9 * THROTTLES[2:])
    one = np.ones(COUNT, dtype=np.uint8)
    write_run(tmp_path / "sent", [
        topic("throttle", "Throttle", DT * np.arange(COUNT), commanded=THROTTLES),
        topic("throttle_sent", "Throttle", DT * np.arange(COUNT), commanded=THROTTLES, sent=sent),
        topic("state", "ThrusterState", measured, n=states[:, 0], sign_source=one),
    ])  # fmt: skip
    (signals,) = read_signals([tmp_path / "sent"])
    np.testing.assert_allclose(signals.u_before[3:], 0.9 * THROTTLES[3:], atol=1e-9)


def test_what_does_not_work_with_a_model_is_left_out_and_said(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(run), "--estimator", "ekf", "speed-ekf", "--model", "simplified"]) == 0
    told = capsys.readouterr()
    assert (
        "left out: ekf with simplified: the model has no axial flow" in told.err and "speed-ekf, simplified" in told.out
    )


def test_the_input_map_of_the_command_line_takes_the_place_of_the_sets(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    errors = []
    for extra in ([], ["--input-map", "300,-0.5,300,0.5"]):
        assert main([str(run), "--estimator", "speed-ekf", *extra]) == 0
        line = next(x for x in capsys.readouterr().out.splitlines() if x.startswith("made  "))
        errors.append(float(line.split()[3]))
    assert errors[1] > 5 * errors[0]


@pytest.mark.parametrize(("arguments", "told"), [
    (["nowhere"], "nowhere"),
    (["RUN", "RUN"], "given twice"),
    (["RUN", "--thruster", "3"], "expected a channel thruster_3/state.n"),
    (["RUN", "--gate", "-1"], "--gate: expected a number > 0; found -1"),
    (["RUN", "--input-map", "1,2,3"], "--input-map: expected four numbers"),
    (["RUN", "--input-map", "a,b,c,d"], "separated by commas; found 'a,b,c,d'"),
    (["RUN", "--model", "nonsense"], "nonsense"),
    (["RUN", "--model", "airfoil"], "found another class"),
    (["RUN", "--model", "simplified"], "only speed-ekf can work with it"),
    (["RUN", "--out", "FULL"], "expected a new or empty folder"),
])  # fmt: skip
def test_errors_are_sentences(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], told: str
) -> None:
    (tmp_path / "file").write_text("x", "utf-8")
    names = {"RUN": str(run), "FULL": str(tmp_path)}
    assert main([names.get(a, a) for a in arguments]) == 1
    written = capsys.readouterr()
    assert told in written.err and "Traceback" not in written.err and not written.out


def test_all_runs_that_cannot_be_replayed_are_named_at_once(run: Path, tmp_path: Path) -> None:
    with pytest.raises(EstimationError) as caught:
        read_signals([tmp_path / "a", run, tmp_path / "b"])
    assert len(caught.value.problems) == 2
