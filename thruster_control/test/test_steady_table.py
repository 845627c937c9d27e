"""Lookup tables: by hand, from the rig's steady states, from parameter sets, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat
from scipy.optimize import brentq

from thruster_control.errors import SteadyStatesError, ThrusterControlError
from thruster_control.inner_loop import AT_REST, inner_loop_step
from thruster_control.settings import Limits, TableLaw, checked
from thruster_control.steady_table import dead_zone_edges, force_table, lookup_of_set, lookup_table
from thruster_control.steady_table_io import read_steady_states
from thruster_model.equations.thruster import input_map, rotor_acceleration, thrust, torque
from thruster_model.parameter_set_io import load_parameter_set

U = np.array([1.0, 2.0, 3.0, -3.0, -2.0, -1.0])
T = np.array([0.5, 4.0, 12.0, -11.0, -3.5, -0.4])
N = np.array([10.0, 60.0, 110.0, -105.0, -57.5, -10.0])


def table(**more):  # type: ignore[no-untyped-def]
    return force_table(U, T, N, supply=24.0, source="by hand", **more)


def test_the_edges_are_where_the_speed_s_line_reaches_zero() -> None:
    assert dead_zone_edges(U, N) == pytest.approx((-1.0 + 10.0 / 47.5, 1.0 - 10.0 / 50.0))


def test_the_lookup_by_hand() -> None:
    found = lookup_table(table(edges=(-0.7, 0.8)), 24.0)
    expected = [
        [-3, -2, -1, -0.7, 0.8, 1, 2, 3],
        [-11, -3.5, -0.4, 0, 0, 0.5, 4, 12],
        [-105, -57.5, -10, 0, 0, 10, 60, 110],
    ]
    np.testing.assert_allclose(found, expected)
    checked(TableLaw(found))


def test_repeated_states_are_averaged_and_those_in_the_dead_zone_left_out() -> None:
    u, T_, n = (np.append(a, b) for a, b in ((U, [2.0, 0.3]), (T, [5.0, 0.0]), (N, [62.0, 0.0])))
    found = lookup_table(force_table(u, T_, n, supply=24.0, source="by hand", edges=(-0.7, 0.8)), 24.0)
    assert found[:, 6].tolist() == [2.0, 4.5, 61.0]
    assert 0.3 not in found[0]


def test_a_thrust_that_falls_is_made_monotone() -> None:
    u, n = [*U, 2.5], [*N, 85.0]
    found = lookup_table(force_table(u, [*T, 3.0], n, supply=24.0, source="noise", edges=(-0.7, 0.8)), 24.0)
    checked(TableLaw(found))
    assert 2.5 not in found[0]
    assert found[1, list(found[0]).index(2.0)] == pytest.approx(3.5)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: dead_zone_edges([1.0, -1.0, -2.0], [10.0, -10.0, -60.0]), "two or more steady states in forward"),
        (
            lambda: dead_zone_edges([1.0, 2.0, -1.0, -2.0], [60.0, 70.0, -10.0, -60.0]),
            "edge in forward between 0 and 1",
        ),
        (lambda: dead_zone_edges([1.0, np.nan], [60.0, 70.0]), "expected finite numbers in rows of one length"),
        (lambda: table(edges=(0.2, 0.8)), "edges: expected one on either side of 0 V"),
        (lambda: lookup_of_set(load_parameter_set("hl").coefficients, u_max=0.5), "expected a dead zone within 0.5 V"),
    ],
)
def test_states_that_give_no_table_are_refused_with_what_is_wrong(call, said: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(SteadyStatesError, match=said):
        call()


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("1,2,3\n", r"expected 5 columns \(throttle \[V\]"),
        ("a,b,c,d,e\n", "expected rows of numbers"),
        (None, "No such file|not found"),
    ],
)
def test_a_file_that_is_none_of_ours_is_refused(tmp_path: Path, content: str | None, said: str) -> None:
    path = tmp_path / "states.csv"
    if content is not None:
        path.write_text(content, "utf-8")
    with pytest.raises(ThrusterControlError, match=said):
        read_steady_states(path, supply=24.0)


def test_a_parameter_set_s_table_is_its_own_steady_state() -> None:
    """Against the root of (3.8), which the table does not solve but simulate."""
    p = load_parameter_set("simplified").coefficients
    found = checked(TableLaw(lookup_of_set(p))).table
    assert found[0, [0, -1]].tolist() == [-3.0, 3.0]
    assert sorted(found[0, found[1] == 0.0]) == [p.delta_u1, p.delta_u2]
    for u, force, n in found.T:
        if n != 0.0:
            root = brentq(
                lambda x, u=u: float(rotor_acceleration(x, torque(x, 0.0, p), input_map(u, p), p)), -200.0, 200.0
            )
            assert (n, force) == pytest.approx((root, float(thrust(root, 0.0, p))), rel=1e-6, abs=1e-9)


def test_over_thrust_or_over_speed_the_simplified_set_gives_the_same_throttle() -> None:
    p = load_parameter_set("simplified").coefficients
    lookup, free = lookup_of_set(p), Limits(u_dot_max=1e9)
    for T_d in (-12.0, -3.0, -0.5, 0.5, 3.0, 12.0):
        by = [
            inner_loop_step(AT_REST, T_d, 0.0, 0.0, 0.0, False, 1.0, TableLaw(lookup, free, by_thrust=each), p)[1].u
            for each in (0, 1)
        ]
        assert by[0] == pytest.approx(by[1], abs=0.035)


def test_the_rig_s_states_give_the_throttle_that_its_lookup_runs_recorded(thruster_bench_data: Path) -> None:
    """T = 9.734848e-4 n|n|, then the speeds over the throttle; the rig fitted a line, the table joins points."""
    path = thruster_bench_data / "tables" / "Steady_State_Data.csv"
    files = sorted((thruster_bench_data / "closed_loop").glob("CLLookup*.mat"))
    if not path.is_file() or not files:
        pytest.skip(f"no steady states or lookup runs in {thruster_bench_data}")
    lookup = checked(TableLaw(lookup_table(read_steady_states(path, supply=24.0), 24.0))).table
    c = 9.734848e-4
    p = load_parameter_set("simplified").coefficients._replace(c_T1=c, c_T2=c, delta_T1=0.0, delta_T2=0.0)
    settings = TableLaw(lookup, Limits(idle_thrust=0.0), by_thrust=0)
    for file in files:
        data = loadmat(file)
        T_d, n_d, u = (data[name].ravel().astype(float) for name in ("Td", "nd", "u"))
        memory, outs = AT_REST, []
        for T in T_d:
            memory, out = inner_loop_step(memory, float(T), 0.0, 0.0, 0.0, True, 0.04, settings, p)
            outs.append(out)
        np.testing.assert_allclose([out.n_d for out in outs], n_d, atol=1e-4, err_msg=file.name)
        np.testing.assert_allclose([out.u for out in outs], u, atol=0.03, err_msg=file.name)
