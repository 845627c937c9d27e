"""The picture of the effects: each one moves what it acts on, and nothing else."""

import numpy as np
import pytest

from thruster_model.effect_signatures_io import signatures, typical_sizes
from thruster_model.effects.effect import size_problems
from thruster_model.effects.stages import LIBRARY


@pytest.fixture(scope="module")
def found():
    return signatures()[1]


def test_each_effect_of_the_library_has_its_row_and_a_size_in_its_range(found):
    assert set(found) == set(LIBRARY)
    assert not [p for e in LIBRARY.values() for p in size_problems(e.id, e.parameters, typical_sizes(e))]


def test_each_effect_moves_something(found):
    still = [name for name, signals in found.items() if max(np.abs(change).max() for change in signals.values()) < 1e-4]
    assert still == []


@pytest.mark.parametrize(
    ("effect", "moved"),
    [("tach_lag", {"speed"}), ("flow_bias", {"axial", "ambient"}), ("load_cell_scale", {"thrust", "torque"})],
)
def test_an_effect_of_a_sensor_moves_what_it_reads_alone(found, effect, moved):
    assert {signal for signal, change in found[effect].items() if np.abs(change).max() > 0.0} == moved


def test_a_loss_of_thrust_takes_its_share_and_leaves_the_rotor(found):
    loss = found["thrust_loss"]
    assert np.abs(loss["speed"]).max() < 1e-6 < 10.0 < np.abs(loss["thrust"]).max()
