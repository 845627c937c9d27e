"""Long dives, thinned."""

from collections.abc import Sequence

import numpy as np
import pytest

from gap_diagnosis.vehicle.instants import shifted
from gap_diagnosis.vehicle.log import VehicleLog, held
from gap_diagnosis.vehicle.rules import LONGEST, STRETCH, THINNED
from gap_diagnosis.vehicle.stretches import stretches_of
from rov_sim.vehicle.effects.active import ActiveVehicleEffect

PERIOD = 0.1


def dive(seconds: float, driven: Sequence[tuple[int, float, float]] = (), thrusters: int = 2) -> VehicleLog:
    """Return a dive whose thrusters rest but where they are driven, (thruster, from, to [s]), of square waves."""
    count = round(seconds / PERIOD)
    time, throttles = PERIOD * np.arange(count), np.zeros((count, thrusters))
    for i, first, last in driven:
        throttles[:, i] += ((time >= first) & (time < last)) * np.sign(np.sin(2.0 * time))
    nothing = np.full((count, thrusters), np.nan)
    return VehicleLog(
        name="dive", period=PERIOD, commands=held(throttles), attitude=np.full((count, 4), np.nan),
        told=np.full((count, 13), np.nan), speeds=nothing, signed=True, battery=np.full((count, 2), np.nan),
        noise=np.ones(13), speed_noise=np.ones(thrusters), battery_noise=np.ones(2),
        lateness=np.zeros((count, 5 + thrusters)),
    )  # fmt: skip


def test_what_is_not_long_stays_as_it_is() -> None:
    logs = [dive(LONGEST / 2), dive(LONGEST / 2)]
    found, told = stretches_of(logs)
    assert found == logs and told == []


def test_stretches_are_where_each_thruster_moves_by_itself() -> None:
    driven = [(0, 100.0, 300.0), (1, 600.0, 625.0)]
    found, told = stretches_of([dive(900.0, driven)], 60.0)
    assert [log.duration for log in found] == [STRETCH, STRETCH]
    first, second = (PERIOD * log.cut for log in found)
    assert 80.0 <= first <= 270.0 and 580.0 <= second <= 600.0
    assert found[1].name == f"dive from {second:.0f} s"
    assert "Of 900 s recorded, 60 s are used" in told[0] and "--longest 900 uses all" in told[0]


def test_two_that_are_always_driven_alike_are_less_than_two_that_are_not() -> None:
    alike, apart = [(0, 0.0, 200.0), (1, 0.0, 200.0)], [(0, 400.0, 412.0), (1, 412.0, 424.0)]
    found, _ = stretches_of([dive(900.0, [*alike, *apart])], 2.0 * STRETCH)
    assert any(395.0 <= PERIOD * log.cut <= 400.0 for log in found)


def test_each_dive_is_used_before_another_stretch_of_any_and_none_twice() -> None:
    logs = [dive(400.0, [(0, 0.0, 400.0)]), dive(20.0), dive(200.0)]
    found, _ = stretches_of(logs)
    assert len(found) == round(THINNED / STRETCH)
    assert {log.count for log in found} == {round(STRETCH / PERIOD), logs[1].count}
    begins = np.sort([PERIOD * log.cut for log in found if log.name.startswith("dive from") and log.throttles.any()])
    assert np.all(np.diff(begins) >= STRETCH)


def test_less_than_a_stretch_is_refused() -> None:
    with pytest.raises(ValueError, match="--longest: expected 30 s or more; found 5"):
        stretches_of([dive(900.0)], 5.0)


def test_a_clock_that_drifts_is_as_late_in_a_stretch_as_in_the_whole_dive() -> None:
    drift = ActiveVehicleEffect(id="clock_drift", sizes={"rate": 1e-3})
    whole = dive(900.0, [(0, 0.0, 900.0)])
    late = shifted(whole, {}, [drift]).part(3000, 3300)
    stretch = shifted(whole.part(3000, 3300), {}, [drift])
    assert np.array_equal(stretch.lateness, late.lateness)
    assert np.array_equal(stretch.commands[50:], late.commands[50:])
