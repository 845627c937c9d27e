"""One step of each law: by hand, compiled against plain, its limits, and the rig's recordings."""

import math

import numba
import numpy as np
import pytest
from scipy.io import loadmat

from thruster_control.dead_zone_compensation import compensated_throttle
from thruster_control.inner_loop import AT_REST, Memory, Status, compiled_step, inner_loop_step
from thruster_control.settings import (
    BENCH_GAINS,
    FlowLaw,
    ForceTableLaw,
    Gains,
    Limits,
    RateForm,
    SimplifiedLaw,
    SteadyFlowLaw,
    TableLaw,
    ThrustLaw,
)
from thruster_model.parameter_set_io import load_parameter_set

P = {
    name: load_parameter_set(name).coefficients
    for name in ("simplified", "hl", "hl_bench", "hq", "kim_chung", "force_table")
}
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
FREE = Limits(u_max=1e6, u_dot_max=1e9)


def step(memory=RUNNING, T_d=5.0, n=68.0, v=0.1, U=0.12, valid=True, dt=DT, law="hl", **more):  # type: ignore[no-untyped-def]
    settings, p = LAWS[law] if isinstance(law, str) else law
    return inner_loop_step(memory, T_d, n, v, U, valid, dt, settings, p, **more)


def test_4_24_to_4_26_by_hand() -> None:
    """Without a rate; n_d = 60 at v = 0 of the HL set by T_d = c_n 60^2."""
    p, gains = P["hl"], Gains(rate_form=int(RateForm.NONE))
    memory, out = step(RUNNING, p.c_T2 * 3600.0, 58.0, 0.0, law=(FlowLaw(gains, FREE), p))
    assert out.n_d == pytest.approx(60.0)
    alpha = 13.66 * 60.0 + 1856.0 * 2.804e-6 * 3600.0 - 5.0 * (58.0 - 60.0) - 10.0 * 0.5
    assert out.alpha == pytest.approx(alpha)
    assert out.u == pytest.approx(alpha / 737.2 + 0.86)
    assert memory.sigma == pytest.approx(0.5 + 0.04 * (58.0 - 60.0))


def test_the_filtered_rate_by_hand_and_a_jump_is_cut() -> None:
    p = P["hl"]
    T_d = p.c_T2 * 71.0**2
    slow, _ = step(RUNNING, T_d, 70.0, 0.0)
    assert slow.n_d_rate == pytest.approx(20.0 + (1.0 - math.exp(-0.4)) * (1.0 / 0.04 - 20.0))
    jump, _ = step(RUNNING, p.c_T2 * 110.0**2, 70.0, 0.0)
    assert jump.n_d_rate == pytest.approx(20.0 + (1.0 - math.exp(-0.4)) * (400.0 - 20.0))
    first, _ = step(RUNNING._replace(n_d=math.nan, n_d_rate=0.0), T_d, 70.0, 0.0)
    assert first.n_d_rate == 0.0


def test_the_bench_s_rate_is_a_gain_of_25_on_top_of_k_p() -> None:
    p = P["hl"]
    alphas = []
    for gains in (Gains(rate_form=int(RateForm.NONE), k_P=30.0), BENCH_GAINS):
        alphas.append(step(law=(FlowLaw(gains, FREE), p))[1].alpha)
    assert alphas[0] == pytest.approx(alphas[1], rel=1e-12)


def test_with_the_measured_speed_in_the_feed_forward_it_is_3_12() -> None:
    p = P["simplified"]
    law = (SimplifiedLaw(Gains(k_P=20.0, k_I=0.0, rate_form=int(RateForm.NONE), on_estimate=1), FREE), p)
    out = step(T_d=5.0, n=-30.0, law=law)[1]
    assert out.u == pytest.approx(float(compensated_throttle(-30.0, out.n_d, 0.0, 20.0, p)), rel=1e-12)


def test_the_table_jumps_over_the_dead_zone_and_keeps_its_ends() -> None:
    wide = (TableLaw(TABLE, Limits(u_max=5.0, u_dot_max=1e9, idle_thrust=0.0)), P["simplified"])
    forces = [-20.0, -8.0, -4.0, -2.0, -1e-9, 1e-9, 2.5, 5.0, 9.0, 20.0]
    expected = [-3.0, -2.5, -2.0, -1.4, -0.8, 0.9, 1.45, 2.0, 2.5, 3.0]
    wide = (wide[0], wide[1]._replace(u_dot_max=1e9))
    assert [step(T_d=T, law=wide)[1].u for T in forces] == pytest.approx(expected, abs=1e-6)
    assert step(T_d=9.0, law=wide)[1].n_d == pytest.approx(87.0)


def test_the_thrust_loop_follows_the_load_cell_and_else_the_map() -> None:
    settings, p = ThrustLaw(limits=FREE), P["hl"]
    estimated = step(T_d=5.0, n=68.0, v=0.1, law=(settings, p))[0].sigma - 0.5
    model = p.c_T2 * 68.0**2 - p.c_nv_T * 68.0 * 0.1
    assert estimated == pytest.approx(0.04 * (model - 5.0))
    assert step(T_d=5.0, law=(settings, p), T=4.0)[0].sigma - 0.5 == pytest.approx(0.04 * -1.0)
    assert step(T_d=5.0, n=math.nan, valid=False, law=(settings, p), T=4.0)[1].status == Status.RUNNING


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("T_d", [-6.0, 0.0, 5.0, math.nan])
@pytest.mark.parametrize("n", [68.0, math.nan])
def test_compiled_and_plain_steps_agree(law: str, T_d: float, n: float) -> None:
    plain_memory, plain = step(T_d=T_d, n=n, law=law)
    memory, out = compiled_step(RUNNING, T_d, n, 0.1, 0.12, True, DT, *LAWS[law], math.nan, 0.0)
    np.testing.assert_allclose(memory, plain_memory, rtol=1e-13)
    np.testing.assert_allclose(out, plain, rtol=1e-13)


@numba.njit
def _loop(memory, T_d, settings, p):  # type: ignore[no-untyped-def]
    total = 0.0
    for wanted in T_d:
        memory, out = inner_loop_step(memory, wanted, 60.0, 0.1, 0.12, True, 0.04, settings, p)
        total += out.u
    return memory, total


def test_it_is_called_within_a_kernel_with_its_defaults() -> None:
    wanted = np.array([5.0, 5.0, math.nan, 0.0, -3.0])
    memory, total = _loop(AT_REST, wanted, *LAWS["hl"])
    expected, sum_u = AT_REST, 0.0
    for T_d in wanted:
        expected, out = step(expected, T_d, 60.0, law="hl")
        sum_u += out.u
    assert total == pytest.approx(sum_u, rel=1e-13)
    np.testing.assert_allclose(memory, expected, rtol=1e-13)


@numba.njit
def _array_form(alpha):  # type: ignore[no-untyped-def]
    return np.where(alpha < 0.0, alpha, 0.0).item()


def test_a_compiled_step_allocates_nothing() -> None:
    """A choice by `np.where` shows what the search would find."""
    _array_form(1.0)
    assert "NRT_MemInfo_alloc" in next(iter(_array_form.inspect_llvm().values()))
    _loop(AT_REST, np.ones(2), *LAWS["hl"])
    assert all("NRT_MemInfo_alloc" not in code for code in _loop.inspect_llvm().values())


# ---- limits


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("T_d", [-1e9, -30.0, 30.0, 1e9])
def test_throttle_and_rate_stay_within_their_limits(law: str, T_d: float) -> None:
    limits = Limits(u_max=2.0, u_dot_max=20.0)
    settings, p = LAWS[law]
    memory, last = AT_REST, 0.0
    for _ in range(10):
        memory, out = step(memory, T_d, 0.0, 0.0, 0.0, law=(settings._replace(limits=limits), p))
        assert abs(out.u - last) <= 0.8 + 1e-12 and abs(out.u) <= 2.0
        last = out.u
    assert abs(last) == 2.0


def test_the_slower_of_the_two_rates_counts() -> None:
    settings, p = LAWS["simplified"]
    assert step(AT_REST._replace(age=0.0), 20.0, law=(settings, p._replace(u_dot_max=10.0)))[1].u == pytest.approx(0.4)


def test_a_throttle_within_its_limits_is_what_is_wanted_to_the_bit_so_that_rounding_is_no_limit() -> None:
    rng = np.random.default_rng(1)
    for before in rng.uniform(-2.0, 2.0, 200):
        memory, out = step(RUNNING._replace(u=float(before), side=0.0), float(rng.uniform(1.0, 8.0)))
        if abs(out.u - before) < 3.9:  # V in a period, at 100 V/s
            assert out.status == Status.RUNNING and memory.sigma != RUNNING.sigma


# ---- the rig's recordings


def test_the_printed_form_gives_the_speeds_that_the_rig_recorded(thruster_bench_data) -> None:  # type: ignore[no-untyped-def]
    files = sorted((thruster_bench_data / "closed_loop").glob("CL2state*.mat"))
    if not files:
        pytest.skip(f"no output-feedback recordings in {thruster_bench_data / 'closed_loop'}")
    law = (FlowLaw(BENCH_GAINS, FREE._replace(idle_thrust=-1.0), as_printed=1), P["hl_bench"])
    for file in files:
        data = loadmat(file)
        T_d, n_d, v = (data[name].ravel().astype(float) for name in ("Td", "nd", "vhat"))
        ours = np.array([step(AT_REST, float(a), 0.0, float(b), law=law)[1].n_d for a, b in zip(T_d, v, strict=False)])
        np.testing.assert_allclose(ours, n_d, rtol=1e-5, atol=1e-5, err_msg=file.name)
