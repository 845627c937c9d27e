"""Seals that cannot be changed, checks that can be resumed, runs that tell nothing."""

import json
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from gap_diagnosis.blind_check.cases import plan
from gap_diagnosis.blind_check.running_io import diagnose_all, opened_cases
from gap_diagnosis.blind_check.sealing import BrokenSealError, seal, unseal
from gap_diagnosis.blind_check.store_io import Store
from run_bag import read_run
from thruster_model.parameter_set_io import load_parameter_set


class Stub:
    """A diagnosis that finds no gap and counts how often it is asked."""

    def __init__(self, fails_at=()):
        self.seen, self.fails_at = [], fails_at

    def __call__(self, paths, parameter_set_path, excluded=()):
        self.seen.append((paths, parameter_set_path, excluded))
        if len(self.seen) in self.fails_at:
            raise RuntimeError("no convergence")
        load_parameter_set(parameter_set_path)
        return {"verdict": "no_gap", "candidates": [], "p_none": 1.0, "p_unknown": 0.0}


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "check", seed=11)


PLANS = plan(3, 11, kinds=["effect", "none", "few_channels"])


def run(store, stub, plans=PLANS, **more):
    with ThreadPoolExecutor(1) as executor:
        return diagnose_all(store, plans, executor, diagnose=stub, **more)


def test_a_seal_opens_to_its_key_and_no_bit_of_it_can_be_changed():
    sealed = seal({"case": "a", "size": 0.25}, b"channels", nonce="1f")
    assert unseal("a", sealed, sealed.hash)["size"] == 0.25
    for other in (
        type(sealed)(sealed.key.replace(b"0.25", b"0.24"), b"channels"),
        type(sealed)(sealed.key, b"channelt"),
    ):
        with pytest.raises(BrokenSealError, match="the seal of a is broken: the published hash is"):
            unseal("a", other, sealed.hash)
    with pytest.raises(BrokenSealError, match="no hash was published"):
        unseal("a", sealed, None)


def test_the_same_key_has_another_hash_with_another_nonce():
    assert seal({"case": "a"}, b"", "1").hash != seal({"case": "a"}, b"", "2").hash


def test_nothing_is_diagnosed_before_its_hash_is_published(store):
    stub = Stub()
    failed = run(store, stub)
    assert set(failed) == {each.name for each in PLANS} and not stub.seen
    assert "BrokenSealError" in failed["case_00000"]


def test_a_key_changed_after_publishing_is_not_scored(store):
    store.publish(PLANS)
    run(store, Stub())
    file = store.folder / "sealed" / "case_00000.json"
    key = json.loads(file.read_text())
    file.write_text(json.dumps({**key, "effects": {"tach_lag": {"time": 0.1}}}))
    with pytest.raises(BrokenSealError, match="the seal of case_00000 is broken"):
        opened_cases(store, PLANS)
    with pytest.raises(BrokenSealError, match="it is not scored"):
        store.publish(PLANS)


def test_the_diagnosis_gets_runs_a_parameter_set_and_what_is_left_out_and_nothing_else(store):
    plans = plan(1, 11, kinds=["left_out"])
    store.publish(plans)
    stub = Stub()
    run(store, stub, plans, keep_runs=True)
    ((paths, parameter_set, excluded),) = stub.seen
    assert len(paths) == 4 and len(excluded) == 1
    folder = parameter_set.parent
    visible = {f.relative_to(folder).as_posix() for f in folder.rglob("*") if f.is_file()}
    assert {name for name in visible if not name.startswith("runs/")} == {
        "model.yaml",
        "library.json",
        "predictions.npz",
        "diagnosis.json",
    }
    assert load_parameter_set(parameter_set).values == load_parameter_set(store.key("case_00000")["model"]).values


def test_recordings_have_the_topics_of_a_bench_and_begin_at_one_second(store):
    plans = plan(1, 11, kinds=["none"])
    store.publish(plans)
    run(store, Stub(), plans, keep_runs=True)
    read = read_run(store.case_folder("case_00000") / "runs" / "steps")
    names = {"thruster_0/throttle.commanded", "thruster_0/state.n", "thruster_0/flow.ambient"}
    names |= {"thruster_0/load.wrench.force.x", "thruster_0/load.wrench.torque.x"}
    assert names <= {name.lstrip("/") for name in read.channels}


def test_a_finished_case_is_never_done_again_and_a_half_written_one_is(store):
    published = store.publish(PLANS)
    assert run(store, Stub(fails_at=(2,))) == {"case_00001": "RuntimeError: no convergence"}
    assert (store.case_folder("case_00001") / "runs").is_dir(), "half-written: runs without a diagnosis"
    again = Stub()
    assert store.publish(PLANS) == published and run(store, again) == {}
    assert [paths[0].parts[-3] for paths, *_ in again.seen] == ["case_00001"]
    assert not list(store.folder.glob("cases/*/runs"))


def test_a_failed_diagnosis_counts_as_a_wrong_one(store):
    store.publish(PLANS)
    run(store, Stub(fails_at=(1,)))
    cases = opened_cases(store, PLANS)
    assert [case.diagnosis["verdict"] for case in cases] == ["failed", "no_gap", "no_gap"]


def test_a_longer_check_keeps_what_is_there(store):
    store.publish(PLANS[:2])
    before = store.hashes()
    store.publish(PLANS)
    assert {name: store.hashes()[name] for name in before} == before and len(store.hashes()) == 3


def test_a_folder_of_another_choice_of_cases_is_refused(store):
    store.publish(PLANS)
    with pytest.raises(ValueError, match="another seed or another choice of cases"):
        store.publish(plan(3, 11, kinds=["pair"]))


def test_predictions_of_a_diagnosis_come_back_with_it(store):
    store.publish(PLANS[:1])

    def predicting(paths, parameter_set_path, excluded=()):
        kept = {"steps": {"n": [0.5, None, 2.0]}}
        return {"verdict": "no_gap", "predictions": {"retuned": kept, "with_effect": kept}}

    assert run(store, predicting, PLANS[:1]) == {}
    _, found, _ = store.opened("case_00000")
    assert found["predictions"]["retuned"]["steps"]["n"] == pytest.approx([0.5, np.nan, 2.0], nan_ok=True)


def test_the_clean_channels_come_back_from_the_seal_sample_by_sample(store):
    store.publish(PLANS)
    run(store, Stub())
    _, _, clean = store.opened("case_00001")
    assert set(clean) == {"steps", "multisine", "ramps", "constant"}
    assert all(values.shape == (750,) and np.all(np.isfinite(values)) for values in clean["steps"].values())
