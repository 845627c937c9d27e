"""Which channel is proposed for a name of a vehicle's tables."""

import numpy as np
import pytest
from map_import import imported, proposed, wide
from rocking_vehicle import FORCE, GYRO, PULSES, TIME, WAVE


def test_dotted_names_of_a_long_table_with_units_are_a_vehicle_s(tmp_path, capsys):
    angles = {"roll": 10 * WAVE, "pitch": 5 * WAVE, "yaw": 170 * WAVE}
    readings = [(f"thr{k}.cmd", "V", 2.0 * np.sin(TIME + k)) for k in range(3)] + [("depth", "m", 5.0 + WAVE)]
    readings += [(f"imu.{name}", "deg/s", values) for name, values in GYRO.items()]
    readings += [(f"imu.{name}", "m/s^2", values) for name, values in FORCE.items()]
    readings += [(f"att.{name}", "deg", values) for name, values in angles.items()]
    rows = [f"{t:.3f},{name},{v[k]:.6g},{unit}" for k, t in enumerate(TIME) for name, unit, v in readings]
    (tmp_path / "x.csv").write_text("\n".join(["time,signal,value,unit", *rows]))
    found, text = proposed(capsys, tmp_path / "x.csv")
    assert "Not recognised" not in text and "'?'" not in text
    for k in range(3):
        assert f"thr{k}.cmd [V]" in found[f"thruster_{k}/throttle.commanded"]
    assert "depth [m]" in found["rov/depth.depth"]
    assert "imu.gz [deg/s]" in found["rov/imu.angular_velocity.z"]
    assert "imu.ax [m/s^2]" in found["rov/imu.linear_acceleration.x"]
    assert "att.roll [deg]" in found["rov/imu.orientation.roll"], "only a log's own ATT.Roll is an autopilot's"
    run = imported(tmp_path, text, tmp_path / "x.csv")
    np.testing.assert_allclose(run["rov/imu.angular_velocity.x"].values, np.radians(GYRO["gx"]), rtol=1e-4, atol=1e-6)


def test_a_number_before_or_behind_the_dot_is_the_thruster_s(tmp_path, capsys):
    columns = {f"thr{k}.n [rpm]": 900 * WAVE for k in (1, 2)} | {f"cmd.u{k}": 2 * WAVE for k in (1, 2)}
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **columns}))
    for k in (1, 2):
        assert f"'thr{k}.n [rpm]'" in found[f"thruster_{k - 1}/state.n"]
        assert f"cmd.u{k}" in found[f"thruster_{k - 1}/throttle.commanded"]


@pytest.mark.parametrize(
    ("names", "values", "entry", "why"),
    [
        ("M{}", PULSES, "unit: us, stop: 1500", "by its values alone: is it?"),
        ("motor{}_us", PULSES, "unit: us, stop: 1500", "by its unit alone: is it?"),
        ("thrust_pct_{}", np.round(57 * WAVE), "unit: '%', stop: 0", "by its unit alone: is it?"),
        ("M{} [%]", 57 * WAVE, "unit: '%', stop: 0", "by its unit alone: is it?"),
        ("thrust{} [%]", 57 * WAVE, "unit: '%', stop: 0", "by its unit alone: is it?"),
    ],
)
@pytest.mark.parametrize("more", [GYRO, {"depth": 5 + WAVE}])
def test_columns_that_differ_by_a_number_are_commands_by_their_unit_or_their_pulses(
    tmp_path, capsys, names, values, entry, why, more
):
    commands = {names.format(k): values for k in (1, 2, 3)}
    found, text = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **commands, **more}))
    for k in (1, 2, 3):
        told = found[f"thruster_{k - 1}/throttle.commanded"]
        assert names.format(k) in told and entry in told and why in told
    assert "wrench" not in text and "Not recognised" not in text


@pytest.mark.parametrize(
    "columns",
    [
        {f"p{k}": 1500.5 + 200 * WAVE for k in (1, 2)},  # no timer's counts
        {f"M{k}": PULSES - 300 * k for k in (1, 4)},  # one of them is far from any pulse
        {f"{name}{k}": PULSES for name in ("M", "T") for k in (1, 2)},  # which of them?
        {f"p{k}_mbar": PULSES for k in (1, 2)} | {f"pwm_{k}": PULSES for k in (1, 2)},  # the commands are known
        {"M1": PULSES},
    ],
)
def test_what_may_be_something_else_is_left_to_the_reader(tmp_path, capsys, columns):
    found, text = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **columns, **GYRO}))
    assert all("pwm" in entry for channel, entry in found.items() if channel.endswith("commanded"))
    assert "Not recognised" in text


def test_a_name_that_ends_in_another_quantity_s_unit_is_no_such_channel(tmp_path, capsys):
    columns = {"thrust_pct": 57 * WAVE, "battery_pct": 80 + WAVE, "esc_degC": 30 + WAVE, "acc_x_ms2": WAVE}
    columns |= {"vel_x_ms": WAVE, "dvl_v": WAVE, "depth_cm": 500 + WAVE}
    found, text = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **columns, **GYRO}))
    assert set(found) > {"rov/velocity.twist.twist.linear.x", "rov/velocity.twist.twist.linear.y", "rov/depth.depth"}
    assert all(f"# {name} " in text for name in ("thrust_pct", "battery_pct", "esc_degC"))


def test_heights_turns_a_second_and_velocities_in_mm_s_are_known(tmp_path, capsys):
    columns = {f"rps_{k}": 20 * WAVE for k in (1, 2)} | {f"pwm_{k}": PULSES for k in (1, 2)} | {"z_enu": -5 + WAVE}
    columns |= {f"{name}_mm_s": 200 * WAVE for name in "uvw"}
    file = wide(tmp_path / "x.csv", {"t_s": TIME, **columns})
    _, text = proposed(capsys, file)
    run = imported(tmp_path, text, file)
    np.testing.assert_allclose(run["thruster_1/state.n"].values, 40 * np.pi * WAVE, rtol=1e-4)
    np.testing.assert_allclose(run["rov/velocity.twist.twist.linear.z"].values, 0.2 * WAVE, rtol=1e-4)
    np.testing.assert_allclose(run["rov/depth.depth"].values, 5 - WAVE, rtol=1e-4)
    assert "Not recognised" not in text


@pytest.mark.parametrize(
    ("name", "pascals"),
    [("pressure_mbar", 100), ("press_abs_hPa", 100), ("Pressure [bar]", 1e5), ("abs_pressure (Pa)", 1)],
)
def test_a_pressure_is_proposed_as_a_depth_in_fresh_water(tmp_path, capsys, name, pascals):
    depth = 6.0 + WAVE
    pressure = (101325.0 + 9806.65 * depth) / pascals
    file = wide(tmp_path / "x.csv", {"t_s": TIME, name: pressure, **{f"{k}_dps": rate for k, rate in GYRO.items()}})
    found, text = proposed(capsys, file)
    assert "of fresh water, offset that of 1013 mbar at the surface: write yours" in found["rov/depth.depth"]
    run = imported(tmp_path, text, file)
    np.testing.assert_allclose(run["rov/depth.depth"].values, depth, atol=0.01)


def test_a_pressure_is_no_depth_beside_one_or_without_a_unit(tmp_path, capsys):
    columns = {"pressure_mbar": 1600 + WAVE, "depth": 6 + WAVE, **GYRO}
    found, text = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **columns}))
    assert found["rov/depth.depth"].startswith("{column: depth,") and "# pressure_mbar" in text
    found, text = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, "pressure": 1600 + WAVE, **GYRO}))
    assert "rov/depth.depth" not in found and "# pressure " in text


@pytest.mark.parametrize(
    ("name", "channel"),
    [
        ("adv", "flow.ambient"), ("Strömung", "flow.ambient"), ("Stroemung", "flow.ambient"), ("Drehzahl", "state.n"),
        ("Kraft", "load.wrench.force.x"), ("Schub", "load.wrench.force.x"), ("Moment", "load.wrench.torque.x"),
        ("Drehmoment", "load.wrench.torque.x"), ("SollWert", "throttle.commanded"), ("setpoint", "throttle.commanded"),
        ("Spannung", "state.supply_voltage"), ("Strom", "state.current"), ("bat/u", "state.supply_voltage"),
        ("Batterie U [V]", "state.supply_voltage"), ("bat/i", "state.current"), ("VOLT", "state.supply_voltage"),
        ("rotor", "state.n"), ("drive", "throttle.commanded"), ("Soll", "throttle.commanded"), ("Drehgeber", "state.n"),
        ("Kraftmessdose", "load.wrench.force.x"), ("ampere", "state.current"),
    ],
)  # fmt: skip
def test_names_of_laboratories_are_known(tmp_path, capsys, name, channel):
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, name: 12.0 + WAVE}))
    assert f"thruster_0/{channel}" in found


def test_german_names_of_a_vehicle_are_known(tmp_path, capsys):
    columns = {f"Stellwert {k} [%]": 60 * WAVE for k in (1, 2)}
    columns |= {f"Drehrate {a[1]} [deg/s]": rate for a, rate in GYRO.items()}
    columns |= {f"Beschleunigung {a[1]} [m/s^2]": force for a, force in FORCE.items()}
    columns |= {
        "Rollen [deg]": 9 * WAVE,
        "Nicken [deg]": 5 * WAVE,
        "Kurs [deg]": 90 * WAVE,
        "Wasserdruck_mbar": 1600 + WAVE,
    }
    found, text = proposed(capsys, wide(tmp_path / "x.csv", {"Zeit [s]": TIME, **columns}))
    assert "Not recognised" not in text
    assert "'Drehrate z [deg/s]'" in found["rov/imu.angular_velocity.z"]
    assert "'Beschleunigung z [m/s^2]'" in found["rov/imu.linear_acceleration.z"]
    for angle, name in (("roll", "Rollen"), ("pitch", "Nicken"), ("yaw", "Kurs")):
        assert f"'{name} [deg]'" in found[f"rov/imu.orientation.{angle}"]
    assert "Wasserdruck_mbar" in found["rov/depth.depth"]


@pytest.mark.parametrize("name", ["ampere", "Strom", "amps"])
def test_a_column_that_is_called_as_its_unit_is_a_vehicle_s_current(tmp_path, capsys, name):
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, name: 3.0 + WAVE, **GYRO}))
    assert found["rov/battery.current"].startswith(f"{{column: {name}, unit: A, sign: -1}}")


@pytest.mark.parametrize(
    "name",
    [
        "Soll_Drehzahl",
        "rpm_setpoint",
        "target_thrust",
        "thrust_ref",
        "altitude",
        "rev",
        "adv_snr",
        "rotor_temp",
        "drive_id",
    ],
)
def test_what_is_wanted_is_not_measured_and_what_may_be_something_else_has_no_channel(tmp_path, capsys, name):
    found, text = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, name: 12.0 + WAVE, **GYRO}))
    assert f"# {name} " in text, found


def test_speeds_of_a_vehicle_are_known_by_their_unit_where_there_are_as_many_as_commands(tmp_path, capsys):
    commands = {f"u{k} [%]": 50 * WAVE for k in (1, 2, 3)}
    turns = {f"rot{k} [rpm]": 900 + 100 * WAVE for k in (1, 2, 3)}
    found, text = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **commands, **turns, **GYRO}))
    for k in (1, 2, 3):
        assert found[f"thruster_{k - 1}/state.n"].startswith(f"{{column: 'rot{k} [rpm]', unit: rpm}}")
        assert "by its unit alone: is it?" in found[f"thruster_{k - 1}/state.n"]
    assert "Not recognised" not in text
    for other in ({f"fan{k} [rpm]": 900 + WAVE for k in (1, 2, 3)}, {"rot4 [rpm]": 900 + WAVE}):
        found, text = proposed(capsys, wide(tmp_path / "y.csv", {"t": TIME, **commands, **turns, **other, **GYRO}))
        assert "Not recognised" in text and not any(channel.endswith("state.n") for channel in found), "which of them?"


@pytest.mark.parametrize(
    ("columns", "name"),
    [
        ({"keller [m]": 5 + WAVE}, "keller [m]"),
        ({"keller [cm]": 500 + WAVE, "dvl_alt [m]": 3 + WAVE, "x [m]": WAVE, "y [m]": WAVE}, "keller [cm]"),
        ({"keller [m]": 5 + WAVE, "bar30 [m]": 5 + WAVE}, ""),  # which of them?
        ({"height [m]": 5 + WAVE}, ""),
        ({"keller_m": 5 + WAVE}, ""),  # of a name that is not known the end may be anything
    ],
)
def test_the_one_length_of_a_vehicle_is_a_depth_by_its_unit(tmp_path, capsys, columns, name):
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **columns, **GYRO}))
    entry = found.get("rov/depth.depth", "")
    assert (f"column: '{name}'" in entry and "by its unit alone: is it?" in entry) if name else not entry


def test_names_of_vehicles_logs_are_known_by_their_last_part_too(tmp_path, capsys):
    columns = {f"drive.{k}": 60 * WAVE for k in (0, 1)} | {f"thr{k}/rev": 14 * WAVE for k in (0, 1)}
    columns |= {f"ahrs.rate_{a}": 30 * WAVE for a in "xyz"}
    columns |= {f"ins/f{a[-1]}_mps2": force for a, force in FORCE.items()}
    columns |= {f"ahrs.{angle}": 12 * WAVE for angle in ("roll", "pitch", "yaw")} | {"keller.DPTH": 4 + WAVE}
    columns |= {f"twist_linear_{a}": 0.3 * WAVE for a in "xyz"} | {"bat/u": 21.0 + 0 * TIME, "bat/i": 3.0 + 0 * TIME}
    found, text = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **columns}))
    for channel, name in {
        "thruster_1/throttle.commanded": "drive.1", "thruster_1/state.n": "thr1/rev",
        "rov/imu.angular_velocity.z": "ahrs.rate_z", "rov/imu.orientation.yaw": "ahrs.yaw",
        "rov/depth.depth": "keller.DPTH", "rov/velocity.twist.twist.linear.y": "twist_linear_y",
        "rov/battery.voltage": "bat/u", "rov/battery.current": "bat/i",
    }.items():  # fmt: skip
        assert found[channel].startswith(f"{{column: {name},"), channel
    assert "sign: -1" in found["rov/battery.current"] and "unit: A" in found["rov/battery.current"]
    assert found["rov/imu.linear_acceleration.z"].startswith("{column: ins/fz_mps2, unit: m/s^2}")
    assert "Not recognised" not in text
    forces = {f"f{a[-1]}_mps2": force for a, force in FORCE.items()}
    found, _ = proposed(capsys, wide(tmp_path / "y.csv", {"t": TIME, **forces, **GYRO}))
    assert found["rov/imu.linear_acceleration.z"].startswith("{column: fz_mps2, unit: m/s^2}   # always -9.8")


def test_a_battery_and_a_velocity_log_are_known_by_further_names(tmp_path, capsys):
    columns = {"t": TIME, "Ubat [V]": 15.0 + 0 * TIME, "Ibat [A]": 3.0 + WAVE, **GYRO}
    ways = {"x": "forward", "y": "starboard", "z": "down"}
    columns |= {f"dvl_{way} [mm/s]": 300 * WAVE for way in ways.values()}
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", columns))
    assert found["rov/battery.voltage"].startswith("{column: 'Ubat [V]', unit: V}")
    assert found["rov/battery.current"].startswith("{column: 'Ibat [A]', unit: A, sign: -1}")
    for axis, way in ways.items():
        told = found[f"rov/velocity.twist.twist.linear.{axis}"]
        assert told.startswith(f"{{column: 'dvl_{way} [mm/s]', unit: mm/s}}")


@pytest.mark.parametrize("rate", ["rate_{}", "{}_rate", "{}_gyro", "gyro_{}", "ekf_vel_{}", "{}_dot"])
def test_a_name_with_a_word_of_turning_is_no_attitude(tmp_path, capsys, rate):
    angles = {"roll": 20 * WAVE, "pitch": 9 * WAVE, "yaw": 90 + 170 * WAVE}
    rates = {rate.format(angle): 1.5 * values for angle, values in angles.items()}
    columns = {"t": TIME, "pwm1": PULSES, "pwm2": PULSES}
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", {**columns, **rates, **angles}))
    for axis, angle in zip("xyz", angles, strict=True):
        assert f"column: {angle}," in found[f"rov/imu.orientation.{angle}"]
        gyro = found.get(f"rov/imu.angular_velocity.{axis}", "")
        assert f"column: {rate.format(angle)}," in gyro or "ekf" in rate or "dot" in rate
    found, text = proposed(capsys, wide(tmp_path / "y.csv", {**columns, **rates}))
    assert "orientation" not in text, "without an attitude they are none either"


def test_a_column_that_is_a_word_goes_before_one_that_has_it_also_of_another_file(tmp_path, capsys):
    angles = {"roll": 20 * WAVE, "pitch": 9 * WAVE, "yaw": 90 + 170 * WAVE}
    columns = {f"{angle}_err": 0.1 * values for angle, values in angles.items()}
    first = wide(tmp_path / "a.csv", {"t": TIME, "pwm1": PULSES, "pwm2": PULSES, **columns})
    found, text = proposed(capsys, first, wide(tmp_path / "b.csv", {"t": TIME, **angles}))
    for angle in angles:
        assert f"column: {angle}," in found[f"rov/imu.orientation.{angle}"] and f"# {angle}_err " in text
    found, _ = proposed(capsys, first)
    assert "column: roll_err," in found["rov/imu.orientation.roll"], "alone it is likely one"


def test_a_velocity_log_and_a_height_are_known_by_german_names_and_sides(tmp_path, capsys):
    for names in (
        ("v_vorn", "v_stb", "v_unten"),
        ("v_voraus", "v_steuerbord", "v_unten"),
        ("log_fwd", "log_stbd", "log_down"),
    ):
        columns = {f"{name} [kn]": 0.5 * WAVE for name in names} | {"Hoehe [mm]": -2500 + 300 * WAVE}
        found, text = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **columns, **GYRO}))
        for axis, name in zip("xyz", names, strict=True):
            entry = found[f"rov/velocity.twist.twist.linear.{axis}"]
            assert entry.startswith(f"{{column: '{name} [kn]', unit: kn}}")
        assert "rov/velocity: rep103" not in text, "down is ours"
        assert found["rov/depth.depth"].startswith("{column: 'Hoehe [mm]', unit: mm, sign: -1}")
        assert "a height by its values: is it?" in found["rov/depth.depth"]
    found, _ = proposed(capsys, wide(tmp_path / "y.csv", {"t": TIME, "Hoehe [m]": 2.5 + WAVE, **GYRO}))
    assert "rov/depth.depth" not in found, "above the ground"


@pytest.mark.parametrize(
    ("name", "values", "told"),
    [
        ("demand_volts{}", 3 * WAVE, True),
        ("motor{} [V]", 3 * WAVE, True),
        ("cell_volts{}", 3.7 + 0.1 * WAVE, False),
        ("dvl_v{}", 0.3 * WAVE, False),
        ("gauge{} [V]", 3 * WAVE, False),
    ],
)
def test_volts_to_both_sides_that_differ_by_a_number_are_commands(tmp_path, capsys, name, values, told):
    columns = {name.format(k): values for k in (1, 2, 3)}
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **columns, **GYRO}))
    assert [c for c in found if "commanded" in c] == [f"thruster_{k}/throttle.commanded" for k in range(3 * told)]
    if told:
        assert "unit: V, hold: previous" in found["thruster_0/throttle.commanded"]


def test_of_what_is_not_recognised_constants_stand_last_and_a_number_has_no_unit_1(tmp_path, capsys):
    columns = {"t": TIME, "health [1]": 1.0 + 0 * TIME, "oddity": WAVE, **GYRO}
    _, text = proposed(capsys, wide(tmp_path / "x.csv", columns))
    assert [line.split()[1] for line in text.splitlines()[-2:]] == ["oddity", "'health"]
    assert "# 'health [1]' always 1, 400 samples" in text


def test_an_attitude_at_other_times_than_the_gyro_s_is_asked_about(tmp_path, capsys):
    angles = {angle: 10 * np.sin(TIME + k) for k, angle in enumerate(("roll", "pitch", "heading"))}
    asked = "of this IMU? the vehicle's own, as an autopilot tells it, is rov/odometry.pose.pose.orientation"
    imu = wide(tmp_path / "imu.csv", {"t": TIME, **GYRO})
    found, _ = proposed(
        capsys, imu, wide(tmp_path / "ahrs.csv", {"t": TIME[::2], **{k: v[::2] for k, v in angles.items()}})
    )
    assert all(asked in found[f"rov/imu.orientation.{angle}"] for angle in ("roll", "pitch", "yaw"))
    _, text = proposed(capsys, wide(tmp_path / "one.csv", {"t": TIME, **GYRO, **angles}))
    assert "rov/imu.orientation.yaw" in text and asked not in text


def test_no_supply_is_negative_so_volts_to_both_sides_are_a_command(tmp_path, capsys):
    table = {"t": TIME, "volts": 3.5 * WAVE, "rpm": 900 * WAVE}
    found, text = proposed(capsys, wide(tmp_path / "x.csv", table))
    told = "{column: volts, unit: V, hold: previous}"
    assert found["thruster_0/throttle.commanded"].startswith(told) and "supply_voltage" not in text
    assert "unit by its name; hold is a guess: previous or linear?" in text
    found, _ = proposed(capsys, wide(tmp_path / "y.csv", table | {"volts": 16.0 - WAVE**2}))
    assert "volts" in found["thruster_0/state.supply_voltage"]
    found, _ = proposed(capsys, wide(tmp_path / "z.csv", table | {"volts": 16.0 * np.maximum(WAVE, -1e-3)}))
    assert "volts" in found["thruster_0/state.supply_voltage"], "an offset of its sensor is no sign"


def test_what_follows_a_question_is_a_sentence_of_its_own(tmp_path, capsys):
    columns = {"t": TIME, **{f"M{k}": PULSES for k in (1, 2)}}
    text = proposed(capsys, wide(tmp_path / "x.csv", columns))[1]
    assert "previous or linear? by its values alone: is it?" in text and "?;" not in text


def test_a_velocity_log_downwards_is_in_our_axes_and_one_without_all_axes_is_asked_about(tmp_path, capsys):
    log = {f"v_{way} [m/s]": 0.3 * WAVE for way in ("fwd", "stbd", "down")}
    found, text = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **log, **GYRO}))
    for axis, way in zip("xyz", ("fwd", "stbd", "down"), strict=True):
        assert found[f"rov/velocity.twist.twist.linear.{axis}"].startswith(f"{{column: 'v_{way} [m/s]', unit: m/s}}")
    assert "rov/velocity: rep103" not in text and "where are its other axes" not in text
    del log["v_stbd [m/s]"]
    found, _ = proposed(capsys, wide(tmp_path / "y.csv", {"t": TIME, **log, **GYRO}))
    asked = "where are its other axes? a diagnosis reads all three or none"
    assert [found[f"rov/velocity.twist.twist.linear.{axis}"].count(asked) for axis in "xz"] == [1, 1]


@pytest.mark.parametrize(
    ("name", "channel"),
    [
        ("U_soll", "throttle.commanded"),
        ("Sollspannung", "throttle.commanded"),
        ("voltage_setpoint", "throttle.commanded"),
        ("duty", "throttle.commanded"),
        ("enc", "state.n"),
        ("encoder [rpm]", "state.n"),
        ("Anstroemung [m/s]", "flow.ambient"),
        ("Anströmung", "flow.ambient"),
        ("v_innen", "flow.axial"),
        ("v_Duese [cm/s]", "flow.axial"),
        ("Strömung innen [m/s]", "flow.axial"),
        ("v_aussen", "flow.ambient"),
        ("v_außen", "flow.ambient"),
        ("tank [mm/s]", "flow.ambient"),
        ("outside_vel", "flow.ambient"),
        ("vel_mm", "flow.ambient"),
        ("revs [rev/s]", "state.n"),
        ("U_soll [m/s]", ""),
        ("encoder [deg]", ""),
        ("tank [degC]", ""),
        ("tank_temp", ""),
        ("T_innen", ""),
    ],
)
def test_a_bench_s_words_count_where_no_stated_unit_denies_them(tmp_path, capsys, name, channel):
    found, text = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, name: 0.7 * WAVE}))
    assert [each for each in found if each != "time"] == ([f"thruster_0/{channel}"] if channel else [])
    asked = " a speed? an encoder's angle is none" in text or " a speed? a count of turns is none" in text
    assert asked is (channel == "state.n")
    found, _ = proposed(capsys, wide(tmp_path / "y.csv", {"t": TIME, "enc": WAVE, "u_set": WAVE, **GYRO}))
    assert not any(each.startswith("thruster") for each in found), "a vehicle's encoder may be an arm's"
