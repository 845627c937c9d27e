"""The study of the vehicle: two strategies of a short plan, whoever computes them; resumed, and refused if wrong."""

import re
from pathlib import Path

import pytest
import yaml

from rov_sim.cli_rov_study import main
from rov_sim.study.running_io import run_shards
from rov_sim.study.store_io import Store
from rov_sim.vehicle_study.plan_io import load_plan, parse_plan, plan_text
from rov_sim.vehicle_study.results_io import contents_of, read_study, run_shard, shards
from rov_sim.vehicle_study.scoring import SCORES

PLAN = load_plan("thesis")


@pytest.fixture(scope="module")
def short(tmp_path_factory) -> Path:  # type: ignore[no-untyped-def]
    """A plan of 12 s with two groups of two strategies."""
    assumed = {
        name: {"value": each.value, "unit": "", "reason": each.reason} for name, each in PLAN.assumed.items()
    }  # fmt: skip
    from rov_sim.vehicle_study.assumptions import unit_of

    for name, entry in assumed.items():
        entry["unit"] = unit_of(name)
    assumed["duration"]["value"] = 12.0
    groups = {
        "speed_loop": {"title": "a", "strategies": ["lookup", "hq-ekf"], "change": {"truth": "simplified"}},
        "flow": {"title": "b", "strategies": ["lookup", "hq-ekf"], "vary": {"feedback": ["truth", "estimator"]}},
    }
    file = tmp_path_factory.mktemp("plan") / "short.yaml"
    file.write_text(yaml.safe_dump({"title": "short", "assumed": assumed, "groups": groups}, sort_keys=False))
    return file


def test_the_command_writes_what_it_names_and_is_done_the_second_time(short: Path, tmp_path: Path, capsys) -> None:  # type: ignore[no-untyped-def]
    arguments = ["--plan", str(short), "--seeds", "2", "--out", str(tmp_path / "out")]
    assert main(arguments) == 0
    told = capsys.readouterr().out
    named = [Path(line) for line in told.splitlines() if line.startswith(str(tmp_path))]
    assert len(named) == 5 and all(file.is_file() for file in named)
    lines = (tmp_path / "out/scores.csv").read_text().splitlines()
    assert lines[0].startswith("strategy,reference,seed,surge [1]") and len(lines) == 1 + 2 * 2 + 2 * 2 * 2
    page = (tmp_path / "out/report.html").read_text("utf-8")
    assert "as Fig. 5.11" in page and "Intervals rest on 2 seeds" in page and "as Fig. 5.13" in page
    assert "| 5 | Flow compensation pays" in (tmp_path / "out/tables.md").read_text("utf-8")
    before = {f: f.stat().st_mtime_ns for f in (tmp_path / "out/shards").iterdir()}
    assert main(arguments) == 0
    assert capsys.readouterr().out == told
    assert {f: f.stat().st_mtime_ns for f in (tmp_path / "out/shards").iterdir()} == before

    text, study = read_study(tmp_path / "out")
    assert study.seeds == 2 and set(study.strategies) == {"lookup", "hq-ekf"}
    assert main([*arguments[:4], "--seed", "2", *arguments[4:]]) == 1
    assert "found a study of another plan" in capsys.readouterr().err
    plan = parse_plan(short.read_text("utf-8"), origin="short.yaml")
    assert plan_text(plan, contents_of(plan)) == text


@pytest.mark.long
def test_processes_compute_what_one_process_computes(short: Path, tmp_path: Path) -> None:
    plan = parse_plan(short.read_text("utf-8"), origin="short.yaml")
    found = []
    for processes in (1, 2):
        store = Store(tmp_path / str(processes), plan_text(plan, contents_of(plan)), SCORES)
        run_shards(store, shards(plan, 2)[:2], run_shard, processes=processes)
        found.append({file.name: file.read_text("utf-8") for file in sorted((store.folder / "shards").iterdir())})
    assert found[0] == found[1] and len(found[0]) == 2


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["--plan", "nothing"], "expected a YAML file or one of the known plans"),
        (["--groups", "flow,magic"], "--groups: expected some of speed_loop, .*; found 'magic'"),
        (["--seeds", "0", "--processes", "0"], "--seeds: expected 1 or more; found 0\n--processes: expected 1 or more"),
        (["--scheduler", "tcp://10.0.0.1:8786"], "--scheduler: expected tcp://HOST:PORT with a host of this machine"),
    ],
)
def test_wrong_arguments_are_refused_with_a_sentence(arguments, text, tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    assert main([*arguments, "--out", str(tmp_path / "out")]) == 1
    found = capsys.readouterr().err
    assert re.search(text, found), found
    assert not (tmp_path / "out").exists()
