"""What a step answers to inputs that fail, to no wanted thrust, and which settings are refused."""

import math

import numpy as np
import pytest

from thruster_control.inner_loop import AT_REST, Memory, Status, inner_loop_step
from thruster_control.settings import (
    BENCH_GAINS,
    FlowLaw,
    ForceTableLaw,
    Gains,
    Limits,
    SimplifiedLaw,
    SteadyFlowLaw,
    TableLaw,
    ThrustLaw,
    checked,
)  # fmt: skip
from thruster_model.parameter_set_io import load_parameter_set

P = {name: load_parameter_set(name).coefficients for name in ("simplified", "hl", "hq", "kim_chung", "force_table")}
TABLE = np.array(
    [[-3.0, -2.0, -0.8, 0.9, 2.0, 3.0], [-12.0, -4.0, 0.0, 0.0, 5.0, 13.0], [-110.0, -60.0, 0.0, 0.0, 62.0, 112.0]]
)
LAWS = {
    "table": (TableLaw(TABLE), P["simplified"]),
    "table over speed": (TableLaw(TABLE, by_thrust=0), P["simplified"]),
    "simplified": (SimplifiedLaw(), P["simplified"]),
    "hl": (FlowLaw(), P["hl"]),
    "hq": (FlowLaw(), P["hq"]),
    "printed": (FlowLaw(BENCH_GAINS, as_printed=1), P["hq"]),
    "steady flow": (SteadyFlowLaw(), P["kim_chung"]),
    "thrust": (ThrustLaw(), P["hl"]),
    "force table": (ForceTableLaw(), P["force_table"]),
}
DT = 0.04
RUNNING = Memory(0.5, 70.0, 20.0, 2.0, 1.0, 0.0, 0.1, 0.12)


def step(memory=RUNNING, T_d=5.0, n=68.0, v=0.1, U=0.12, valid=True, dt=DT, law="hl", **more):  # type: ignore[no-untyped-def]
    settings, p = LAWS[law] if isinstance(law, str) else law
    return inner_loop_step(memory, T_d, n, v, U, valid, dt, settings, p, **more)


# ---- failing inputs


def test_over_a_gap_between_steps_nothing_is_integrated() -> None:
    assert step(dt=0.4)[0].sigma != 0.5
    assert step(dt=0.6)[0].sigma == 0.5


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("dt", [math.nan, 0.0, -0.04, math.inf])
def test_a_period_that_is_none_gives_0_v_and_an_empty_memory(law: str, dt: float) -> None:
    memory, out = step(dt=dt, law=law)
    assert (out.u, out.status) == (0.0, Status.BAD_PERIOD)
    assert (memory.sigma, memory.u, memory.side) == (0.0, 0.0, 0.0) and math.isnan(memory.n_d)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("T_d", [math.nan, math.inf, -math.inf])
def test_without_a_set_point_the_throttle_runs_down_to_zero_and_stays(law: str, T_d: float) -> None:
    memory, seen = RUNNING, []
    for _ in range(7):
        memory, out = step(memory, T_d, law=law)
        assert out.status == Status.NO_SET_POINT
        seen.append(out.u)
    assert seen == pytest.approx([1.6, 1.2, 0.8, 0.4, 0.0, 0.0, 0.0], abs=1e-12)
    assert abs(memory.sigma) < 0.5


CLOSED = ("simplified", "hl", "steady flow", "thrust")
NEEDS = [("simplified", "n"), ("hl", "n"), ("hl", "v"), ("hq", "v"), ("steady flow", "n"), ("steady flow", "U")]
NEEDS += [("thrust", "n"), ("thrust", "v")]
LOST = [(law, {name: math.nan}) for law, name in NEEDS]
LOST += [(law, {"n": math.inf}) for law in ("simplified", "hl")]
LOST += [(law, lost) for law in CLOSED for lost in ({"valid": False}, {"age": 0.2})]


@pytest.mark.parametrize(("law", "lost"), LOST, ids=str)
def test_a_lost_estimate_holds_the_feed_forward_then_runs_down_and_comes_back(law: str, lost: dict[str, float]) -> None:
    memory, sigma = RUNNING, RUNNING.sigma
    for k in range(1, 13):
        memory, out = step(memory, law=law, **lost)
        assert (out.status, memory.sigma) == (Status.HOLDING, sigma)
        assert memory.age == pytest.approx(k * DT)
        assert 1.5 < out.u < 3.0
    for _ in range(20):
        memory, out = step(memory, law=law, **lost)
        assert out.status == Status.RUN_DOWN
    assert out.u == 0.0
    memory, out = step(memory, law=law)
    assert out.status in (Status.RUNNING, Status.LIMITED) and out.u > 0.5


def test_while_held_the_throttle_still_follows_the_set_point() -> None:
    memory, near = step(T_d=5.0, n=math.nan)
    _, far = step(memory, -5.0, n=math.nan)
    assert near.u > 0.0 > far.u and far.status == Status.HOLDING


@pytest.mark.parametrize("law", CLOSED)
def test_before_the_first_estimate_the_throttle_stays_at_zero(law: str) -> None:
    _, out = step(AT_REST, valid=False, law=law)
    assert (out.u, out.status) == (0.0, Status.RUN_DOWN)


@pytest.mark.parametrize("law", ["table", "table over speed"])
def test_open_loop_needs_no_estimate(law: str) -> None:
    out = step(AT_REST, n=math.nan, v=math.nan, U=math.nan, valid=False, law=law)[1]
    assert out.status == Status.RUNNING and out.u > 1.5


@pytest.mark.parametrize(
    ("law", "unneeded"), [("simplified", "v"), ("simplified", "U"), ("hl", "U"), ("steady flow", "v")]
)
def test_an_estimate_that_the_law_does_not_use_may_be_missing(law: str, unneeded: str) -> None:
    assert step(law=law, **{unneeded: math.nan})[1] == step(law=law)[1]


def test_a_speed_beyond_all_numbers_runs_the_throttle_down() -> None:
    law = (SimplifiedLaw(Gains(on_estimate=1)), P["simplified"])
    with np.errstate(over="ignore"):
        out = step(n=1e200, law=law)[1]
    assert out.status == Status.RUN_DOWN and out.u == pytest.approx(1.6)


# ---- idle


@pytest.mark.parametrize("law", LAWS)
def test_no_wanted_thrust_is_no_throttle_whatever_turns_and_flows(law: str) -> None:
    settings, p = LAWS[law]
    if law == "printed":
        settings = settings._replace(limits=Limits())
    memory, out = step(RUNNING, 0.0, 90.0, 0.3, 0.3, law=(settings, p))
    assert (out.u, out.n_d, out.status) == (0.0, 0.0, Status.IDLE)
    assert memory.sigma == pytest.approx(0.5 * math.exp(-0.04 / 0.5))
    assert memory.side == 0.0


def test_idling_begins_and_ends_at_two_different_thrusts() -> None:
    statuses, memory = [], RUNNING
    for T_d in (0.03, 0.02, 0.03, 0.04, 0.041, 0.03, -0.02, -0.03, -0.05):
        memory, out = step(memory, T_d)
        statuses.append(out.status == Status.IDLE)
    assert statuses == [False, True, True, True, False, False, True, True, False]


# ---- settings


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (SimplifiedLaw(limits=Limits(u_max=-1.0)), "u_max: expected a finite number above 0; found -1.0"),
        (SimplifiedLaw(limits=Limits(longest_hold=math.nan)), "longest_hold: expected a finite number, 0 or more"),
        (FlowLaw(Gains(k_P=-5.0, rate_form=9)), "k_P: expected .*; rate_form: expected one of"),
        (FlowLaw(Gains(rate_form=1, rate_time=0.0)), "rate_time: expected more than 0 s"),
        (ThrustLaw(feed_forward=2.0), "feed_forward: expected a share from 0 to 1; found 2.0"),
        (ThrustLaw(k_I=math.inf), "k_I: expected"),
        (SteadyFlowLaw(limits=Limits(idle_thrust=math.nan)), "idle_thrust: expected"),
        (TableLaw(np.ones((2, 3))), r"table: expected finite numbers of shape \(3, K\)"),
        (TableLaw(np.delete(TABLE, 2, axis=1)), "two neighbouring nodes"),
        (TableLaw(TABLE[:, [0, 1, 2, 3, 5, 4]]), "expected ascending throttle"),
    ],
    ids=lambda x: type(x).__name__ if not isinstance(x, str) else "",
)
def test_settings_that_cannot_be_used_are_refused_with_what_is_wrong(settings, said: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ValueError, match=said):
        checked(settings)


def test_settings_of_every_law_here_pass() -> None:
    assert [checked(settings) for settings, _ in LAWS.values()] == [settings for settings, _ in LAWS.values()]
