"""Set points of the vehicle: shapes against their own derivatives, files that cannot be read, an operator's stick."""

import math
from pathlib import Path

import numba
import numpy as np
import pytest

from thruster_control.errors import ScriptError
from thruster_control.operator_set_points import OperatorSettings, OperatorTrack, operated
from thruster_control.vehicle_set_points import Move, Script, script_of, set_point_at
from thruster_control.vehicle_set_points_io import known_scripts, load_script, parse_script


@numba.njit
def in_a_kernel(script, t):  # type: ignore[no-untyped-def]
    return set_point_at(script, t)


def pitch(script: Script, t: float) -> tuple[float, float, float]:
    sp = set_point_at(script, t)
    return sp.attitude[1], sp.attitude_rate[1], sp.attitude_acceleration[1]


def test_shapes_take_the_values_worked_out_by_hand() -> None:
    script = script_of(
        [
            Move(10.0, "sine", {"pitch": 0.2}, 4.0, 2.0),
            Move(1.0, "step", {"surge": 0.3, "pitch": 0.1}),
            Move(4.0, "quintic", {"pitch": 0.5}, 2.0),
        ],
        20.0,
    )
    assert pitch(script, 0.9) == (0.0, 0.0, 0.0)
    assert pitch(script, 1.0) == (0.1, 0.0, 0.0)
    assert set_point_at(script, 1.0).velocity == (0.3, 0.0, 0.0)
    assert pitch(script, 5.0) == pytest.approx((0.3, 0.4 / 2.0 * 30.0 / 16.0, 0.0))
    assert pitch(script, 6.0) == (0.5, 0.0, 0.0)
    assert pitch(script, 10.5) == pytest.approx((0.7, 0.0, -0.2 * math.pi**2))
    assert pitch(script, 14.0) == (0.5, 0.0, 0.0)
    assert all(math.isnan(x) for t in (-0.1, 20.0, math.nan) for part in set_point_at(script, t) for x in part)


@pytest.mark.parametrize("name", known_scripts())
def test_rates_and_accelerations_of_the_scripts_are_the_derivatives_of_their_values(name: str) -> None:
    script, h = load_script(name), 1e-5
    for t in np.arange(0.03, min(script.end, 60.0), 0.3711):
        before, at, after = (set_point_at(script, float(x)) for x in (t - h, t, t + h))
        for value, rate in (("attitude", "attitude_rate"), ("velocity", "acceleration")):
            slope = (np.array(getattr(after, value)) - getattr(before, value)) / (2 * h)
            assert np.array(getattr(at, rate)) == pytest.approx(slope, abs=1e-8)
        slope = (np.array(after.attitude_rate) - before.attitude_rate) / (2 * h)
        assert np.array(at.attitude_acceleration) == pytest.approx(slope, abs=1e-7)
        assert in_a_kernel(script, float(t)) == at


def test_the_pitch_of_surge_and_pitch_has_a_mean_of_zero_and_both_sizes() -> None:
    script = load_script("surge_and_pitch")
    values = np.array([pitch(script, t)[0] for t in np.arange(0.0, 42.0, 0.01)])
    assert values.mean() == pytest.approx(0.0, abs=1e-4)
    assert (values.min(), values.max()) == (-0.5, 0.5)
    assert script.end == 42.0


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("moves: 3", "key 'moves': expected a list of moves"),
        ("[", "expected YAML"),
        ("moves: [{time: 1.0}]", "move 0: expected the keys time, shape, size"),
        ("moves: [{time: 1.0, shape: jump, size: {surge: 1}}]", "move 0: shape: expected one of step, quintic"),
        ("moves: [{time: 1, shape: step, size: {depth: 1}}]", "degrees of freedom among surge, .*; found depth"),
        ("moves: [{time: -1, shape: step, size: {yaw: 1}}]", "expected a time of 0 s or more"),
        ("moves: [{time: 1, shape: quintic, size: {yaw: 1}}]", "a duration above 0 s; found 1.0 s, 0.0 s"),
        ("moves: [{time: 1, shape: sine, duration: 2, size: {yaw: 1}}]", "period: expected a finite time above 0"),
        ("moves: [{time: 1, shape: step, size: {yaw: fast}}]", "size: expected a number for each degree"),
        ("moves: [{time: 1, shape: step, size: {yaw: .nan}}]", "size: expected finite numbers; found nan"),
        ("{moves: [], end: never}", "end: expected a number of seconds; found 'never'"),
        ("{moves: [], end: 0}", "end: expected a time above 0 s; found 0.0 s"),
        ("{moves: [], begin: 0}", "key 'begin': expected one of moves, end"),
        (
            "moves: [{time: 1, shape: quintic, duration: 3, size: {yaw: 1}}, {time: 2, shape: step, size: {yaw: 0}}]",
            "move 1: yaw is still moving at 2 s, until 4 s",
        ),
    ],
)
def test_what_is_no_script_is_refused_in_a_sentence(text: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(ScriptError, match=sentence):
        parse_script(text, "mine")
    file = tmp_path / "mine.yaml"
    file.write_text(text, "utf-8")
    with pytest.raises(ScriptError, match=sentence):
        load_script(file)


@pytest.mark.parametrize(
    ("name", "sentence"),
    [("loops", "loops: expected a YAML file or one of the known scripts all_axes"), ("no.yaml", "cannot be read")],
)
def test_a_script_that_is_not_there_is_named(name: str, sentence: str) -> None:
    with pytest.raises(ScriptError, match=sentence):
        load_script(name)


def test_a_stick_is_followed_by_ramps_and_without_one_the_vehicle_stops_and_keeps_its_attitude() -> None:
    settings, track = OperatorSettings(speed=0.4, rate=0.5, acceleration=0.5, turning=1.0, tilt=0.3), OperatorTrack()
    push = ((1.0, -0.1, 0.0), (0.0, 9.0, -0.2))
    for _ in range(100):
        track, sp = operated(track, push, 0.04, settings)
    assert sp.velocity == pytest.approx((0.4, -0.1, 0.0))
    assert sp.attitude_rate[2] == pytest.approx(-0.2)
    assert 0.3 <= sp.attitude[1] < 0.5, "pitch stops at the largest tilt"
    for none in (None, ((math.nan, 0.0, 0.0), (0.0, 0.0, 0.0))):
        stopping, yaw = track, []
        for _ in range(60):
            stopping, sp = operated(stopping, none, 0.04, settings)
            yaw.append(sp.attitude[2])
            assert max(map(abs, sp.acceleration)) <= 0.5 + 1e-12
        assert sp.velocity == (0.0, 0.0, 0.0) and sp.attitude_rate == (0.0, 0.0, 0.0)
        assert yaw[-1] == yaw[-20] != 0.0


def test_a_period_that_cannot_be_leaves_the_operators_set_point_as_it_is() -> None:
    track = OperatorTrack((0.1, 0.2, 0.3), (0.0, 0.0, 0.1), (0.4, 0.0, 0.0))
    for dt in (0.0, -1.0, math.nan):
        assert operated(track, None, dt, OperatorSettings())[0] == track
