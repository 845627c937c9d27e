"""Recorded runs become experiments; what cannot is refused with the run, what was expected and found."""

import re
from dataclasses import replace

import numpy as np
import pytest

from run_bag import RunError, read_run, write_run
from thruster_model.errors import UnfitDataError
from thruster_model.identification.experiment_io import PreparationOptions, prepare, read_experiments

DURATION = 10.0
FAST = np.arange(0.0, DURATION, 0.001)
SLOW = np.arange(0.0, DURATION, 0.04)
INFERRED, MEASURED, UNKNOWN = 2, 1, 0


def throttle_at(time):
    """Two seconds of rest, ramps to +2 V and to -2 V [V]."""
    return np.interp(time, [0.0, 2.0, 4.0, 5.0, 7.0, 8.0, DURATION], [0.0, 0.0, 2.0, 2.0, -2.0, -2.0, 0.0])


def speed_at(time):
    """What a rotor without inertia does [rad/s]."""
    return 40.0 * throttle_at(time)


class Bench:
    """A recording to be changed by tests before it is written: topics by name."""

    def __init__(self, make):
        rng = np.random.default_rng(1)
        self.make = make
        self.topics = {}
        self.add("throttle", "Throttle", SLOW, commanded=throttle_at(SLOW))
        self.speed("thruster_0/state", FAST, 1.2, INFERRED)
        force = 0.7 + 0.5 * speed_at(FAST) + 0.1 * rng.standard_normal(FAST.size)
        self.add("load", "WrenchStamped", FAST, **{"wrench.force.x": force, "wrench.torque.x": 1e-2 * force})
        self.add("flow", "FlowVelocity", SLOW, axial=self.velocity())

    def velocity(self):
        """A credible axial flow at 25 Hz [m/s]."""
        return 0.05 * throttle_at(SLOW) + 0.006 * np.random.default_rng(2).standard_normal(SLOW.size)

    def add(self, name, kind, time, **fields):
        self.topics[name] = self.make(f"thruster_0/{name}", kind, time, fields)

    def speed(self, name, time, rest, source):
        """A rotor speed whose magnitude reads `rest` [rad/s] too much, and where its sign comes from."""
        true = speed_at(time)
        noisy = np.abs(true) + rest + 0.3 * np.random.default_rng(3).standard_normal(time.size)
        n = np.where(true < 0.0, -1.0, 1.0) * noisy
        fields = {"n": n, "sign_source": np.full(time.size, source)}
        self.topics[name] = self.make(name, "ThrusterState", time, fields)

    def write(self, path, metadata=None):
        return write_run(path, self.topics.values(), metadata or {})

    def prepared(self, path, metadata=None, options=None):
        return prepare(read_run(self.write(path, metadata)), options)


@pytest.fixture
def bench(bench_topic):
    return Bench(bench_topic)


def during(measurement, first, last):
    """Mean over the cells within a stretch [s]."""
    part = measurement.values[(measurement.time > first) & (measurement.time < last)]
    return float(np.mean(part[np.isfinite(part)]))


def rest_value(experiment):
    """The tachometer's rest value as the notes state it [rad/s]."""
    pattern = re.compile(r"rotor speed: rest value (\S+) rad/s taken off")
    return float(next(match[1] for note in experiment.notes if (match := pattern.fullmatch(note))))


def test_a_run_becomes_an_experiment_with_all_that_was_measured(bench, tmp_path):
    experiment = bench.prepared(tmp_path / "first")
    assert experiment.name == "first"
    assert set(experiment.measurements) == {"speed", "thrust", "torque", "axial"}
    assert experiment.dt == 0.002
    assert experiment.throttle_shift_std == 0.0
    grid = 0.002 * np.arange(experiment.throttle.size)
    held = throttle_at(0.04 * np.floor(grid / 0.04 + 1e-6))
    np.testing.assert_allclose(experiment.throttle, held, atol=1e-12)
    assert "tared on the rest from 0.00 to 1.79 s" in experiment.notes
    assert any(note.startswith("axial flow: ") and "% remain" in note for note in experiment.notes)


def test_a_throttle_whose_hold_is_stated_as_linear_goes_on_straight_lines(bench, tmp_path):
    experiment = bench.prepared(tmp_path / "run", {"hold": {"throttle": "linear"}})
    ends = 0.002 * np.arange(1, experiment.throttle.size + 1)
    assert experiment.straight
    np.testing.assert_allclose(experiment.throttle, np.interp(ends, SLOW, throttle_at(SLOW)), atol=1e-12)
    np.testing.assert_allclose(experiment.commands(2)[1::2], experiment.throttle, atol=1e-12)


def test_a_hold_that_there_is_not_is_refused_with_what_was_expected(bench, tmp_path):
    with pytest.raises(RunError, match=r"run: expected metadata hold\.throttle previous or linear; found 'spline'"):
        bench.prepared(tmp_path / "run", {"hold": {"throttle": "spline"}})


def test_rows_of_a_table_that_are_other_sensors_are_no_readings(bench, tmp_path):
    whole = bench.prepared(tmp_path / "whole").measurements
    for name, topic in list(bench.topics.items()):
        if "throttle" in topic.name:
            continue
        stamps = np.concatenate([np.asarray(topic.stamps) + k * 300_000 for k in range(4)])
        order = np.argsort(stamps)
        row = {"sign_source": 2.0, "spike": 0.0}
        fields = {
            f: np.concatenate([v, *[np.full(len(v), row.get(f, np.nan))] * 3])[order] for f, v in topic.fields.items()
        }
        bench.topics[name] = replace(topic, stamps=stamps[order], fields=fields)
    wide = bench.prepared(tmp_path / "wide").measurements
    assert set(wide) == set(whole)
    for signal, measured in whole.items():
        count = measured.time.size - 1  # the last rows come a little later
        np.testing.assert_allclose(wide[signal].time[:count], measured.time[:count], atol=1e-9)
        np.testing.assert_allclose(wide[signal].values[:count], measured.values[:count], atol=1e-9)


def test_an_inferred_sign_has_the_rest_value_taken_off_the_magnitude(bench, tmp_path):
    experiment = bench.prepared(tmp_path / "run")
    speed = experiment.measurements["speed"]
    assert during(speed, 4.2, 4.8) == pytest.approx(80.0, abs=0.1)
    assert during(speed, 7.2, 7.8) == pytest.approx(-80.0, abs=0.1)
    assert rest_value(experiment) == pytest.approx(1.2, abs=0.03)


def test_a_measured_sign_has_its_offset_taken_off_as_it_is(bench, tmp_path):
    bench.speed("thruster_0/state", FAST, 0.0, MEASURED)
    fields = dict(bench.topics["thruster_0/state"].fields)
    fields["n"] = fields["n"] + 1.2
    bench.topics["thruster_0/state"] = bench.make("thruster_0/state", "ThrusterState", FAST, fields)
    speed = bench.prepared(tmp_path / "run").measurements["speed"]
    assert during(speed, 4.2, 4.8) == pytest.approx(80.0, abs=0.4)
    assert during(speed, 7.2, 7.8) == pytest.approx(-80.0, abs=0.4)


def test_loads_lose_their_rest_values(bench, tmp_path):
    experiment = bench.prepared(tmp_path / "run")
    assert during(experiment.measurements["thrust"], 4.2, 4.8) == pytest.approx(40.0, abs=0.05)
    assert during(experiment.measurements["torque"], 7.2, 7.8) == pytest.approx(-0.4, abs=5e-4)
    assert during(experiment.measurements["thrust"], 0.2, 1.8) == pytest.approx(0.0, abs=0.02)


def test_cells_stand_for_the_instants_of_their_centres(bench, tmp_path):
    speed = bench.prepared(tmp_path / "run").measurements["speed"]
    rising = (speed.time > 2.5) & (speed.time < 3.8)
    late = np.mean(speed.values[rising] - speed_at(speed.time[rising])) / 40.0
    assert abs(late) < 1e-3  # s: a half period of the 25 Hz controller would be 0.02 s, of the cells' samples 0.0025 s
    assert speed.width == 0.04


def test_the_fast_channel_of_the_data_acquisition_is_preferred(bench, tmp_path):
    bench.speed("thruster_0/state", SLOW, 3.0, INFERRED)
    bench.speed("daq/thruster_0/state", FAST, 1.2, INFERRED)
    experiment = bench.prepared(tmp_path / "run")
    assert rest_value(experiment) == pytest.approx(1.2, abs=0.03)
    assert during(experiment.measurements["speed"], 7.2, 7.8) == pytest.approx(-80.0, abs=0.1)


def test_a_slow_tachometer_keeps_its_own_instants(bench, tmp_path):
    bench.speed("thruster_0/state", SLOW, 1.2, INFERRED)
    speed = bench.prepared(tmp_path / "run").measurements["speed"]
    np.testing.assert_allclose(speed.time, SLOW[: speed.time.size], atol=1e-9)


def test_a_reading_whose_sign_is_unknown_is_not_measured_unless_it_is_near_rest(bench, tmp_path):
    bench.speed("thruster_0/state", SLOW, 1.2, INFERRED)
    known = bench.prepared(tmp_path / "run").measurements["speed"]
    topic = bench.topics["thruster_0/state"]
    unsure = (SLOW > 4.2) & (SLOW < 4.8) | (SLOW < 1.0)  # the first stretch turns, the second rests
    fields = {"n": np.where(unsure, np.abs(topic.fields["n"]), topic.fields["n"])}
    fields["sign_source"] = np.where(unsure, 0, INFERRED)
    bench.topics["thruster_0/state"] = replace(topic, fields=fields)
    speed = bench.prepared(tmp_path / "unsure").measurements["speed"]
    turning = (speed.time > 4.3) & (speed.time < 4.7)
    assert np.isnan(speed.values[turning]).all() and np.isfinite(known.values[turning]).all()
    assert np.mean(np.isfinite(speed.values[speed.time < 0.9])) > 0.95


def test_about_a_reversal_no_sign_is_believed_that_was_inferred(bench, tmp_path):
    bench.speed("thruster_0/state", SLOW, 1.2, INFERRED)
    speed = bench.prepared(tmp_path / "run").measurements["speed"]
    unknown = speed.time[~np.isfinite(speed.values)]
    assert 0 < unknown.size <= 6 and np.ptp(unknown) < 0.3
    before, after = speed_at(unknown[0] - 0.1), speed_at(unknown[-1] + 0.1)
    assert before * after < 0.0


@pytest.mark.parametrize("gone", ["thruster_0/state", "load", "flow"])
def test_what_was_not_recorded_is_left_out_without_ado(bench, tmp_path, gone):
    signals = {"thruster_0/state": {"speed"}, "load": {"thrust", "torque"}, "flow": {"axial"}}[gone]
    del bench.topics[gone]
    left = {"speed", "thrust", "torque", "axial"} - signals
    assert set(bench.prepared(tmp_path / "run").measurements) == left


def test_the_sent_throttle_serves_where_the_command_was_not_recorded(bench, tmp_path):
    bench.add("throttle", "Throttle", SLOW, sent=throttle_at(SLOW))
    assert bench.prepared(tmp_path / "run").throttle.max() == pytest.approx(2.0)


def test_samples_that_the_driver_flags_are_not_used(bench, tmp_path):
    flagged = np.arange(SLOW.size) % 50 == 7
    bench.add("flow", "FlowVelocity", SLOW, axial=bench.velocity(), spike=flagged)
    axial = bench.prepared(tmp_path / "run").measurements["axial"]
    assert np.isnan(axial.values[np.flatnonzero(flagged)]).all()
    assert np.isfinite(axial.values).mean() > 0.85


def test_a_hopeless_flow_channel_is_left_out_and_the_notes_say_so(bench, tmp_path):
    garbage = 0.4 * np.random.default_rng(5).standard_normal(SLOW.size)
    bench.add("flow", "FlowVelocity", SLOW, axial=garbage)
    experiment = bench.prepared(tmp_path / "run")
    assert "axial" not in experiment.measurements
    assert any("so the channel is left out" in note for note in experiment.notes)


def test_jumps_of_the_throttle_mask_the_loads_and_not_the_speed(bench, tmp_path):
    jumping = np.where(SLOW < 2.0, 0.0, np.where(SLOW < 6.0, 1.5, 0.0))
    bench.add("throttle", "Throttle", SLOW, commanded=jumping)
    experiment = bench.prepared(tmp_path / "run")
    thrust = experiment.measurements["thrust"]
    assert np.isnan(thrust.values[(thrust.time > 2.05) & (thrust.time < 3.15)]).all()
    assert np.isfinite(thrust.values[(thrust.time > 3.3) & (thrust.time < 5.9)]).all()
    assert np.isfinite(experiment.measurements["speed"].values).all()
    assert any(note.startswith("thrust: 24 % masked: the load cell rings") for note in experiment.notes)


def test_without_rest_nothing_is_tared_and_the_notes_say_so(bench, tmp_path):
    bench.add("throttle", "Throttle", SLOW, commanded=1.0 + throttle_at(SLOW))
    experiment = bench.prepared(tmp_path / "run")
    assert "no rest before the throttle: nothing was tared" in experiment.notes
    assert during(experiment.measurements["thrust"], 4.2, 4.8) == pytest.approx(40.7, abs=0.05)


def test_clock_deviations_come_from_the_runs_record(bench, tmp_path):
    metadata = {"clock_deviation": {"throttle": 0.02, "flow": 0.1}}
    experiment = bench.prepared(tmp_path / "run", metadata)
    assert experiment.throttle_shift_std == 0.02
    assert experiment.measurements["axial"].shift_std == 0.1
    assert experiment.measurements["speed"].shift_std == 0.0
    experiment = bench.prepared(tmp_path / "sensors", {"clock_deviation": {"state": 0.03, "load": 0.05}})
    own = {name: experiment.measurements[name].shift_std for name in ("speed", "thrust", "axial")}
    assert own == {"speed": 0.03, "thrust": 0.05, "axial": 0.0}


@pytest.mark.parametrize("deviation", [{}, {"flow": None}, {"throttle": 0.0}])
def test_a_record_that_is_silent_on_clocks_trusts_them(bench, tmp_path, deviation):
    experiment = bench.prepared(tmp_path / "run", {"clock_deviation": deviation})
    assert experiment.throttle_shift_std == experiment.measurements["axial"].shift_std == 0.0


def test_a_run_in_air_is_refused(bench, tmp_path):
    with pytest.raises(UnfitDataError, match=r"^dry: recorded in air; expected a thruster in water$"):
        bench.prepared(tmp_path / "dry", {"water": False})
    assert bench.prepared(tmp_path / "wet", {"water": True}).name == "wet"


def test_a_run_without_throttle_is_refused_with_what_it_has(bench, tmp_path):
    del bench.topics["throttle"]
    pattern = r"^run: expected a channel thruster_0/throttle.commanded; found .*thruster_0/state.n"
    with pytest.raises(UnfitDataError, match=pattern):
        bench.prepared(tmp_path / "run")
    with pytest.raises(UnfitDataError, match=r"expected a channel thruster_3/throttle.commanded; found"):
        bench.prepared(tmp_path / "other", options=PreparationOptions(thruster=3))


def test_a_run_of_nothing_but_throttle_is_refused_with_what_it_has(bench, tmp_path):
    for name in ("thruster_0/state", "load", "flow"):
        del bench.topics[name]
    pattern = r"^run: nothing usable is measured; channels are thruster_0/throttle.commanded$"
    with pytest.raises(UnfitDataError, match=pattern):
        bench.prepared(tmp_path / "run")


def test_all_that_is_wrong_with_any_run_is_said_at_once(bench, tmp_path):
    good = bench.write(tmp_path / "good")
    dry = bench.write(tmp_path / "dry", {"water": False})
    del bench.topics["throttle"]
    mute = bench.write(tmp_path / "mute")
    told = []
    with pytest.raises(UnfitDataError) as error:
        read_experiments([dry, good, mute, tmp_path / "absent"], progress=told.append)
    dry_problem, mute_problem, absent_problem = error.value.problems
    assert dry_problem.startswith("dry: recorded in air")
    assert mute_problem.startswith("mute: expected a channel")
    assert absent_problem == f"{tmp_path / 'absent'}: no such file or directory"
    assert told == ["read dry", "read good", "read mute", "read absent"]
    assert [e.name for e in read_experiments([good])] == ["good"]


def test_a_truncated_recording_is_read_as_far_as_it_goes_and_the_warnings_say_so(bench, tmp_path):
    path = bench.write(tmp_path / "cut")
    file = next(path.glob("*.mcap"))
    file.write_bytes(file.read_bytes()[: int(0.5 * file.stat().st_size)])
    experiment = prepare(read_run(path))
    assert 1.0 < experiment.duration < DURATION
    assert any("cut_0.mcap" in text for text in experiment.warnings)


def test_a_speed_without_sign_gets_the_throttles_and_loses_its_readings_near_rest(tmp_path, bench):
    bench.speed("thruster_0/state", SLOW, 0.0, UNKNOWN)
    bench.topics["thruster_0/state"].fields["n"][:] = np.abs(bench.topics["thruster_0/state"].fields["n"])
    speed = bench.prepared(tmp_path / "run").measurements["speed"]
    backwards = (speed.time > 6.5) & (speed.time < 9.0)
    assert np.nanmax(speed.values[backwards]) < -20.0 and np.nanmax(speed.values) > 70.0
    assert np.all(np.isnan(speed.values[speed.time < 1.9]))


def test_what_the_device_got_counts_before_what_it_was_asked_for(tmp_path, bench):
    bench.add("throttle_sent", "Throttle", SLOW + 0.02, sent=np.where(SLOW < 0.1, np.nan, 0.5 * throttle_at(SLOW)))
    assert np.max(bench.prepared(tmp_path / "run").throttle) == pytest.approx(1.0)
