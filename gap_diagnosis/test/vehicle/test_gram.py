"""Evidence from products of columns: what it says must be what a normal distribution says."""

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import multivariate_normal

from gap_diagnosis.vehicle.gram import Column, Gram, evidence, gathered, solution

Array = NDArray[np.float64]


def made(J: list[Array], r: list[Array], switches: int = 0, **kwargs: int) -> Gram:
    """Return products of columns given by their matrices, of deviation 1; the last ones are switches."""
    n = J[0].shape[1]
    columns = [
        Column(j, 0.0 if j >= n - switches else 1.0, lambda k, j=j: J[k][:, j])  # type: ignore[misc]
        for j in range(n)
    ]
    return gathered(r, columns, **kwargs)


@pytest.fixture
def case() -> tuple[list[Array], list[Array]]:
    rng = np.random.default_rng(4)
    J = [rng.normal(size=(60, 4)), rng.normal(size=(50, 4))]
    r = [rng.normal(size=60) - 0.8 * J[0][:, 1], rng.normal(size=50) - 0.8 * J[1][:, 1]]
    return J, r


def test_the_evidence_is_that_of_a_normal_distribution(case: tuple[list[Array], list[Array]]) -> None:
    J, r = case
    gram = made(J, r)
    whole, residual = np.concatenate(J)[:, [0, 1]], np.concatenate(r)
    expected = multivariate_normal(np.zeros(110), np.eye(110) + whole @ whole.T).logpdf(residual)
    nothing = multivariate_normal(np.zeros(110), np.eye(110)).logpdf(residual)
    assert evidence(gram, [0, 1]) - evidence(gram, []) == pytest.approx(expected - nothing, rel=1e-4)


def test_a_switch_that_is_on_moves_the_residual_by_its_whole_column(case: tuple[list[Array], list[Array]]) -> None:
    J, r = case
    gram = made(J, r, switches=1)
    moved = made(J, [a + b[:, 3] for a, b in zip(r, J, strict=True)])
    assert evidence(gram, [0, 1], on=[3]) == pytest.approx(evidence(moved, [0, 1]), abs=1e-2)


def test_a_known_size_comes_back_within_its_deviation(case: tuple[list[Array], list[Array]]) -> None:
    gram = made(*case)
    sizes, covariance = solution(gram, range(4))
    assert abs(sizes[1] - 0.8) < 3.0 * np.sqrt(covariance[1, 1])
    assert np.all(np.abs(sizes[[0, 2, 3]]) < 4.0 * np.sqrt(covariance.diagonal()[[0, 2, 3]]))


def test_scores_of_white_residuals_scatter_as_expected_and_those_of_a_jump_do_not() -> None:
    rng = np.random.default_rng(5)
    J = [rng.normal(size=(2000, 2))]
    calm = rng.normal(size=2000)
    jump = calm.copy()
    jump[700:720] += 30.0 * np.sign(J[0][700:720, 1])
    assert made(J, [calm], base=1, block=50).scatter[1] < 1.6
    assert made(J, [jump], base=1, block=50).scatter[1] > 20.0
