"""What is proposed for the names, units and times of a bench's tables."""

import re

import numpy as np
import pytest
from map_import import SWEEP, attempted, imported, proposal, proposed, wide

from run_bag.importers.cli_recording import main


def guessed(tmp_path, capsys, header, values, times=None):
    """Return the entry that is proposed for the second column, and what is said beside it."""
    times = np.arange(values.size) * 0.02 if times is None else times
    rows = "".join(f"{t!r},{v!r}\n" for t, v in zip(times.tolist(), values.tolist(), strict=True))
    (tmp_path / "x.csv").write_text(f"{header}\n{rows}")
    assert main([str(tmp_path / "x.csv"), "--guess"]) == 0
    return capsys.readouterr()


def test_words_within_names_and_units_in_brackets_suggest_too(tmp_path, capsys):
    (tmp_path / "x.csv").write_text(
        "Zeit [ms];Welle rpm;ESC pwm_us;motor current;Zug (kgf)\n0;900;1500;1;0,5\n1;900;1500;1;0,5\n"
    )
    text = proposal(capsys, tmp_path / "x.csv")
    assert "time: {column: 'Zeit [ms]', unit: ms}" in text
    assert "thruster_0/state.n: {column: Welle rpm, unit: rpm}" in text
    assert (
        "thruster_0/throttle.commanded: {column: ESC pwm_us, unit: us, stop: 1500, per_volt: 80, hold: previous}"
        in text
    )
    assert "thruster_0/state.current: {column: motor current, unit: A}" in text
    assert (
        "load.wrench.force.x: {column: 'Zug (kgf)', unit: kgf}   # always 0.5 kgf, 2 samples; by its unit alone" in text
    )


def test_a_unit_is_that_of_the_name_the_header_or_the_values_and_else_asked_about(tmp_path, capsys):
    asked = "'?'"
    slow, fast = 300.0 * SWEEP, 3000.0 * SWEEP
    for header, values, unit in [
        # what 300 may be: rad/s or rpm
        ("rpm", slow, "rpm"), ("RPM", slow, "rpm"), ("n_rpm", slow, "rpm"), ("n_RPM", slow, "rpm"),
        ("motorRPM", slow, "rpm"),
        ("MotorRPM", slow, "rpm"), ("rpm1", slow, "rpm"), ("motor_rpm_1", slow, "rpm"), ("krpm", SWEEP, "krpm"),
        ("n [rpm]", slow, "rpm"), ("n (rpm)", slow, "rpm"), ("n [U/min]", slow, "rpm"),
        ("n [1/min]", slow, "'1/min'"),
        ("Speed (rev/min)", slow, "rev/min"), ("n [rad/s]", slow, "rad/s"), ("speed_rad_s", slow, "rad/s"),
        ("n", slow, asked), ("speed", slow, asked), ("n [furlong]", slow, asked), ("n", fast, asked),
        ("speed", 3 * fast, asked),
        # forces, torques and milli-units
        ("thrust", 30 * SWEEP, asked), ("thrust_N", 30 * SWEEP, "N"), ("thrust_kgf", SWEEP, "kgf"),
        ("thrust_kg", SWEEP, "kgf"),
        ("Thrust [gf]", fast, "gf"), ("thrust_g", fast, "gf"), ("force_mN", fast, "mN"), ("load", fast, asked),
        ("torque", SWEEP, asked), ("torque_mNm", fast, "mN m"), ("Torque (Nm)", SWEEP, "Nm"),
        ("Mx_lbf_in", SWEEP, "lbf in"),
        ("Torque [N.m]", SWEEP, "N m"), ("torque [N mm]", fast, "N mm"), ("Thrust [g]", fast, "g"),
        ("n [rad s^-1]", slow, "rad/s"), ("n [rad·s⁻¹]", slow, "rad/s"), ("n [min⁻¹]", slow, "rpm"),
        ("battery", 16000 + slow, asked), ("battery", 48000 + slow, "mV"),
        ("VOLT", 1600 + SWEEP, "cV"), ("voltage_mV", fast, "mV"), ("voltage", 16 + SWEEP, "V"),
        ("current", fast, asked), ("current", 20 * fast, "mA"),
        ("current_ma", SWEEP, "mA"), ("current", 3 + SWEEP, "A"), ("flow", SWEEP, "m/s"),
        ("flow_cm_s", SWEEP, "cm/s"),
        ("flow", slow, asked), ("flow", 9 * SWEEP, asked), ("flow", 20 * SWEEP, "cm/s"),
        # commands
        ("pwm", 1500 + slow, "us"), ("cmd", 1500 + slow, "us"), ("pwm", 128 + 100 * SWEEP, asked),
        ("throttle", SWEEP, "'1'"),
        ("throttle", 90 * SWEEP, asked), ("esc_percent", 90 * SWEEP, "'%'"), ("u", 3 * SWEEP, "V"),
        ("u_mV", fast, "mV"),
    ]:  # fmt: skip
        told = guessed(tmp_path, capsys, f"time,{header}", values)
        entry = re.search(r"^thruster_0/\S+: \{column: .*?, unit: ([^,}]*)", told.out, re.MULTILINE)
        assert entry is not None, f"{header}: nothing proposed:\n{told.out}"
        assert entry[1] == unit, header
        assert ("write the unit: " in told.out) == (unit == asked)
        assert told.err == (
            "note: units to be written by you, where neither name nor values tell: 1\n" * (unit == asked)
        )


def test_the_unit_of_a_time_is_that_of_its_name_or_its_steps_and_else_asked_about(tmp_path, capsys):
    at = np.arange(SWEEP.size) * 0.02
    name, values, asked = "unit by its name", "unit by its values", "write the unit: "
    for header, times, unit, whence in [
        ("t", at, "s", values), ("t", 1e3 * at, "ms", values), ("t", 1e6 * at, "us", values),
        ("t", 1e9 * at, "ns", values), ("t", 1.7e12 + 1e3 * at, "ms", values),
        ("time_ms", at, "ms", name), ("t_ms", at, "ms", name), ("t_s", 100 * at, "s", name),
        ("time [ms]", at, "ms", ""), ("time_s", 100 * at, "s", name), ("t", 50 * at, "'?'", asked),
        ("timestamp", 5e4 * at, "'?'", asked), ("stamp", 1.7e9 + 50 * at, "s", values),
    ]:  # fmt: skip
        told = guessed(tmp_path, capsys, f"{header},rpm", 300 * SWEEP, times)
        found = re.search(r"^time: \{column: .*, unit: (.*?)\}(.*)", told.out, re.MULTILINE)
        assert found[1] == unit, (header, times[1])
        assert found[2].startswith(f"   # {whence}") if whence else found[2] == "", (header, times[1])


def test_a_line_of_units_below_the_names_is_read(tmp_path, capsys):
    rows = "".join(f"{20 * k},{300 * value!r},{value!r}\n" for k, value in enumerate(SWEEP.tolist()))
    (tmp_path / "x.csv").write_text("t,n,thrust\n[ms],[rpm],kgf\n" + rows)
    text = proposal(capsys, tmp_path / "x.csv")
    assert "time: {column: t, unit: ms}" in text
    run = imported(tmp_path, text, tmp_path / "x.csv")
    np.testing.assert_allclose(run["thruster_0/state.n"].values, 300 * SWEEP * 2 * np.pi / 60, rtol=1e-6)
    np.testing.assert_allclose(run["thruster_0/load.wrench.force.x"].values, 9.80665 * SWEEP, rtol=1e-6)
    # names in two lines are no units
    (tmp_path / "x.csv").write_text("t,n\nfront,left\n0,1\n")
    assert "no numbers" in proposal(capsys, tmp_path / "x.csv")


@pytest.mark.parametrize("name", ["Kraftmessdose [mV]", "load_cell_mV", "thrust (V)", "force_mV"])
def test_a_load_cell_in_volts_is_asked_for_its_scale_and_offset_and_so_says_the_refusal(tmp_path, capsys, name):
    table = wide(tmp_path / "x.csv", {"t_s": np.arange(SWEEP.size) * 0.02, name: 2.0 * SWEEP, "u_V": SWEEP})
    found, _ = proposed(capsys, table)
    entry = found["thruster_0/load.wrench.force.x"]
    unit = "V" if name.endswith("(V)") else "mV"
    assert "unit: '?'}" in entry
    assert f"write unit: N, scale: its N for each {unit}, offset: -scale times the {unit} without load" in entry
    text = f"time: {{column: t_s, unit: s}}\nthruster_0/load.wrench.force.x: {{column: '{name}', unit: mV}}\n"
    assert attempted(tmp_path, text, table) == 1
    assert "found 'mV'; of an amplifier say `unit: N`, with `scale` and `offset`" in capsys.readouterr().err


def test_what_is_asked_about_is_refused_until_it_is_written(tmp_path, capsys):
    text = guessed(tmp_path, capsys, "t,n", 300.0 * SWEEP, np.arange(SWEEP.size) * 1.0).out
    assert attempted(tmp_path, text, tmp_path / "x.csv") == 1
    told = capsys.readouterr().err
    assert "time: unit is still '?': expected that of the recording, which nothing in it tells: one of s, ms" in told
    assert "thruster_0/state.n: unit is still '?': expected that of the recording" in told
    assert "rad/s, rpm" in told
    assert not (tmp_path / "run").exists()
    written = text.replace("t, unit: '?'", "t, unit: s").replace("n, unit: '?'", "n, unit: rpm")
    assert attempted(tmp_path, written, tmp_path / "x.csv") == 0


def test_columns_whose_names_no_rule_knows_are_guessed_by_their_units(tmp_path, capsys):
    rows = [f"{10 * (k - k % 2)},{u:g},{300 * u:g},{4 * u:g}" for k, u in enumerate(SWEEP)]  # two rows have one stamp
    (tmp_path / "x.csv").write_text("\n".join(["Zeit (ms),Stellung (%),Welle (rpm),Zug (N)", *rows]))
    text = proposal(capsys, tmp_path / "x.csv")
    assert "time: {column: 'Zeit (ms)', unit: ms}" in text and "Not recognised" not in text
    for channel, unit in (("throttle.commanded", "'%'"), ("state.n", "rpm"), ("load.wrench.force.x", "N")):
        (line,) = (line for line in text.splitlines() if line.startswith(f"thruster_0/{channel}"))
        assert f"unit: {unit}" in line and "by its unit alone: is it?" in line


def test_two_columns_of_one_unit_without_a_known_name_are_left_to_the_reader(tmp_path, capsys):
    rows = [f"{0.01 * k},{u:g},{u:g}" for k, u in enumerate(SWEEP)]
    (tmp_path / "x.csv").write_text("\n".join(["t,Druck (N),Zug (N)", *rows]))
    assert "wrench" not in proposal(capsys, tmp_path / "x.csv")


@pytest.mark.parametrize(("first", "second"), [("t u", "t n"), ("cmd_ms", "enc_ms")])
def test_each_sensor_of_a_table_may_have_a_time_of_its_own(tmp_path, capsys, first, second):
    rows = [f"{20 * k},{u:g},{20 * k + 4},{60 * u:g}" for k, u in enumerate(SWEEP)]
    rows += [f"{20 * k},0,," for k in range(len(rows), len(rows) + 50)]  # the shorter columns end in empty cells
    (tmp_path / "x.csv").write_text("\n".join([f"{first},u_V,{second},omega (rad/s)", *rows]))
    text = proposal(capsys, tmp_path / "x.csv")
    assert f"time: {{column: {first}, unit: ms}}" in text and "Not recognised" not in text
    entry = next(line for line in text.splitlines() if line.startswith("thruster_0/state.n"))
    assert f"time_column: {second}, time_unit: ms" in entry
    run = imported(tmp_path, text, tmp_path / "x.csv")
    assert run.time("thruster_0/state.n")[[0, -1]] == pytest.approx([0.004, 0.02 * SWEEP.size - 0.016])


def test_a_column_that_falls_is_no_time_and_one_that_rises_as_the_time_does_is_no_force(tmp_path, capsys):
    at = np.arange(SWEEP.size) * 0.02 + 396.7
    thrust = {"t_cmd": at, "u_V": 4 * SWEEP, "t_n": at + 0.004, "omega [rad/s]": 90 * SWEEP, "t_T": at, "T": 5 * SWEEP}
    found, text = proposed(capsys, wide(tmp_path / "x.csv", thrust))
    assert found["time"].startswith("{column: t_cmd, unit: s}") and len(found) == 3
    assert "time_column: t_n" in found["thruster_0/state.n"] and "# T -5 to 5" in text
    common = {"t": at, "u_V": 4 * SWEEP, "t_n": at + 0.004, "omega [rad/s]": 90 * SWEEP}
    found, text = proposed(capsys, wide(tmp_path / "y.csv", common))
    assert found["time"].startswith("{column: t, unit: s}") and len(found) == 3 and "Not recognised" not in text
    assert "time_column: t_n" in found["thruster_0/state.n"]
    assert "time_column" not in found["thruster_0/throttle.commanded"]
    _, text = proposed(capsys, wide(tmp_path / "z.csv", {"t": at, "f_ms": 7 * at, "u_V": 4 * SWEEP}))
    assert "# f_ms" in text and "time_column" not in text


@pytest.mark.parametrize(
    ("name", "entry"),
    [
        ("stream_kn", "thruster_0/flow.ambient: {column: stream_kn, unit: kn}"),
        ("thrust_kn", "thruster_0/load.wrench.force.x: {column: thrust_kn, unit: kN}"),
        ("pull_kN", "thruster_0/load.wrench.force.x: {column: pull_kN, unit: kN}"),
        ("rev_per_s", "thruster_0/state.n: {column: rev_per_s, unit: rps}"),
        ("v_kn", "# v_kn -0.5 to 0.5"),
        ("speed_kn", "# speed_kn -0.5 to 0.5"),
        ("stick", "throttle.commanded: {column: stick, unit: '1', stop: 0, per_volt: 0.2, hold: previous}"),
        ("dac", "thruster_0/throttle.commanded: {column: dac, unit: '1'"),
    ],
)
def test_letters_of_a_unit_count_as_they_are_written_and_where_the_channel_can_be_in_it(tmp_path, capsys, name, entry):
    table = wide(tmp_path / "x.csv", {"t": np.arange(SWEEP.size) * 0.02, name: 0.5 * SWEEP})
    assert entry in proposal(capsys, table)


def test_names_with_a_number_inside_are_thrusters_and_units_at_their_end_tell_what_they_are(tmp_path, capsys):
    names = [f"{kind}{i}{end}" for kind, end in (("M", "_cmd [%]"), ("esc", "_rpm")) for i in (1, 2, 3)]
    rows = [",".join(f"{30 * np.sin(k / 9 + j):.3f}" for j in range(9)) for k in range(60)]
    header = ",".join(["t_ms", *names, "gx_dps", "gy_dps", "gz_dps"])
    (tmp_path / "dive.csv").write_text("\n".join([header, *(f"{20 * k},{row}" for k, row in enumerate(rows))]))
    text = proposal(capsys, tmp_path / "dive.csv")
    for i in range(3):
        assert f"thruster_{i}/throttle.commanded: {{column: 'M{i + 1}_cmd [%]', unit: '%'" in text
        assert f"thruster_{i}/state.n: {{column: esc{i + 1}_rpm, unit: rpm}}" in text
    assert "rov/imu.angular_velocity.x: {column: gx_dps" in text and "Not recognised" not in text
    bench = [f"{k / 50:.2f},{3 * u:.3f},{90 * u:.2f},{9 * u:.3f},{u:.3f}" for k, u in enumerate(SWEEP)]
    (tmp_path / "bench.csv").write_text("\n".join(["t_s,Stellwert_pct,Drehzahl_rpm,Schub_N,U_mps", *bench]))
    text = proposal(capsys, tmp_path / "bench.csv")
    assert "throttle.commanded: {column: Stellwert_pct" in text and "force.x: {column: Schub_N, unit: N}" in text
    assert "# U_mps" in text, "a speed is no command"


def test_a_first_column_that_rises_is_proposed_as_the_time_whatever_it_is_called(tmp_path, capsys):
    rows = [f"{0.01 * k},{300 * u:g}" for k, u in enumerate(SWEEP)]
    (tmp_path / "x.csv").write_text("\n".join(["Zeit_s,rpm", *rows]))
    text = proposal(capsys, tmp_path / "x.csv")
    assert "time: {column: Zeit_s, unit: s}   # unit by its name; its values rise: is it the time?" in text
    assert "Not recognised" not in text


def test_a_pulse_s_scale_is_marked_as_a_guess(tmp_path, capsys):
    text = guessed(tmp_path, capsys, "t,pwm_us", 1500.0 + 400.0 * SWEEP).out
    (line,) = (line for line in text.splitlines() if "throttle.commanded" in line)
    assert "stop: 1500, per_volt: 80" in line and "stop and per_volt are guesses: write yours" in line


@pytest.mark.parametrize("header", ["t,u_V", "t,pwm_us"])
def test_a_hold_that_no_recording_tells_is_marked_as_a_guess(tmp_path, capsys, header):
    text = guessed(tmp_path, capsys, header, 1500.0 + 400.0 * SWEEP).out
    (line,) = (line for line in text.splitlines() if "throttle.commanded" in line)
    assert "hold: previous" in line and "hold is a guess: previous or linear?" in line


def test_a_column_called_t_is_no_time_where_its_unit_is_a_force(tmp_path, capsys):
    rows = [f"{0.01 * k},{u:g},{4 * u:g}" for k, u in enumerate(SWEEP)]
    (tmp_path / "x.csv").write_text("\n".join(["clock,u,T", "s,V,N", *rows]))
    text = proposal(capsys, tmp_path / "x.csv")
    assert "time: {column: clock, unit: s}" in text
    assert "thruster_0/load.wrench.force.x: {column: T, unit: N}" in text


@pytest.mark.parametrize("header", ["# bench 3\n# t in s\nt,n_rpm", "# bench 3\n# t,n_rpm"])
def test_comments_before_a_table_are_no_rows_and_the_last_one_may_name_the_columns(tmp_path, capsys, header):
    rows = [f"{0.01 * k},{300 * u:g}" for k, u in enumerate(SWEEP)]
    (tmp_path / "x.csv").write_text("\n".join([header, *rows]))
    text = proposal(capsys, tmp_path / "x.csv")
    assert "time: {column: t, unit: s}" in text
    assert f"thruster_0/state.n: {{column: n_rpm, unit: rpm}}   # -300 to 300, {SWEEP.size} samples" in text
