"""What only scatters: which samples are left out, in every recording of the same sensor."""

import numpy as np
import pytest
from generated import campaign

from gap_diagnosis.preparing import recording_of
from gap_diagnosis.scatter import found_in_logs, masks_of, scattered_before_sorting


def test_a_blind_tachometer_is_masked_also_where_a_recording_by_itself_does_not_show_it():
    _, recordings = campaign({"tach_dropout": {"threshold": 13.0}}, runs=4, duration=12.0, seed=4)
    assert "tach_dropout" in [found.effect for found in found_in_logs(recordings)]
    assert any(recording.log.hole["speed"] == 0.0 for recording in recordings)
    masks = masks_of(recordings)
    for index, recording in enumerate(recordings):
        values = recording.experiment.measurements["speed"].values
        assert np.all(masks[index, "speed"][values == 0.0])


def test_readings_about_the_threshold_are_left_out_by_their_neighbours_not_by_themselves():
    _, recordings = campaign({"tach_dropout": {"threshold": 13.0}}, seed=4)
    for index, recording in enumerate(recordings):
        values = recording.experiment.measurements["speed"].values
        kept = ~masks_of(recordings)[index, "speed"]
        assert np.min(np.abs(values[kept])) > 12.0
        slow = np.abs(values[kept]) < 16.0
        assert np.mean(slow) < 0.05


def test_scatter_is_known_from_before_the_stamps_were_put_in_order_by_the_rate_at_which_they_came():
    at = 0.01 * np.arange(4000)
    stamps = np.sort(at + 0.01 * np.random.default_rng(1).standard_normal(at.size))
    log = recording_of("fast", (at, np.sin(at)), {"speed": (stamps, np.sin(at))}).log
    assert log.period["speed"] == pytest.approx(0.01, rel=1e-3)
    assert scattered_before_sorting(log.scatter["speed"], log.period["speed"]) == pytest.approx(0.01, rel=0.05)


def test_a_sound_tachometer_loses_nothing():
    _, recordings = campaign({}, seed=4)
    assert not masks_of(recordings)
    assert not found_in_logs(recordings)
