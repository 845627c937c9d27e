"""What the report of a vehicle shows."""

import numpy as np
import pytest

from gap_diagnosis.vehicle.report_io import _percent, picture
from thruster_model.vehicle_set_io import load_vehicle_set


def test_a_suspected_thruster_is_not_hidden_by_another_at_its_place() -> None:
    vehicle, hidden = load_vehicle_set("bluerov2_heavy"), 0
    for i in range(len(vehicle.layout)):
        effect = {"id": "thrust_loss", "thruster": i, "other": None, "axis": None, "sensor": None}
        figure = picture(vehicle, {"effects": [effect]}).figure
        drawn = [(np.array([t.x[0], t.y[0]]), t.marker.color) for t in figure.data]
        (colour,) = {c for _, c in drawn if sum(c == other for _, other in drawn) == 2}  # from above and from the side
        for place in (at for at, c in drawn if c == colour):
            there = [c for at, c in drawn if np.allclose(at, place, atol=0.01)]
            assert there[-1] == colour
            hidden += len(there) - 1
    assert hidden > 4  # seen from the side the vehicle has pairs


@pytest.mark.parametrize(("effect", "marked"), [("ram_drag", 16), ("thrust_loss", 16), ("payload", 0)])
def test_all_thrusters_are_marked_where_an_effect_is_of_all(effect: str, marked: int) -> None:
    said = {"id": effect, "thruster": None, "other": None, "axis": None, "sensor": None}
    figures = [picture(load_vehicle_set("bluerov2_heavy"), {"effects": e}).figure for e in ([], [said])]
    calm, colours = figures[0].data[0].marker.color, [t.marker.color for t in figures[1].data]
    assert sum(colour != calm for colour in colours) == marked


def test_a_share_of_hardly_anything_has_no_sign() -> None:
    assert [_percent(share) for share in (-0.001, 0.004, -0.014)] == ["0 %", "0 %", "-1 %"]
