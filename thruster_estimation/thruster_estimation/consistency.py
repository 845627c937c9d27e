"""Whether a filter's innovations are as large as it says."""

from math import sqrt
from statistics import NormalDist

__all__ = ["nis_interval"]


def nis_interval(count: int, confidence: float = 0.95, *, degrees: float = 1.0) -> tuple[float, float]:
    """Return the two-sided interval of the mean of `count` >= 10 NIS values of a consistent filter.

    The sum is chi-square with count times `degrees` (the mean of the values' own) degrees of freedom; its quantiles by
    Wilson and Hilferty, to 1 %.
    """
    if not (count >= 10 and 0 < confidence < 1 and degrees > 0):
        got = f"{count}, {confidence} and {degrees}"
        raise ValueError(f"nis_interval: expected count >= 10, 0 < confidence < 1 and degrees > 0, got {got}")
    c, z = 2.0 / (9.0 * count * degrees), NormalDist().inv_cdf(0.5 + 0.5 * confidence)
    return degrees * (1.0 - c - z * sqrt(c)) ** 3, degrees * (1.0 - c + z * sqrt(c)) ** 3
