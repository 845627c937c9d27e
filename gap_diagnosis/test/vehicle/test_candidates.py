"""From where a further effect is fitted."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.candidates import _mirrored, may_stand_for_more
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.hypotheses import hypotheses
from gap_diagnosis.vehicle.refining import Fit, Refined


def test_a_mass_at_a_place_is_tried_on_the_other_side_with_the_vehicle_s_own_centre_where_that_undoes_it() -> None:
    (payload,) = (h for h in hypotheses(load_model("ngs"), {}) if h.effect == "payload")
    centre, weight, _, y, z = 100.0 * np.eye(5)
    x = 0.4 * centre  # what a place does the vehicle's own centre does, too
    columns = np.stack((centre, weight, x, y, z), axis=1).astype(np.float32)
    refined = Refined(hypothesis=payload, sizes=(0.2, -0.6, 0.0, 0.3), deviations=(0.1,) * 4)
    fit: Any = Fit(
        effects=(refined,), values={}, moved=np.array([3.0]), log_evidence=0.0, scatter=1.0, columns=(columns,)
    )  # fmt: skip
    problem: Any = SimpleNamespace(weight=np.ones(5))
    moved, sizes = _mirrored(problem, fit)
    assert sizes == [pytest.approx((0.2, 0.6, 0.0, -0.3), abs=1e-3)]
    gone = 1.2 / payload.scale[1]
    assert moved == pytest.approx([3.0 - 0.4 * gone], rel=1e-3)
    there = np.array([moved[0], 0.2, *(s / d for s, d in zip(sizes[0][1:], payload.scale[1:], strict=True))])
    here = np.array([3.0, 0.2, *(s / d for s, d in zip(refined.sizes[1:], payload.scale[1:], strict=True))])
    assert (columns @ (there - here))[:4] == pytest.approx(np.zeros(4), abs=0.2)


@pytest.mark.parametrize(
    ("key", "may"),
    [
        (("vehicle", "Q_r"), True),
        (("own", "thrust", 3), True),
        (("shared", "thrust"), False),  # what all thrusters share is no part that fails
        (("tilt", 0, 1), False),
    ],
)
def test_a_number_of_one_part_that_is_far_off_may_stand_for_an_effect(key: tuple[Any, ...], may: bool) -> None:
    free = {("vehicle", "mass"): 1.0, key: 1.0}
    for off, expected in ((0.9 * rules.SHIFTED, False), (-1.1 * rules.SHIFTED, may)):
        stage: Any = SimpleNamespace(moved=np.array([0.5, off]))
        assert may_stand_for_more(stage, free) is expected
