"""The load cell's geometry: six legs between two plates, a Gough-Stewart platform.

    s_i = (p_i - b_i) / |p_i - b_i|                               (3.1)
    F_w = H f                                                     (3.2)
    H = [ s_1 ... s_6 ; S(b_1) s_1 ... S(b_6) s_6 ]               (3.3)

b_i, p_i [m] are where leg i meets the fixed and the loaded plate, f_i [N] is its axial force (positive along s_i),
F_w = (f_x, f_y, f_z, m_x, m_y, m_z) [N, N m] the resultant about the origin of the fixed plate's frame, S(b) s = b x s.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thruster_model.errors import ThrusterModelError

__all__ = ["WORST_CONDITION", "Hexapod", "HexapodError", "leg_lines"]

Array = NDArray[np.float64]
WORST_CONDITION = 1e4
"""Condition number above which forces in the legs do not determine a wrench in practice."""


class HexapodError(ThrusterModelError):
    """A geometry that measures no wrench; `problems` holds one sentence for each thing that is wrong."""

    def __init__(self, problems: list[str]) -> None:
        self.problems = tuple(problems)
        super().__init__("\n".join(f"load cell: {problem}" for problem in problems))


@dataclass(frozen=True, kw_only=True, eq=False)
class Hexapod:
    """Six legs.

    Attributes:
        base: b_i [m] (6, 3).
        platform: p_i [m] (6, 3).

    Raises:
        HexapodError: wrong shape, a leg without length, or legs that leave some load without a force in any of them.
    """

    base: Array
    platform: Array

    def __init__(self, *, base: ArrayLike, platform: ArrayLike) -> None:
        problems = []
        for name, given in (("base", base), ("platform", platform)):
            array = np.array(given, dtype=np.float64)
            array.flags.writeable = False
            object.__setattr__(self, name, array)
            if array.shape != (6, 3):
                problems.append(f"{name}: expected 6 points of 3 coordinates [m]; found shape {array.shape}")
            elif not np.all(np.isfinite(array)):
                problems.append(f"{name}: expected finite coordinates [m]; found {array[~np.isfinite(array)]}")
        if not problems:
            lengths = np.linalg.norm(self.platform - self.base, axis=1)
            problems += [f"leg {i + 1}: both ends are at {self.base[i]} m" for i in np.flatnonzero(lengths == 0.0)]
        if not problems and not self.condition < WORST_CONDITION:
            problems.append(
                f"expected legs that carry every load; the condition number of H is {self.condition:.3g} "
                f"(at most {WORST_CONDITION:g} is usable): {_lost(self.matrix, self.size)}"
            )
        if problems:
            raise HexapodError(problems)

    @property
    def directions(self) -> Array:
        """Unit vectors s_i (6, 3), equation (3.1)."""
        legs = self.platform - self.base
        return np.asarray(legs / np.linalg.norm(legs, axis=1, keepdims=True))

    @property
    def matrix(self) -> Array:
        """H (6, 6), equation (3.3): rows force [1] and moment [m]."""
        s = self.directions
        return np.vstack([s.T, np.cross(self.base, s).T])

    @property
    def size(self) -> float:
        """Root-mean-square distance of the joints from their centre [m]: what moments are compared with forces by."""
        joints = np.vstack([self.base, self.platform])
        return float(np.sqrt(np.mean(np.sum((joints - joints.mean(axis=0)) ** 2, axis=1))))

    @property
    def condition(self) -> float:
        """Condition number of H with moments over `size`; infinite where some load is not carried by any leg."""
        values = np.linalg.svd(_scaled(self.matrix, self.size), compute_uv=False)
        return float(values[0] / values[-1]) if values[-1] > values[0] * 1e-14 else float("inf")

    def wrench(self, legs: ArrayLike) -> Array:
        """Return F_w [N, N m] (..., 6) for forces in the legs [N] (..., 6), equation (3.2)."""
        return np.asarray(np.asarray(legs, dtype=np.float64) @ self.matrix.T)


def _scaled(matrix: Array, size: float) -> Array:
    return np.asarray(matrix / np.array([1.0, 1.0, 1.0, size, size, size])[:, np.newaxis])


def _lost(matrix: Array, size: float) -> str:
    """Say which load the legs carry worst."""
    left = np.linalg.svd(_scaled(matrix, size))[0][:, -1]
    left = left * np.sign(left[np.argmax(np.abs(left))])
    names = ("f_x", "f_y", "f_z", "m_x/r", "m_y/r", "m_z/r")
    parts = [f"{value:+.2f} {name}" for name, value in zip(names, left, strict=True) if abs(value) > 0.05]
    return f"they hardly feel {' '.join(parts)} (r = {size:.3g} m)"


def leg_lines(matrix: ArrayLike) -> tuple[Array, Array, Array]:
    """Return what the columns of a calibrated matrix H_A mean as legs.

    Returns:
        directions: unit vectors (6, 3).
        gain: length of each column's force part, 1 for a perfect gauge (6,).
        foot: point of each line of action that is nearest to the origin [m] (6, 3), or NaN where the column has no
            force. What the column has along the leg itself as moment (none in (3.3)) is left out.
    """
    H = np.asarray(matrix, dtype=np.float64)
    force, moment = H[:3].T, H[3:].T
    gain = np.linalg.norm(force, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        foot = np.cross(force, moment) / gain[:, np.newaxis] ** 2
        return force / gain[:, np.newaxis], gain, foot
