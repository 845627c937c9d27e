"""Long recordings are thinned openly: lively stretches of all of it, each a recording of its own."""

import numpy as np
import pytest

from gap_diagnosis.cli_diagnose import main
from gap_diagnosis.preparing import recording_of
from gap_diagnosis.recording import Recording
from gap_diagnosis.stretches import LENGTH, stretches_of

LIVELY = ((40.0, 55.0), (130.0, 145.0))


def recorded(duration: float, hold: str | None = "previous", jitter: float = 0.0) -> Recording:
    """Return a recording whose throttle moves in two stretches alone, its speed a function of the time."""
    time = np.arange(0.0, duration, 0.04)
    lively = np.any([(time > first) & (time < last) for first, last in LIVELY], axis=0)
    u = np.where(lively, np.sign(np.sin(time)), 0.5)
    rng = np.random.default_rng(0)
    speed = 100.0 + time + 0.5 * rng.standard_normal(time.size)
    stamps = np.sort(time + jitter * rng.standard_normal(time.size))
    return recording_of("dive", (time, u), {"speed": (stamps, speed)}, hold=hold)


def test_what_is_short_enough_stays_as_it_is() -> None:
    recordings = [recorded(60.0), recorded(60.0)]
    assert stretches_of(recordings, 125.0) == recordings
    many = [recorded(12.0)] * 30  # each no longer than a stretch
    assert stretches_of(many) == many


def test_lively_stretches_are_found_all_over_and_hold_the_samples_of_their_time() -> None:
    whole = recorded(180.0)
    found = stretches_of([whole], 2.0 * LENGTH)
    begins = [float(each.name.split(" from ")[1].rstrip(" s")) for each in found]
    assert begins == pytest.approx([first for first, _ in LIVELY], abs=1.0)
    for each, begin in zip(found, begins, strict=True):
        assert each.experiment.duration == pytest.approx(LENGTH)
        speed = each.experiment.measurements["speed"]
        assert speed.time[0] >= 0.0 and speed.time[-1] <= LENGTH
        assert speed.values == pytest.approx(100.0 + begin + speed.time, abs=3.0)
        assert each.start_std, "a stretch begins in motion"
    (told,) = found[0].experiment.warnings
    assert told.startswith("of 180 s recorded, the 30 s in which the throttle moves most are used, in 2 stretches")
    assert not found[1].experiment.warnings


def test_a_short_run_beside_a_long_one_is_kept_whole() -> None:
    short, *others = stretches_of([recorded(10.0), recorded(600.0)], 60.0)
    assert short.experiment.duration == pytest.approx(10.0, abs=0.1) and len(others) == 3


def test_what_is_kept_beside_is_cut_alike() -> None:
    found = stretches_of([recorded(180.0, hold=None, jitter=0.004)], 2.0 * LENGTH)
    for each in found:
        for other in (each.regular, each.straight):
            assert other is not None and other.name == each.name
            assert other.experiment.duration == pytest.approx(LENGTH)
            read = [way.experiment.measurements["speed"].values for way in (each, other)]
            np.testing.assert_array_equal(*read)


@pytest.mark.parametrize("given", ["5", "-1", "nan"])
def test_less_than_a_stretch_is_refused_before_anything_is_read(given: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["nowhere", "--set", "hl", "--longest", given]) == 1
    assert f"--longest: expected 15 s or more; found {given}" in capsys.readouterr().err
