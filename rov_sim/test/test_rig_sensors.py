"""The bench's converters count as its protocol says, and only the spikes depend on their share."""

import numpy as np
import pytest

from bench_driver import text_protocol
from bench_driver.converter import code_from_count, code_volts
from rov_sim.rig_sensors import Rig, disturbances, flow_read, speed_read, throttle_acting


@pytest.mark.parametrize(
    ("read", "value", "expected"),
    [
        (speed_read, -100.0, 410 * 49.9723 * 5 / 1024),  # 409.83 counts
        (speed_read, 1000.0, 1023 * 49.9723 * 5 / 1024),
        (speed_read, 0.1, 0.0),
    ],
)
def test_a_speed_becomes_the_counts_computed_by_hand(read, value: float, expected: float) -> None:  # type: ignore[no-untyped-def]
    assert read(value, 0.0, True) == pytest.approx(expected, abs=1e-12)


def test_a_flow_and_a_throttle_become_the_counts_computed_by_hand() -> None:
    assert flow_read(-0.06, 0.0, 0.0, True) == pytest.approx(0.3 - 614 * 0.3 / 2.5 * 5 / 1024, abs=1e-12)  # 614.4
    assert flow_read(0.9, 0.0, 0.0, True) == pytest.approx(0.3)
    assert flow_read(-0.5, 0.0, 0.5, False) == -0.75
    assert throttle_acting(0.0, True) == pytest.approx(5 - 128 * 10 / 255, abs=1e-12)  # 127.5: away from zero
    assert throttle_acting(-3.0, True) == pytest.approx(-3.0, abs=1e-12)
    assert throttle_acting(1.234, False) == 1.234


def test_the_readings_are_those_of_the_serial_protocol() -> None:
    for x in np.random.default_rng(3).uniform(-1.0, 1.0, 500):
        speed, flow, u = 120.0 * float(x), 0.29 * float(x), 3.0 * float(x)
        count = text_protocol.count_from_speed(speed)
        assert speed_read(speed, 0.0, True) == pytest.approx(text_protocol.speed_from_count(count), abs=1e-9)
        count = text_protocol.count_from_flow(flow)
        assert flow_read(flow, 0.0, 0.0, True) == pytest.approx(text_protocol.flow_from_count(count), abs=1e-9)
        volts = code_volts(code_from_count(text_protocol.throttle_count(u)))
        assert throttle_acting(u, True) == pytest.approx(volts, abs=1e-9)


def test_the_share_of_spikes_changes_nothing_but_the_spikes() -> None:
    quiet, spiky = (
        disturbances(Rig(spike_share=share), 20_000, 0.04, np.random.default_rng(1)) for share in (0.0, 0.05)
    )
    for name in ("speed", "eddies", "load"):
        np.testing.assert_array_equal(getattr(quiet, name), getattr(spiky, name))
    hit = quiet.flow != spiky.flow
    assert np.mean(hit) == pytest.approx(0.05, abs=5 * (0.05 * 0.95 / 20_000) ** 0.5)
    assert np.std((spiky.flow - quiet.flow)[hit]) == pytest.approx(Rig().spike_size, rel=0.1)
    assert np.std(quiet.eddies) == pytest.approx(Rig().turbulence, rel=0.05)
    assert np.corrcoef(quiet.eddies[1:], quiet.eddies[:-1])[0, 1] == pytest.approx(np.exp(-1.0), abs=0.05)


def test_a_rig_that_cannot_be_is_refused_with_all_that_is_wrong() -> None:
    with pytest.raises(ValueError, match=r"speed_noise: .* found -1.*spike_share: .* found 2.*memory"):
        Rig(speed_noise=-1.0, spike_share=2.0, memory=0.0)
