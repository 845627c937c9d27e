"""The bench's recordings: what the importer finds in data whose truth is known."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from run_bag import RecordingError, RunExistsError, read_run
from run_bag.importers.bench import find, import_recording
from run_bag.importers.cli_bench import main
from run_bag.importers.decisions import Decisions
from run_bag.importers.open_loop import open_loop_topics
from run_bag.importers.options import BenchOptions, throttle_from_name
from run_bag.importers.signals import infer_sign, sign_unknown
from run_bag.importers.wrench import to_thruster

_spec = importlib.util.spec_from_file_location("synthetic_bench", Path(__file__).with_name("synthetic_bench.py"))
made = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(made)

TIME = np.arange(12_000) * 0.001


def open_loop(folder, name="2statep3V", *, setting=3.0, start=3.1, duration=1.4, stop=9.0, seed=0, **kw):
    u = made.ramp(TIME, start=start, duration=duration, setting=setting, stop=stop)
    n = made.rotor(TIME, u)
    volts = made.tachometer(n, seed=seed + 1, glitch=kw.pop("glitch", None), time=TIME)
    table = made.load_cell(TIME, n, volts, seed=seed, **kw)
    made.write_csv(folder / f"{name}.csv.xz", table)
    return u, n


def run_of(folder, out, options=None):
    plan = find([folder])
    imported = [import_recording(g, out, options or BenchOptions()) for g in plan.groups]
    return imported[0], read_run(imported[0].directory)


def decision(imported, what):
    return next(d for d in imported.decisions.items if d.what == what)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("setting", "duration"), [(3.0, 1.4), (-2.0, 1.2), (1.0, 0.5)])
def test_the_ramp_is_found_within_four_of_its_standard_deviations(tmp_path, setting, duration, seed):
    start = 3.1 + 0.137 * seed
    name = f"x{'p' if setting > 0 else 'm'}{abs(setting):g}V"
    open_loop(tmp_path, name, setting=setting, start=start, duration=duration, seed=seed)
    options = BenchOptions(dead_zone_edge=(-0.85, 0.85))
    imported, _ = run_of(tmp_path, tmp_path / "out", options)
    for what, truth in (("start of the ramp", start), ("duration of the ramp", duration), ("shutdown", 9.0)):
        d = decision(imported, what)
        assert abs(d.value - truth) < 4 * d.standard_deviation + 0.003, (what, d)
        assert d.standard_deviation < (0.05 if abs(setting) > 1 else 0.15)


def test_the_throttle_is_reconstructed_and_state_is_signed_and_untared(tmp_path):
    u, n = open_loop(tmp_path, "xm2.5V", setting=-2.5)
    _, run = run_of(tmp_path, tmp_path / "out", BenchOptions(dead_zone_edge=(-0.85, 0.85)))
    throttle = run["thruster_0/throttle.commanded"].values
    assert np.mean(np.abs(throttle - u)) < 0.02 and throttle[0] == 0 and throttle.min() == -2.5
    state = run["thruster_0/state.n"].values
    assert abs(np.median(state[5500:8500]) - (n[7000] - made.REST)) < 0.1
    assert np.mean(state[:2500]) == pytest.approx(-made.REST, abs=0.1)
    assert set(run["thruster_0/state.sign_source"].values) == {2}


def line_from_zero(time, *, setting, start, stop):
    """Return the thesis' programme: from 0 V over two seconds, then constant."""
    return np.where((time >= start) & (time < stop), setting * np.clip((time - start) / 2, 0, 1), 0.0)


@pytest.mark.parametrize("setting", [1.2, -2.0, 3.0])
@pytest.mark.parametrize("edge", [0.75, 0.95])
def test_a_line_from_zero_is_told_from_a_jump_to_the_edge_whatever_the_dead_zone(tmp_path, setting, edge):
    time = np.arange(0.0, 15.5, 0.001)
    u = line_from_zero(time, setting=setting, start=3.2, stop=13.2)
    n = made.rotor(time, u, edge=edge)
    name = f"y{'p' if setting > 0 else 'm'}{abs(setting):g}V"
    made.write_csv(tmp_path / f"{name}.csv", made.load_cell(time, n, made.tachometer(n)))
    imported, run = run_of(tmp_path, tmp_path / "out", BenchOptions())
    assert decision(imported, "throttle at the start of the ramp").value == 0.0
    on = decision(imported, "throttle switched on")
    assert abs(on.value - 3.2) < 4 * on.standard_deviation
    assert on.standard_deviation < 0.03
    assert run.metadata["clock_deviation"]["throttle"] == on.standard_deviation
    assert run.metadata["experiment"] == "open loop"


def test_a_tachometer_glitch_before_the_ramp_is_noted_and_moves_nothing(tmp_path):
    open_loop(tmp_path, "xm3V", setting=-3.0, start=3.5, glitch=(3.0, 110.0))
    imported, run = run_of(tmp_path, tmp_path / "out", BenchOptions(dead_zone_edge=(-0.85, 0.85)))
    (glitch,) = decision(imported, "tachometer glitches").value
    assert glitch["time"] == pytest.approx(3.0, abs=0.02) and glitch["height"] > 80
    start = decision(imported, "start of the ramp")
    assert abs(start.value - 3.5) < 4 * start.standard_deviation + 0.003
    assert np.min(run["thruster_0/state.n"].values[2900:3200]) < -80
    assert decision(imported, "rest window").value[1] < 2.9


def test_a_fixture_that_was_turned_round_is_noticed_turned_back_and_told(tmp_path, capsys):
    for name, reverse in (("ap3V", False), ("bp3V", True)):
        folder = tmp_path / name
        folder.mkdir()
        open_loop(folder, name, reverse=reverse)
        imported, run = run_of(folder, tmp_path / "out")
        assert decision(imported, "load cell turned round").value is reverse
        assert np.mean(run["thruster_0/load.wrench.force.x"].values[6000:8500]) > 8
        assert np.mean(run["thruster_0/load.wrench.torque.x"].values[6000:8500]) > 0.2
    assert main([str(tmp_path / "bp3V"), "--out", str(tmp_path / "again")]) == 0
    assert "half a turn" in capsys.readouterr().out


def test_the_user_can_overrule_every_guess(tmp_path):
    open_loop(tmp_path, "nameless", reverse=True)
    options = BenchOptions(throttle_set=2.0, load_cell="as-recorded", water=False)
    imported, run = run_of(tmp_path, tmp_path / "out", options)
    assert np.mean(run["thruster_0/load.wrench.force.x"].values[6000:8500]) < -8
    assert run["thruster_0/throttle.commanded"].values.max() == 2.0 and run.metadata["water"] is False
    assert decision(imported, "throttle at the plateau").how == "told by the user"


def test_a_throttle_in_the_last_column_is_told_from_a_tachometer(tmp_path):
    u = np.interp(TIME, [1, 2, 4, 6, 8, 9], [0, 3, 3, -3, -3, 0])
    noisy = u + np.random.default_rng(0).normal(scale=0.03, size=len(u))
    made.write_csv(tmp_path / "Fwd.csv", made.load_cell(TIME, made.rotor(TIME, u), noisy))
    _, run = run_of(tmp_path, tmp_path / "out")
    assert "thruster_0/state.n" not in run
    assert np.std(run["thruster_0/throttle.commanded"].values - u) < 0.012
    assert np.allclose(run["thruster_0/throttle.sent"].values, noisy, atol=1e-4)


def test_a_run_in_air_is_told_by_its_thrust_or_its_name(tmp_path):
    for folder, thrust, water in (("one", 1e-5, False), ("air", 1e-3, False), ("fair", 1e-3, True)):
        (tmp_path / folder).mkdir()
        open_loop(tmp_path / folder, f"{folder}_3V", thrust_gain=thrust)
        _, run = run_of(tmp_path / folder, tmp_path / "out")
        assert run.metadata["water"] is water, folder


def test_the_flow_is_positive_along_forward_thrust_and_nothing_of_the_raw_samples_is_lost(tmp_path):
    open_loop(tmp_path, "Ambientm3V", setting=-3.0)
    t = 4.0 + np.arange(300) * 0.04
    v = 0.1 * np.clip((t - 8) / 3, 0, 1)
    made.write_dat(tmp_path / "Ambientm3v.dat", t, v)
    imported, run = run_of(tmp_path, tmp_path / "out")
    assert "thruster_0/flow.axial" not in run
    assert np.allclose(run["thruster_0/flow.ambient"].values, -v, atol=1e-4)
    assert run.time("thruster_0/flow.ambient")[1] == pytest.approx(0.04)
    raw = np.loadtxt(tmp_path / "Ambientm3v.dat")
    assert np.array_equal(run["thruster_0/adv_raw.counter"].values, raw[:, 1])
    assert set(run["thruster_0/adv_raw.status"].values) == {0b00100011}
    for k, name in enumerate(("velocity", "amplitude", "snr", "correlation")):
        for i in range(4):
            assert np.array_equal(run[f"thruster_0/adv_raw.{name}[{i}]"].values, raw[:, 3 + 4 * k + i])
    assert decision(imported, "offset of the velocimeter's clock").standard_deviation >= 0.02
    assert [s["file"] for s in run.metadata["import"]["sources"]] == ["Ambientm3V.csv.xz", "Ambientm3v.dat"]


@pytest.mark.parametrize(("flow", "estimate"), [(False, None), (True, "scalar"), (True, "full")])
def test_controller_and_load_cell_come_onto_one_clock_and_the_sign_follows_the_throttle(tmp_path, flow, estimate):
    offset, period = 0.7314, 0.04
    grid = np.arange(251) * period
    u = np.where(grid < 5, -2.0, 2.0)
    dense = np.where((offset <= TIME) & (offset + 10 > TIME), np.where(offset + 5 > TIME, -2.0, 2.0), 0.0)
    n = made.rotor(TIME, dense, lag=0.15)
    table = made.load_cell(TIME, n, made.tachometer(n))
    made.write_csv(tmp_path / "CL2stateKF1Step.csv", table, "Author,Engineer\nTimeStamp,1/2/2019  6:47 PM\n\n")
    y = np.abs(np.interp(grid + offset, TIME, n)) + np.random.default_rng(5).normal(scale=0.5, size=251)
    u_flow = 0.1 * np.sin(grid) if flow else None
    made.write_mat(tmp_path / "CL2stateKF1Step.mat", u=u, n=y, flow=u_flow, estimate=estimate)
    imported, run = run_of(tmp_path, tmp_path / "out")
    start = decision(imported, "start of the controller's recording")
    assert abs(start.value - offset) < 4 * start.standard_deviation + 0.005
    signed = run["thruster_0/state.n"].values
    told = run["thruster_0/state.sign_source"].values
    moving = (np.abs(np.interp(grid + offset, TIME, n)) > 10) & (told == 2)
    assert np.array_equal(np.sign(signed[moving]), np.sign(np.interp(grid + offset, TIME, n)[moving]))
    assert np.all(signed[told == 0] >= 0.0) and 0 < np.sum(told == 0) < 10
    daq, fast = run["daq/thruster_0/state.n"].values, np.abs(n) > 10
    unsure = run["daq/thruster_0/state.sign_source"].values == 0
    assert np.mean(np.sign(daq[fast & ~unsure]) == np.sign(n[fast & ~unsure])) == 1.0
    assert np.mean(unsure[fast]) < 0.01
    throttle = run["thruster_0/throttle.commanded"].values
    assert len(throttle) == 253 and throttle[0] == 0 == throttle[-1] and np.array_equal(throttle[1:-1], u)
    assert len(run["thruster_0/speed_setpoint.n"]) == 251
    assert ("thruster_0/flow.ambient" in run) is flow
    if estimate:
        assert len(run["thruster_0/estimate.n"]) == 252
        assert ("thruster_0/estimate.covariance[4]" in run) is (estimate == "full")
        assert run["thruster_0/estimate.covariance[0]"].values[0] == 3.0
    assert decision(imported, "csv header: TimeStamp").value == "1/2/2019  6:47 PM"


def test_a_short_flip_of_the_throttle_turns_nothing_round():
    time = np.arange(2000) * 0.001
    speed = np.full(2000, 90.0)
    throttle = np.where((time > 0.5) & (time < 0.52), -1.0, 1.0)
    assert np.all(infer_sign(time, speed, throttle) == 1)


def test_a_rotor_turns_round_beyond_the_dead_zone_only():
    time = np.arange(4000) * 0.001
    throttle = np.interp(time, [0.0, 1.0, 2.0, 3.0, 4.0], [2.0, 2.0, -0.6, -0.6, -2.0])  # a second within the dead zone
    n = np.interp(time, [0.0, 1.0, 3.0, 3.3, 4.0], [90.0, 90.0, 30.0, 0.0, -60.0])
    assert np.all(infer_sign(time, np.abs(n), throttle, 0.86)[np.abs(n) > 2.0] == np.sign(n)[np.abs(n) > 2.0])
    still = np.where(time < 1.5, 2.0, -0.5)
    assert np.all(infer_sign(time, np.full(4000, 20.0), still, 0.86) == 1)


def test_about_a_reversal_the_sign_is_unknown_until_the_throttle_is_beyond_the_dead_zone_and_the_speed_has_risen():
    time = np.arange(6000) * 0.001
    throttle = np.interp(time, [0.0, 1.0, 1.5, 3.0, 3.5], [2.0, 2.0, -0.6, -0.6, -2.0])
    n = np.interp(time, [0.0, 1.0, 2.0, 3.1, 3.9], [90.0, 90.0, 0.0, 0.0, -80.0])  # rests within the dead zone
    read = np.abs(n) + 0.3 * np.random.default_rng(2).standard_normal(time.size)
    sign = infer_sign(time, read, throttle, 0.86)
    unknown = sign_unknown(time, read, throttle, sign, 0.86)
    assert unknown[2050:3100].all() and not unknown[:1900].any() and not unknown[3200:].any()
    known = ~unknown & (np.abs(n) > 0.0)
    assert np.array_equal(sign[known], np.sign(n[known]))


def test_a_rotor_that_the_water_turns_within_the_dead_zone_has_no_sign_until_it_is_driven_and_has_turned_round():
    time = np.arange(6000) * 0.001
    throttle = np.interp(time, [0.0, 1.0, 1.5, 3.0, 3.01], [2.0, 2.0, -0.6, -0.6, -2.0])
    # Least while the throttle is within the dead zone; a filter hides that it passes zero at 3.1 s.
    read = np.interp(time, [0.0, 1.0, 1.8, 2.4, 3.0, 3.1, 4.0], [90.0, 90.0, 5.0, 25.0, 25.0, 8.0, 80.0])
    n = np.where(time < 3.1, 1.0, -1.0) * read
    read = read + 0.3 * np.random.default_rng(2).standard_normal(time.size)
    sign = infer_sign(time, read, throttle, 0.86)
    unknown = sign_unknown(time, read, throttle, sign, 0.86)
    assert np.array_equal(sign[~unknown], np.sign(n[~unknown]))
    assert unknown[1850:3100].all() and not unknown[:1700].any() and not unknown[3200:].any()


def test_a_reversal_that_the_end_cuts_off_has_no_sign():
    time = np.arange(3000) * 0.001
    throttle = np.where(time < 2.9, 2.0, -2.0)
    read = np.interp(time, [0.0, 2.9, 3.0], [80.0, 80.0, 60.0])
    sign = np.ones(time.size)
    assert np.array_equal(sign_unknown(time, read, throttle, sign, 0.86), time >= 2.9)


def test_a_throttle_beyond_what_the_device_takes_is_asked_about(tmp_path, capsys):
    open_loop(tmp_path, "xp9V", setting=3.0)
    assert main([str(tmp_path), "--out", str(tmp_path / "out")]) == 1
    told = capsys.readouterr()
    assert "at most 5 V" in told.out + told.err and "--throttle-limit" in told.out + told.err
    assert not (tmp_path / "out" / "xp9V").exists()
    _, run = run_of(tmp_path, tmp_path / "other", BenchOptions(throttle_limit=10.0))
    assert run["thruster_0/throttle.commanded"].values.max() == 9.0


def test_no_thrust_turns_no_fixture_round(tmp_path):
    open_loop(tmp_path, "airp3V", thrust_gain=-2e-5)  # a quarter of a newton against the rotation
    imported, _ = run_of(tmp_path, tmp_path / "out")
    turned = decision(imported, "load cell turned round")
    assert turned.value is False and "too little to tell" in turned.how


def test_a_velocimeter_that_lasts_for_days_is_on_no_common_clock(tmp_path):
    open_loop(tmp_path, "ap3V")
    time = np.arange(300) * 0.04
    made.write_dat(tmp_path / "ap3V.dat", np.where(np.arange(300) < 150, time, time + 2e5), np.full(300, 0.1))
    with pytest.raises(RecordingError, match="--adv-offset"):
        run_of(tmp_path, tmp_path / "out")


@pytest.mark.parametrize("offset", [1e5, 12.5])
def test_a_velocimeter_beside_the_load_cells_recording_is_refused(tmp_path, offset):
    open_loop(tmp_path, "ap3V")
    made.write_dat(tmp_path / "ap3V.dat", np.arange(300) * 0.04, np.full(300, 0.1))
    told = rf"ap3V: expected .* to overlap the load cell's, 0 to 11.999 s; found {offset:g} to .* by --adv-offset"
    with pytest.raises(RecordingError, match=told):
        run_of(tmp_path, tmp_path / "out", BenchOptions(adv_offset=offset))
    run_of(tmp_path, tmp_path / "other", BenchOptions(adv_offset=3.0))


def test_axes_by_hand():
    force, torque = to_thruster(np.array([[1.0, 2, 3]]), np.array([[4.0, 5, 6]]), reversed_fixture=False)
    assert force.tolist() == [[-2, 1, 3]] and torque.tolist() == [[5, -4, -6]]
    force, torque = to_thruster(np.array([[1.0, 2, 3]]), np.array([[4.0, 5, 6]]), reversed_fixture=True)
    assert force.tolist() == [[2, -1, 3]] and torque.tolist() == [[-5, 4, -6]]


@pytest.mark.parametrize(
    ("name", "volts"),
    [
        ("2statep3V", 3),
        ("Ambientm3v", -3),
        ("am2p5V", -2.5),
        ("xp2.5V", 2.5),
        ("201808061450_3V", 3),
        ("Fwd", None),
    ],
)
def test_the_throttle_in_the_name(name, volts):
    assert throttle_from_name(name) == volts


@pytest.mark.parametrize(
    ("suffix", "spoil", "sentence"),
    [
        (".csv", lambda s: s.replace("\n", "\n1,2,3\n", 1), "line 2: expected 21 columns, found 3"),
        (
            ".csv",
            lambda s: s.replace("\n1,", "\nNaN,", 1),
            "line 2, column 1: expected a number, found 'NaN'",
        ),
        (
            ".csv",
            lambda s: s.replace("\n1,", "\nabc,", 1),
            "line 2, column 1: expected a number, found 'abc'",
        ),
        (".csv", lambda s: s + s.splitlines()[0] + "\n", "expected time to increase, found 0 s after"),
        (
            ".dat",
            lambda s: s.replace("00100011", "00102011", 1),
            "line 1, column 3: expected up to eight status bits",
        ),
        (".dat", lambda s: s + "1 2 3\n", "line 31: expected 19 columns, found 3"),
        (".mat", lambda s: "no matlab file", "cannot be read as a MATLAB file"),
    ],
)
def test_malformed_files_are_refused_with_file_line_expected_and_found(tmp_path, suffix, spoil, sentence):
    csv = made.write_csv(tmp_path / "xp3V.csv", made.load_cell(TIME[:50], TIME[:50], TIME[:50]))
    made.write_dat(tmp_path / "xp3V.dat", np.arange(30) * 0.04, np.zeros(30))
    path = csv.with_suffix(suffix)
    path.write_text(spoil(path.read_text() if path.exists() else ""))
    (group,) = find([tmp_path]).groups
    with pytest.raises(RecordingError) as caught:
        import_recording(group, tmp_path / "out", BenchOptions())
    assert sentence in str(caught.value) and str(path) in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_a_rotor_that_never_turns_and_a_name_without_throttle_are_refused(tmp_path):
    log, still = Decisions(), made.load_cell(TIME, 0 * TIME, made.tachometer(0 * TIME))
    made.write_csv(tmp_path / "xp3V.csv", still)
    made.write_csv(tmp_path / "nameless.csv", still)
    for group, sentence in zip(
        find([tmp_path]).groups, ["or --throttle-set", "expected the rotor to turn"], strict=True
    ):
        with pytest.raises(RecordingError, match=sentence):
            import_recording(group, tmp_path / "out", BenchOptions())
    assert log.json() == [] and open_loop_topics


def test_the_command_line_goes_on_after_a_failure_and_ends_with_status_one(tmp_path, capsys):
    data, out = tmp_path / "data", tmp_path / "out"
    data.mkdir()
    open_loop(data, "ap3V")
    open_loop(data, "bp3V")
    (data / "table.csv").write_text("1,2\n3,4\n")
    (data / "README.md").write_text("x")
    (data / "lonely.dat").write_text("x")
    assert main([str(data / "ap3V.csv.xz"), "--out", str(out)]) == 0
    before = (out / "ap3V" / "ap3V_0.mcap").read_bytes()
    assert main([str(data), "--out", str(out)]) == 1
    printed = capsys.readouterr()
    assert "ap3V exists; nothing is overwritten" in printed.err and "bp3V: 11.999 s" in printed.out
    assert "1 imported, 1 failed, 3 files skipped" in printed.out
    assert "table.csv: no recording: expected 21 columns, found 2 columns" in printed.out
    assert "lonely.dat: no csv of the same name" in printed.out
    assert (out / "ap3V" / "ap3V_0.mcap").read_bytes() == before
    with pytest.raises(RunExistsError):
        import_recording(find([data]).groups[0], out, BenchOptions())
    assert main([str(tmp_path / "none"), "--out", str(out)]) == 1
