"""Nameless dependences: what one number makes of all recordings, and a number of any size."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap_diagnosis.vehicle import screening
from gap_diagnosis.vehicle.gram import Column, evidence, gathered
from gap_diagnosis.vehicle.screening import Screen
from gap_diagnosis.vehicle.stage import of_any_size


def test_where_there_is_less_of_a_feature_there_is_less_of_its_wrench(monkeypatch: pytest.MonkeyPatch) -> None:
    fast = np.array([0.6, -0.2, 0.4])
    runs: Any = [SimpleNamespace(log=SimpleNamespace(count=3), feature=share * fast) for share in (1.0, 0.25)]
    monkeypatch.setattr(screening, "features", lambda run, name: run.feature)
    monkeypatch.setattr(screening, "filtered", lambda model, run, values, effects, extra=0.0, coarse=False: extra)
    monkeypatch.setattr(screening, "whitened", lambda run, result: np.asarray(result))
    model: Any = None
    column = Screen(model=model, runs=runs, values={}).of_nameless(("nameless", "pitch", "u|u|"))
    first, second = (column.change(k)[:, 4] for k in (0, 1))
    np.testing.assert_allclose(second, 0.25 * first)
    assert np.mean(np.concatenate((first, second)) ** 2) == pytest.approx(0.1**2)
    assert not column.change(0)[:, [0, 1, 2, 3, 5]].any()


@pytest.mark.parametrize("size", [0.0, 1.0, 20.0])
def test_a_number_of_any_size_costs_little_more_than_one_whose_size_was_foreseen(size: float) -> None:
    rng = np.random.default_rng(5)
    noise, trace = rng.normal(size=500), rng.normal(size=500)

    def gains(deviation: float) -> float:
        gram = gathered([noise - size * trace], [Column("number", deviation, lambda k: trace)])
        return evidence(gram, [0]) - evidence(gram, [])

    gram = gathered([noise - size * trace], [Column("number", 1.0, lambda k: trace)])
    found = of_any_size(gram, [], 0) - evidence(gram, [])
    assert max(map(gains, (1.0, 5.0, 25.0))) - np.log(3.0) < found < max(map(gains, (1.0, 5.0, 25.0)))
    if size == 20.0:
        assert found > gains(1.0) + 150.0, "with a deviation of 1 a size of 20 costs 200 nats"
