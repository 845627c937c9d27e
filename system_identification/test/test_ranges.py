"""Steps of a fit are cut at the ends of ranges, and what is free is best beside what is cut."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from system_identification.ranges import within_ranges


@pytest.mark.parametrize("seed", range(5))
def test_a_step_of_a_linear_problem_ends_at_its_minimum_inside_the_ranges(seed: int) -> None:
    rng = np.random.default_rng(seed)
    J = rng.standard_normal((40, 4)) @ rng.standard_normal((4, 4))
    y = J @ np.array([2.0, -0.5, 0.3, 0.1]) + rng.standard_normal(40)
    lower, upper = np.array([-np.inf] * 4), np.array([0.5, np.inf, np.inf, np.inf])
    H = J.T @ J
    there = within_ranges(lambda x: np.clip(x, lower, upper), np.zeros(4), np.linalg.solve(H, J.T @ y), H, J.T @ y)
    assert there == pytest.approx(lsq_linear(J, y, (lower, upper), tol=1e-12).x, abs=1e-6)


def test_a_step_inside_the_ranges_stays_what_it_is() -> None:
    step = np.array([0.5, -0.25])
    there = within_ranges(lambda x: np.clip(x, -1.0, 1.0), np.ones(2) * 0.25, step, np.eye(2), step)
    assert there == pytest.approx([0.75, 0.0])
