import pytest

from thruster_control.law_changes import HAND_OVER_RATE, changed_law, handing_over
from thruster_control.settings import NO_TABLE, FlowLaw, Gains, Limits, TableLaw, ThrustLaw


def test_a_number_is_changed_wherever_it_stands_in_the_law() -> None:
    law = changed_law(FlowLaw(), {"k_P": 7.0, "u_max": 2.0, "as_printed": 1})
    assert law == FlowLaw(Gains(k_P=7.0), Limits(u_max=2.0), 1)
    assert changed_law(ThrustLaw(), {"k_P": 7.0, "feed_forward": 0.5}) == ThrustLaw(k_P=7.0, feed_forward=0.5)


def test_no_change_is_the_same_law() -> None:
    assert changed_law(FlowLaw(), {}) == FlowLaw()


def test_all_numbers_that_a_law_does_not_have_are_refused_at_once() -> None:
    with pytest.raises(ValueError, match="k_P: expected a number of TableLaw; it has none such; feed_forward: "):
        changed_law(TableLaw(NO_TABLE), {"k_P": 7.0, "u_max": 2.0, "feed_forward": 0.5})


def test_while_a_law_is_handed_over_the_throttle_moves_slowly_and_never_faster_than_its_own_rate() -> None:
    assert handing_over(FlowLaw()).limits == Limits(u_dot_max=HAND_OVER_RATE)
    slow = FlowLaw(limits=Limits(u_dot_max=1.0))
    assert handing_over(slow) == slow
