"""The T200's measured curves, where its maker's data are at hand; they are not part of the project."""

from pathlib import Path

import numpy as np
import pytest
import scipy.optimize

from thruster_model.force_table_map_io import read_column_map
from thruster_model.force_table_quality import drops, left_out, monotone
from thruster_model.force_table_sheets_io import read_force_table

T200_MAP = Path(__file__).resolve().parents[1] / "config/t200_columns.yaml"


@pytest.fixture(scope="module")
def t200(t200_data):
    """The T200's table, all voltages."""
    return read_force_table(next(t200_data.glob("*.xlsx")), read_column_map(T200_MAP))


def test_the_t200_has_the_zero_bands_and_the_largest_forces_that_its_maker_states(t200):
    low, high = t200.zero_band([10.0, 20.0])
    assert (low.tolist(), high.tolist()) == ([1460.0, 1476.0], [1540.0, 1528.0])
    reverse, forward = t200.largest_forces(16.0)
    assert (float(forward), float(reverse)) == pytest.approx((51.4, -39.9), abs=0.05)


def test_the_t200_at_16_volts_is_the_same_in_csv_within_its_rounding(t200, t200_data):
    single = read_force_table(next(t200_data.glob("*.csv")), read_column_map(T200_MAP))
    np.testing.assert_array_equal(single.command, t200.command)
    np.testing.assert_allclose(single.force[0], t200.at_supply(16.0).force[0], atol=0.0051 * 9.80665)


def test_the_t200_is_interpolated_to_half_a_newton_and_inverted_in_spite_of_its_dips(t200):
    assert [m.supply for m in left_out(t200)] == [12.0, 14.0, 16.0, 18.0]
    assert all(0.05 < m.rmse < 0.6 for m in left_out(t200))
    assert len(drops(t200)) == 5
    force, supply = np.linspace(-22.0, 28.0, 501)[:, None], np.linspace(10.0, 20.0, 41)
    np.testing.assert_allclose(t200.force_at(t200.command_for(force, supply), supply) - force, 0.0, atol=1e-9)


def test_the_t200_made_monotone_moves_by_less_than_the_dips(t200):
    smooth = monotone(t200)
    assert drops(smooth) == ()
    worst = max(d.force - d.next_force for d in drops(t200))
    assert 0.0 < np.max(np.abs(smooth.force - t200.force)) <= worst
    isotonic_regression = getattr(scipy.optimize, "isotonic_regression", None)
    if isotonic_regression is None:
        pytest.skip("scipy below 1.12 has no isotonic regression to compare with")
    for row, other in zip(t200.force, smooth.force, strict=True):
        np.testing.assert_allclose(isotonic_regression(row).x, other, atol=1e-12)


def test_the_t200_turns_backwards_in_reverse(t200):
    assert float(t200.value("speed", 1100.0, 16.0)) == pytest.approx(-3464.7 * np.pi / 30.0, abs=0.1)
    assert np.all(t200.speed[:, t200.command < 1400.0] < 0.0)
