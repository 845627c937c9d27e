"""The set points: points by hand, and the rig's own recordings."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

from thruster_control.references import DURATION, REFERENCES, Window, ramp, scored, sine, step

PERIOD = 0.04  # s, of the recordings


def test_the_step_goes_from_minus_to_plus_10_newton_at_5_seconds() -> None:
    assert step([0.0, 4.999, 5.0, 10.0]).tolist() == [-10.0, -10.0, 10.0, 10.0]


def test_the_sine_starts_at_0_and_turns_at_minus_10_newton() -> None:
    quarter = np.pi / 2.0 / 1.88
    np.testing.assert_allclose(sine([0.0, quarter, 2 * quarter, 4 * quarter]), [0.0, -5.0, -10.0, 0.0], atol=1e-12)


def test_the_ramp_passes_its_corners_and_the_middles_between_them() -> None:
    times = [0.0, 1.0, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0, 7.5, 8.0, 9.0, 10.0]
    forces = [0.0, -5.0, -10.0, -10.0, -10.0, -5.0, 0.0, 5.0, 10.0, 10.0, 10.0, 5.0, 0.0]
    np.testing.assert_allclose(ramp(times), forces, atol=1e-12)
    assert ramp([-1.0, 11.0]).tolist() == [0.0, 0.0]


@pytest.mark.parametrize("name", REFERENCES)
def test_a_batch_equals_its_scalars_and_an_unknown_time_has_no_set_point(name: str) -> None:
    thrust = REFERENCES[name].thrust
    times = np.linspace(0.0, DURATION, 24).reshape(4, 6)
    assert thrust(times).shape == (4, 6)
    assert thrust(times).ravel().tolist() == [float(thrust(t)) for t in times.ravel()]
    assert np.isnan(thrust([np.nan])).all()


def test_scores_leave_out_the_published_windows_and_nothing_else() -> None:
    assert {name: each.left_out for name, each in REFERENCES.items()} == {
        "step": ((0.0, 1.2), (5.0, 6.2)),
        "sine": (),
        "ramp": ((0.0, 0.6), (4.8, 6.0)),
    }
    windows = (Window(0.0, 1.2), Window(5.0, 6.2))
    times = [-0.1, 0.0, 1.19, 1.2, 4.99, 5.0, 6.19, 6.2, 10.0, 10.1, np.nan]
    kept = [False, False, False, True, True, False, False, True, True, False, False]
    assert scored(times, windows).tolist() == kept
    assert scored([0.0, 10.0], ()).all()


@pytest.mark.parametrize(("name", "tolerance"), [("step", 0.0), ("sine", 1e-12), ("ramp", 10.0 / 2.0 * PERIOD + 1e-12)])
def test_the_rig_was_given_these_set_points(thruster_bench_data: Path, name: str, tolerance: float) -> None:
    files = sorted((thruster_bench_data / "closed_loop").glob(f"*{name.capitalize()}.mat"))
    if not files:
        pytest.skip(f"no recordings of the {name} in {thruster_bench_data / 'closed_loop'}")
    for file in files:
        recorded = loadmat(file)["Td"].ravel().astype(float)
        expected = REFERENCES[name].thrust(np.arange(recorded.size) / 25.0)
        np.testing.assert_allclose(recorded, expected, rtol=0.0, atol=tolerance, err_msg=file.name)
