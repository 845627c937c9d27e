"""How much of the gap the nearest hypothesis explains, on costs made up by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from gap_diagnosis.nearest import share_explained


def hypothesis(cost, gains=(), samples=100):
    problem = SimpleNamespace(known=np.ones(samples, dtype=bool))
    unexplained = SimpleNamespace(features=[SimpleNamespace(gain=gain) for gain in gains])
    return SimpleNamespace(fitted=SimpleNamespace(cost=cost, problem=problem), unexplained=unexplained)


@pytest.mark.parametrize(
    ("cost", "gains", "share"),
    [
        (100.0, (), 1.0),  # down to a unit a sample
        (200.0, (), 2.0 / 3.0),
        (200.0, (30.0, 10.0), 2.0 / 3.0),  # what functions explain is part of what is left
        (80.0, (150.0, 30.0), 0.64),  # below a unit a sample, though functions still explain something
        (600.0, (), 0.0),
    ],
)
def test_what_is_left_is_above_the_noise_or_explained_by_functions(cost, gains, share):
    assert share_explained(hypothesis(cost, gains), hypothesis(400.0)) == pytest.approx(share)
