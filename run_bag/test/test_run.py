"""Channels and runs in memory."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from run_bag import Channel, InvalidRunError, MissingChannelError, Run, RunError

SECOND = 1_000_000_000


def channel(name="a.x", stamps=(0, SECOND, 3 * SECOND), values=(1.0, 2.0, 6.0), **kw):
    return Channel(name=name, stamps=np.array(stamps, dtype=np.int64), values=np.array(values, dtype=float), **kw)


def run(*channels, **kw):
    return Run(name="r", channels={c.name: c for c in channels or (channel(),)}, **kw)


def test_the_arrays_of_a_channel_are_copies_and_read_only():
    values = np.array([1.0, 2.0])
    c = Channel(name="a.x", stamps=np.array([0, 1]), values=values)
    values[0] = 9
    assert c.values[0] == 1
    with pytest.raises(ValueError, match="read-only"):
        c.values[0] = 3
    with pytest.raises(ValueError, match="read-only"):
        pickle.loads(pickle.dumps(c)).stamps[0] = 3


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"name": "/a.x"}, "without leading slash"),
        ({"stamps": np.array([0.0, 1.0])}, "integer stamps in nanoseconds, found float64"),
        ({"stamps": np.array([1, 0])}, "backwards at sample 1: 1 ns, then 0 ns"),
        ({"values": np.array([1.0])}, "of one length, found (2,) and (1,)"),
        ({"values": np.array(["a", "b"])}, "numbers as values"),
        ({"stamps": np.array([], dtype=int), "values": np.array([])}, "at least one sample"),
    ],
)
def test_a_malformed_channel_is_refused_with_a_sentence(change, sentence):
    good = {"name": "a.x", "stamps": np.array([0, 1]), "values": np.array([1.0, 2.0])}
    with pytest.raises(InvalidRunError) as caught:
        Channel(**{**good, **change})
    assert sentence in str(caught.value)


def test_all_that_is_wrong_with_a_channel_is_told_at_once():
    with pytest.raises(InvalidRunError) as caught:
        Channel(name="", stamps=np.array([1.5]), values=np.array([1.0, 2.0]))
    assert len(caught.value.problems) == 3


def test_a_missing_channel_is_answered_with_the_nearest_name_and_all_names():
    with pytest.raises(MissingChannelError, match=r"nearest is 'a\.x'; it has: a\.x") as caught:
        run()["a.y"]
    assert caught.value.available == ("a.x",)
    assert isinstance(caught.value, RunError)
    assert "a.y" not in run() and "a.x" in run()


def test_times_count_in_seconds_from_the_first_stamp_of_any_channel():
    r = run(channel(), channel("b.x", stamps=(2 * SECOND,), values=(0.0,)))
    assert (r.start, r.end, r.duration) == (0, 3 * SECOND, 3.0)
    assert r.time("b.x").tolist() == [2.0]


def test_a_slice_is_half_open_and_drops_channels_without_samples():
    r = run(channel(), channel("b.x", stamps=(3 * SECOND,), values=(0.0,)))
    part = r.slice(0.0, 3.0)
    assert list(part) == ["a.x"] and part["a.x"].values.tolist() == [1.0, 2.0]
    assert r.slice(1.0)["a.x"].values.tolist() == [2.0, 6.0]
    with pytest.raises(InvalidRunError, match="at least one channel"):
        r.slice(1.5, 1.6)


def test_alignment_by_hand():
    r, grid = run(), [-1.0, 0.0, 0.5, 1.0, 2.0, 3.0, 4.0]
    nan = np.nan
    np.testing.assert_equal(r.align(["a.x"], grid, "previous")["a.x"], [nan, 1, 1, 2, 2, 6, nan])
    np.testing.assert_equal(r.align(["a.x"], grid, "linear")["a.x"], [nan, 1, 1.5, 2, 4, 6, nan])
    np.testing.assert_equal(r.align(["a.x"], [0.0, 1.0, 2.0, 3.0], "mean")["a.x"], [1, 2, nan, 6])


@given(st.integers(2, 40), st.integers(0, 2**32 - 1))
def test_alignment_agrees_with_a_search_sample_by_sample(count, seed):
    random = np.random.default_rng(seed)
    stamps = np.sort(random.integers(0, 30, count)) * 10_000_000
    values = np.where(random.random(count) < 0.2, np.nan, random.normal(size=count))
    r = run(channel(stamps=stamps, values=values))
    grid = np.arange(12) * 0.02
    ticks = r.start + np.round(grid * 1e9).astype(int)
    held = r.align(["a.x"], grid, "previous")["a.x"]
    mean = r.align(["a.x"], grid, "mean")["a.x"]
    for i, tick in enumerate(ticks):
        if tick > stamps[-1]:
            assert np.isnan(held[i]) and np.isnan(mean[i])
            continue
        before = [v for s, v in zip(stamps, values, strict=True) if s <= tick]
        np.testing.assert_equal(held[i], before[-1])
        cell = [
            v for s, v in zip(stamps, values, strict=True)
            if tick - 10_000_000 <= s < tick + 10_000_000 and np.isfinite(v)
        ]  # fmt: skip
        np.testing.assert_allclose(mean[i], np.mean(cell) if cell else np.nan, atol=1e-12)


def test_a_grid_point_on_a_stamp_is_on_it_in_spite_of_rounding():
    stamps = np.arange(100_000) * 1_000_000 + 7
    r = run(channel(stamps=stamps, values=np.arange(100_000.0)))
    grid = np.arange(100_000) * 0.001
    assert np.array_equal(r.align(["a.x"], grid, "previous")["a.x"], np.arange(100_000.0))
    assert np.array_equal(r.align(["a.x"], grid, "linear")["a.x"], np.arange(100_000.0))


@pytest.mark.parametrize(("grid", "method"), [([1.0, 1.0], "previous"), ([0.0], "mean"), ([np.nan], "linear")])
def test_an_unusable_grid_is_refused(grid, method):
    with pytest.raises(RunError, match="strictly increasing times"):
        run().align(["a.x"], grid, method)


def test_variants_leave_the_original_alone():
    r = run(channel("a.x"), channel("b.x"), metadata={"k": [1]}, warnings=("w",))
    other = r.drop(["a.x"])
    assert list(other) == ["b.x"] and "a.x" in r and other.metadata == {"k": [1]} and other.warnings == ("w",)
    with pytest.raises(MissingChannelError):
        r.drop(["zzz"])


def test_metadata_that_is_no_json_is_refused():
    with pytest.raises(InvalidRunError, match="no JSON"):
        run(metadata={"x": float("nan")})


def test_errors_keep_their_facts_across_processes():
    try:
        run()["q"]
    except MissingChannelError as error:
        copy = pickle.loads(pickle.dumps(error))
        assert copy.name == "q" and copy.available == ("a.x",) and str(copy) == str(error)
