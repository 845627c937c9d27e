"""What is proposed for the units and times of a vehicle's tables."""

import numpy as np
import pytest
from map_import import imported, proposed, wide
from rocking_vehicle import FORCE, GYRO, PULSES, TIME, WAVE

from run_bag.importers.guessed_units import guessed_unit


def test_a_slow_file_in_front_does_not_hide_the_unit_of_time_that_others_tell(tmp_path, capsys):
    slow = wide(tmp_path / "battery.csv", {"t": TIME[::25], "volts": 16.0 + 0 * TIME[::25]})
    found, _ = proposed(capsys, slow, wide(tmp_path / "imu.csv", {"t": TIME, **GYRO}))
    assert found["time"].startswith("{column: t, unit: s}")
    found, _ = proposed(capsys, slow, wide(tmp_path / "imu.csv", {"t": TIME[::25], "gx": WAVE[::25]}))
    assert found["time"].startswith("{column: t, unit: '?'}")


@pytest.mark.parametrize("name", ["t_pwm_cmd", "t_pwm", "t pwm"])
@pytest.mark.parametrize(("scale", "unit"), [(1.0, "s"), (1e3, "ms"), (1e6, "us")])
def test_the_unit_of_a_time_is_not_that_of_what_it_times(tmp_path, capsys, name, scale, unit):
    columns = {name: scale * TIME, "pwm_cmd": PULSES, "t_tacho": scale * (TIME + 0.007), "tacho": 900 * WAVE}
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", columns))
    assert found["time"].startswith(f"{{column: {name}, unit: {unit}}}   # unit by its values")
    assert f"time_column: t_tacho, time_unit: {unit}" in found["thruster_0/state.n"]
    assert "unit: us, stop: 1500" in found["thruster_0/throttle.commanded"]


def test_a_slow_time_has_the_unit_of_the_times_beside_it(tmp_path, capsys):
    slow = np.where(np.arange(TIME.size) % 50, np.nan, TIME + 0.01)  # one reading in a second: s or ms?
    columns = {"t_pwm": TIME, "pwm_1": PULSES, "t_bat": slow, "battery_V": 15.0 + 0 * slow}
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", columns | {"pwm_2": PULSES}))
    assert "time_column: t_bat, time_unit: s" in found["rov/battery.voltage"]
    alone = {"t_pwm": TIME[::50], "pwm_1": PULSES[::50], "pwm_2": PULSES[::50]}
    assert "unit: '?'" in proposed(capsys, wide(tmp_path / "y.csv", alone))[0]["time"]


def test_a_column_of_time_that_a_file_alone_has_is_not_left_over(tmp_path, capsys):
    most = wide(tmp_path / "a.csv", {"t": TIME, "pwm": PULSES, "tacho [rpm]": 900 * WAVE})
    own = wide(tmp_path / "b.csv", {"ms": 1e3 * TIME, "thrust [N]": 9 * WAVE})
    found, text = proposed(capsys, most, own)
    assert "time_column: ms, time_unit: ms" in found["thruster_0/load.wrench.force.x"]
    assert "Not recognised" not in text


def test_the_time_of_most_files_is_that_of_the_map(tmp_path, capsys):
    cell = wide(tmp_path / "a.csv", {"ms": 1e3 * TIME, "thrust [N]": 9 * WAVE})
    command = wide(tmp_path / "b.csv", {"t": TIME, "pwm": PULSES})
    speed = wide(tmp_path / "c.csv", {"t": TIME, "tacho [rpm]": 900 * WAVE})
    found, text = proposed(capsys, cell, command, speed)
    assert found["time"].startswith("{column: t, unit: s}") and text.count("time_column") == 1
    assert "time_column: ms, time_unit: ms" in found["thruster_0/load.wrench.force.x"]


@pytest.mark.parametrize("rate", [1000.0, 125.0])
def test_a_time_that_is_called_ms_is_in_ms_at_any_rate(tmp_path, capsys, rate):
    table = {"ms": np.arange(400) * 1e3 / rate, "thrust [N]": 9 * WAVE}
    assert proposed(capsys, wide(tmp_path / "x.csv", table))[0]["time"].startswith("{column: ms, unit: ms}")


@pytest.mark.parametrize(
    ("name", "values", "units"),
    [
        ("tacho", 8900 * WAVE, "rpm, deg/s or mrad/s"),
        ("gx", 816 * WAVE, "deg/s or mrad/s"),
        ("depth", 300 + 40 * WAVE, "m, cm, ft or dm"),
        ("depth", 3700 + 200 * WAVE, "cm, mm or dm"),
        ("battery", 16000 + WAVE, "mV or cV"),
        ("dvl_vx", 130 * WAVE, "cm/s or mm/s"),
        ("roll", 20 * WAVE, ""),
        ("gx", 5000 * WAVE, "mrad/s"),  # or a converter's counts
        ("az", 16384 + WAVE, "mm/s^2"),
    ],
)
def test_a_unit_is_told_by_values_only_where_one_alone_is_possible(tmp_path, capsys, name, values, units):
    columns = {"t": TIME, **{f"cmd{k}": 2 * WAVE for k in (1, 2)}, name: values}
    if name == "roll":
        columns |= {"pitch": values, "yaw": 170 * WAVE}
    _, text = proposed(capsys, wide(tmp_path / "x.csv", columns))
    (line,) = (line for line in text.splitlines() if f"column: {name}," in line)
    assert ("unit: '?'}" in line and f"write the unit: {units}?" in line) if units else "unit: deg}" in line


@pytest.mark.parametrize(("gravity", "unit"), [(1000.0, "mg"), (981.0, "cm/s^2"), (990.0, "'?'"), (9810.0, "mm/s^2")])
def test_gravity_tells_mg_from_cm_s2_where_it_is_near_one_of_them(tmp_path, capsys, gravity, unit):
    force = {name: values * gravity / 9.8 for name, values in {**FORCE, "ax": 0 * WAVE, "ay": 0 * WAVE}.items()}
    found, text = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **force, **GYRO}))
    assert f"unit: {unit}}}" in found["rov/imu.linear_acceleration.z"]
    assert ("write the unit: mg or cm/s^2? |a| is 990 as a rule" in text) == (unit == "'?'")


def test_units_of_headers_are_known_in_plain_letters(tmp_path, capsys):
    force = {f"{name} [m/s2]": values for name, values in FORCE.items()}
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **force, **GYRO}))
    assert found["rov/imu.linear_acceleration.x"].startswith("{column: 'ax [m/s2]', unit: m/s^2}")


def test_a_log_s_own_unit_of_a_heading_is_known():
    assert guessed_unit("rad", "ATT.Yaw", "degheading", 180 + WAVE, usual="deg") == ("deg", "")


def test_a_few_texts_among_numbers_are_proposed_as_marks_and_more_are_not(tmp_path, capsys):
    cells = [f"{15 + w:.3f}" for w in WAVE]
    cells[7], cells[9], states = "-", "n/a", ["on", "off"] * 200
    rows = [f"{t:.2f},{p:.0f},{c},{s}" for t, p, c, s in zip(TIME, PULSES, cells, states, strict=True)]
    (tmp_path / "x.csv").write_text("\n".join(["t,pwm,battery,state", *rows]))
    found, text = proposed(capsys, tmp_path / "x.csv")
    entry = found["thruster_0/state.supply_voltage"]
    assert entry.startswith("{column: battery, unit: V, nan: ['-', n/a]}   # 14 to 16, 398 samples; unit by its values")
    assert "# state no numbers" in text
    run = imported(tmp_path, text, tmp_path / "x.csv")
    assert np.isfinite(run["thruster_0/state.supply_voltage"].values).sum() == 398


@pytest.mark.parametrize(
    ("name", "low", "entry"),
    [
        ("water_pressure [dbar]", 0.0, "unit: dbar}"),
        ("Druck [bar]", 0.0, "unit: bar}"),
        ("pressure [mbar]", 1013.0, "unit: m, scale: 0.010197, offset: -10.3323}"),
    ],
)
def test_a_pressure_is_a_depth_and_no_flow_over_that_of_the_surface_by_its_unit_alone(
    tmp_path, capsys, name, low, entry
):
    columns = {"t": TIME, "pwm_1": PULSES, "pwm_2": PULSES, name: low + 0.4 + 0.1 * WAVE}
    found, text = proposed(capsys, wide(tmp_path / "x.csv", columns))
    assert entry in found["rov/depth.depth"] and "flow" not in text


def test_percent_about_50_rest_there(tmp_path, capsys):
    columns = {f"Motor {k} [%]": 50 + 20 * WAVE for k in (1, 2)} | {f"gyro_{a}_dps": WAVE for a in "xyz"}
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **columns}))
    assert "unit: '%', stop: 50, per_volt: 10, hold" in found["thruster_1/throttle.commanded"]
    columns = {f"Motor {k} [%]": np.maximum(90 * WAVE, 0) for k in (1, 2)} | {f"gyro_{a}_dps": WAVE for a in "xyz"}
    found, _ = proposed(capsys, wide(tmp_path / "y.csv", {"t": TIME, **columns}))
    assert "unit: '%', stop: 0, per_volt: 20, hold" in found["thruster_1/throttle.commanded"]


@pytest.mark.parametrize(
    ("values", "units"),
    [
        (np.round(51 * WAVE), "% or counts?"),
        (57.3 * WAVE, "write the unit: %?"),
        (1004 + np.round(900 * (1 + WAVE)), "counts or mV?"),
        (np.where(WAVE > 0, np.round(1500 + 300 * WAVE), 0), "us, counts or mV?"),
    ],
)
def test_units_in_which_no_command_is_so_large_are_not_asked_about(values, units):
    assert units in guessed_unit("V", "drive", "", values, command=True).why
