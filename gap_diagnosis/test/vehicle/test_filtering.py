"""Commands that act later than they are stamped."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gap_diagnosis.vehicle import filtering
from gap_diagnosis.vehicle.filtering import _shifted


def test_a_command_that_acts_later_gives_each_period_a_share_of_the_one_before(monkeypatch: pytest.MonkeyPatch) -> None:
    log: Any = SimpleNamespace(period=0.04, throttles=np.array([[0.0], [4.0], [4.0], [0.0]]))
    monkeypatch.setattr(filtering, "replace", lambda log, throttles: throttles)
    # by hand: 10 ms of 40 are still the period before, or already the one after
    assert _shifted(log, {("late",): 0.01})[:, 0] == pytest.approx([0.0, 3.0, 4.0, 1.0])
    assert _shifted(log, {("late",): -0.01})[:, 0] == pytest.approx([1.0, 4.0, 3.0, 0.0])
    assert _shifted(log, {}) is log
