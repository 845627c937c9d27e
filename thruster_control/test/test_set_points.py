import pytest

from thruster_control.references import ramp, sine
from thruster_control.set_points import SetPoint

SECOND = 1_000_000_000


def at(point: SetPoint, *seconds: float) -> list[float]:
    return [point.thrust(round(s * SECOND)) for s in seconds]


def test_the_rigs_references_begin_after_the_delay_and_end_in_no_thrust() -> None:
    step = SetPoint(kind="step", start_delay=2.0)
    assert at(step, 0.0, 1.999, 2.0, 6.999, 7.0, 11.999, 12.0, 100.0) == [0.0, 0.0, -10.0, -10.0, 10.0, 10.0, 0.0, 0.0]
    assert at(SetPoint(kind="sine"), 3.0) == [float(sine(3.0))]
    assert at(SetPoint(kind="triangle"), 1.0) == at(SetPoint(kind="ramp"), 1.0) == [float(ramp(1.0))] == [-5.0]


def test_a_set_point_repeats_as_often_as_asked_or_without_end() -> None:
    twice, endless = (SetPoint(kind="step", repeats=repeats) for repeats in (2, 0))
    assert at(twice, 12.0, 19.0, 20.0) == [-10.0, 10.0, 0.0]
    assert at(endless, 1e6 + 2.0) == [-10.0]


def test_a_constant_lasts_a_run_or_without_end() -> None:
    assert at(SetPoint(kind="constant", level=4.0), 0.0, 9.9, 10.0) == [4.0, 4.0, 0.0]
    assert at(SetPoint(kind="constant", level=4.0, repeats=0), 1e6) == [4.0]


@pytest.mark.parametrize("wrong", [{"kind": "square"}, {"start_delay": -1.0}, {"repeats": -1}, {"level": float("nan")}])
def test_a_set_point_that_is_none_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="expected"):
        SetPoint(**{"kind": "constant", **wrong})  # type: ignore[arg-type]
