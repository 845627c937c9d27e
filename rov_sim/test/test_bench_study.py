"""The study: the same results whoever computes them, nothing lost, nothing overwritten, wrong arguments refused."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from rov_sim.bench_study.experiment import SCORES
from rov_sim.bench_study.plan_io import conditions_of, load_plant, plan_text
from rov_sim.bench_study.plants import drawn_plant
from rov_sim.bench_study.results_io import read_study, run_shard
from rov_sim.cli_bench_study import main
from rov_sim.closed_loop import CALM, ProcessNoise, Timing
from rov_sim.rig_sensors import Rig
from rov_sim.study.results_io import read_results
from rov_sim.study.running_io import StudyInterrupted, run_shards
from rov_sim.study.store_io import Shard, Store, shards_of
from thruster_model.errors import ParameterSetError
from thruster_model.parameter_set_io import load_parameter_set

STRATEGIES, REFERENCES = ("lookup", "hl-ekf"), ("sine",)


def plan(**changes) -> str:  # type: ignore[no-untyped-def]
    options = {"deviation": 0.05, "form": "bench", "beliefs": "bench", "rig": Rig(), "timing": Timing(), "seed": 1}
    return plan_text(load_plant("hl_bench"), **{**options, **changes})


@pytest.fixture(scope="module")
def finished(tmp_path_factory) -> Store:  # type: ignore[no-untyped-def]
    store = Store(tmp_path_factory.mktemp("study") / "a", plan(), SCORES)
    run_shards(store, shards_of(STRATEGIES, REFERENCES, 30), run_shard)
    return store


def texts(store: Store) -> dict[str, str]:
    return {file.name: file.read_text("utf-8") for file in sorted((store.folder / "shards").iterdir())}


def test_an_interrupted_study_resumes_with_what_is_missing_and_ends_the_same(finished: Store, tmp_path: Path) -> None:
    store, shards = Store(tmp_path / "b", plan(), SCORES), shards_of(STRATEGIES, REFERENCES, 30)
    assert len(shards) == 4

    class Stop(Exception):
        pass

    def interrupt(done: int, total: int) -> None:
        if done == 2:
            raise Stop

    with pytest.raises(Stop):
        run_shards(store, shards, run_shard, progress=interrupt)
    assert len(texts(store)) == 2
    assert run_shards(Store(tmp_path / "b", plan(), SCORES), shards, run_shard) == 2
    assert texts(store) == texts(finished)
    assert run_shards(store, shards, run_shard) == 0


def test_processes_compute_what_one_process_computes(finished: Store, tmp_path: Path) -> None:
    store = Store(tmp_path / "b", plan(), SCORES)
    run_shards(store, shards_of(("lookup",), REFERENCES, 30), run_shard, processes=2)
    for name, text in texts(store).items():
        assert texts(finished)[name] == text


def test_a_worker_that_dies_loses_nothing_that_was_finished(tmp_path: Path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    from concurrent.futures.process import BrokenProcessPool

    from rov_sim.study import running_io

    def dying(run, text: str, shards: list[Shard], processes: int):  # type: ignore[no-untyped-def]
        yield shards[0], run(text, shards[0])
        raise StudyInterrupted("a worker process died") from BrokenProcessPool()

    monkeypatch.setattr(running_io, "_in_processes", dying)
    store, shards = Store(tmp_path / "b", plan(), SCORES), shards_of(("lookup",), REFERENCES, 60)
    with pytest.raises(StudyInterrupted):
        run_shards(store, shards, run_shard, processes=2)
    assert [store.has(shard) for shard in shards] == [True, False, False]


def test_a_cluster_computes_what_one_process_computes(finished: Store, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None, host="127.0.0.1"
    ) as cluster:
        store = Store(tmp_path / "b", plan(), SCORES)
        run_shards(store, shards_of(("lookup",), REFERENCES, 30), run_shard, scheduler=cluster.scheduler_address)
    for name, text in texts(store).items():
        assert texts(finished)[name] == text


def test_the_results_are_read_back_in_the_order_of_the_seeds(finished: Store) -> None:
    study = read_results(finished, shards_of(STRATEGIES, REFERENCES, 30))
    assert study.seeds == 30 and study.strategies == STRATEGIES
    alone = run_shard(plan(), Shard("hl-ekf", "sine", 27, 28))
    assert study.of("hl-ekf", "sine", "rmse")[27] == alone["rmse"][0]
    assert np.all(np.isnan(study.of("lookup", "sine", "overshoot")))
    assert read_study(finished.folder)[1].scores.keys() == study.scores.keys()
    ratio = study.normalised("hl-ekf", "sine")
    assert ratio.low < ratio.value < ratio.high < 1.0


def test_strategies_with_one_seed_meet_the_same_thruster_and_another_seed_another() -> None:
    truth = load_parameter_set("hl_bench")
    one, same, other = (drawn_plant(truth, 0.05, np.random.default_rng((1, seed, 0))) for seed in (3, 3, 4))
    assert one == same and one != other
    assert drawn_plant(truth, 0.0, np.random.default_rng(0)).coefficients == truth.coefficients
    drawn = [drawn_plant(truth, 0.05, np.random.default_rng(k)).coefficients.k_n for k in range(400)]
    assert np.std(np.log(drawn)) == pytest.approx(0.05, rel=0.15)
    assert one.coefficients.u_dot_max == truth.coefficients.u_dot_max


def test_another_plan_does_not_enter_a_study_s_folder(finished: Store, tmp_path: Path) -> None:
    with pytest.raises(FileExistsError, match="found a study of another plan"):
        Store(finished.folder, plan(seed=2), SCORES)
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(FileExistsError, match="found other files"):
        Store(tmp_path, plan(), SCORES)


def test_a_shard_that_was_damaged_is_refused(finished: Store, tmp_path: Path) -> None:
    store, shard = Store(tmp_path / "b", plan(), SCORES), Shard("lookup", "sine", 0, 25)
    store.save(shard, {name: [1.0] for name in SCORES})
    with pytest.raises(ValueError, match="expected 25 values of each score"):
        store.load(shard)


def test_a_plan_survives_its_way_through_json() -> None:
    given = conditions_of(plan(rig=Rig(resonance=15.0), timing=Timing(computation=0.02)))
    assert given.rig == Rig(resonance=15.0) and given.timing == Timing(computation=0.02)
    assert given.truth.coefficients == load_parameter_set("hl_bench").coefficients
    assert conditions_of(plan()).rig == Rig()


def test_re_tuned_parameters_of_a_diagnosis_become_a_plant(tmp_path: Path) -> None:
    nominal = load_parameter_set("hl_bench")
    content = {"provenance": {"parameter_set": nominal.name}, "retuned_parameters": {"k_n": {"value": 12.5}}}
    file = tmp_path / "diagnosis.json"
    file.write_text(json.dumps(content))
    found, noise, without = load_plant(str(file))
    assert noise == CALM and not without
    assert found.values["k_n"] == 12.5 and found.values["k_v"] == nominal.values["k_v"]
    content["budget"] = {
        "process_noise": {"rotor": 20.0, "flow": 0.01, "memory": 0.8},
        "with_causes_without_each_run": {
            "CLx": {"parameters": {"k_n": 11.0}, "effects": {"thrust_loss": {"share": 0.2}}}
        },
    }
    file.write_text(json.dumps(content))
    plant = load_plant(str(file))
    assert plant.process_noise == ProcessNoise(rotor=20.0, flow=0.01, memory=0.8)
    assert plant.without["CLx"].values["k_n"] == 11.0
    assert plant.without["CLx"].effects.sizes == {"thrust_loss": {"share": 0.2}}
    options = {"deviation": 0.0, "form": "bench", "beliefs": "bench", "rig": Rig(), "timing": Timing(), "seed": 1}
    assert conditions_of(plan_text(plant, **options)).process_noise == plant.process_noise
    content["budget"]["with_causes_without_each_run"]["CLx"] = {"effects": {}}
    file.write_text(json.dumps(content))
    with pytest.raises(ParameterSetError, match="KeyError\\('parameters'\\)"):
        load_plant(str(file))
    file.write_text("{}")
    with pytest.raises(ParameterSetError, match=r"expected a diagnosis\.json with retuned_parameters"):
        load_plant(str(file))


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["--strategies", "hl-ekf,magic"], "--strategies: expected some of lookup, .*; found 'magic'"),
        (["--references", "square"], "--references: expected some of step, triangle, sine; found 'square'"),
        (["--seeds", "0"], "--seeds: expected 1 or more; found 0"),
        (["--deviation", "-1"], "--deviation: expected a share from 0 to 1; found -1"),
        (["--scheduler", "tcp://10.0.0.1:8786"], "--scheduler: expected tcp://HOST:PORT with a host of this machine"),
        (["--plant", "nothing"], "expected a YAML file or one of the known sets"),
        (["--spikes", "1.5"], "spike_share: expected a share from 0 to 1; found 1.5"),
        (["--sample", "0.01", "--form", "proper", "--seeds", "1"], "expected a sample at or before the beginning"),
        (["--real", "/nowhere"], "/nowhere: no such file or directory"),
    ],
)
def test_wrong_arguments_are_refused_with_a_sentence(arguments, text, tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    assert main([*arguments, "--out", str(tmp_path / "out")]) == 1
    found = capsys.readouterr().err
    assert re.search(text, found), found


def test_the_command_writes_scores_and_a_report_and_is_done_the_second_time(tmp_path: Path, capsys) -> None:  # type: ignore[no-untyped-def]
    arguments = [
        "--strategies",
        "lookup,hl-ekf",
        "--references",
        "sine",
        "--seeds",
        "2",
        "--out",
        str(tmp_path / "out"),
    ]
    assert main(arguments) == 0
    told = capsys.readouterr().out
    lines = (tmp_path / "out/scores.csv").read_text().splitlines()
    assert lines[0].startswith("strategy,reference,seed,rmse [N]") and len(lines) == 1 + 4
    page = (tmp_path / "out/report.html").read_text("utf-8")
    assert "as Fig. 5.7" in page and "Intervals rest on 2 seeds" in page
    shards = {f: f.stat().st_mtime_ns for f in (tmp_path / "out/shards").iterdir()}
    assert main(arguments) == 0
    assert capsys.readouterr().out == told
    assert {f: f.stat().st_mtime_ns for f in (tmp_path / "out/shards").iterdir()} == shards
    assert main([each.replace("lookup,hl-ekf", "lookup") for each in arguments]) == 0
    assert "tell of lookup; what hl-ekf scored before is kept in" in capsys.readouterr().err
