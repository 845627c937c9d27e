"""What is proposed for the tables that ulog2csv makes of a PX4's log, and of commands that never change."""

import numpy as np
from map_import import SWEEP, proposed, wide

TIME = np.arange(SWEEP.size) * 20_000.0 + 22_500_000.0
NOUGHT = np.zeros(SWEEP.size)


def test_outputs_and_escs_of_a_px4_on_a_bench_are_proposed_and_counters_are_not(tmp_path, capsys):
    outputs = {"timestamp": TIME, "noutputs": NOUGHT + 2}
    outputs |= {"output[0]": np.round(1500 + 263 * SWEEP), "output[1]": NOUGHT + 900}
    escs = {"timestamp": TIME + 637, "esc_count": NOUGHT + 1, "esc_armed_flags": np.sign(np.abs(SWEEP))}
    escs |= {"esc[0].esc_rpm": np.round(900 * SWEEP), "esc[0].esc_voltage": NOUGHT + 15.8, "esc[0].failures": NOUGHT}
    found, text = proposed(capsys, wide(tmp_path / "outputs.csv", outputs), wide(tmp_path / "escs.csv", escs))
    assert list(found) == [
        "time", "thruster_0/throttle.commanded", "thruster_0/state.n", "thruster_0/state.supply_voltage"
    ]  # fmt: skip
    assert found["thruster_0/throttle.commanded"].startswith("{column: 'output[0]', unit: us, stop: 1500, per_volt: 80")
    assert found["thruster_0/state.n"].startswith("{column: 'esc[0].esc_rpm', unit: rpm}")
    assert "# esc_count always 1" in text
    assert "# 'output[1]' always 900" in text


def test_each_esc_of_a_px4_is_its_own_thruster_s(tmp_path, capsys):
    escs = {"timestamp": TIME, **{f"output[{k}]": np.round(1500 + 263 * (-1) ** k * SWEEP) for k in range(4)}}
    escs |= {f"esc[{k}].esc_rpm": np.round(900 * SWEEP) for k in range(4)}
    found, _ = proposed(capsys, wide(tmp_path / "log.csv", escs))
    assert [f"thruster_{k}/state.n" in found for k in range(5)] == [True] * 4 + [False]
    assert [f"thruster_{k}/throttle.commanded" in found for k in range(5)] == [True] * 4 + [False]


def test_a_command_that_never_changes_goes_behind_one_that_moves_and_is_asked_about_alone(tmp_path, capsys):
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", {"t_us": TIME, "throttle": NOUGHT, "cmd": 4 * SWEEP}))
    assert found["thruster_0/throttle.commanded"].startswith("{column: cmd,")
    found, _ = proposed(capsys, wide(tmp_path / "y.csv", {"t_us": TIME, "throttle": NOUGHT, "n": 4 * SWEEP}))
    assert "never changes: is it the command?" in found["thruster_0/throttle.commanded"]


def test_what_is_not_recognised_tells_its_file_where_several_have_a_column_of_its_name(tmp_path, capsys):
    first = wide(tmp_path / "log_debug_vect_0.csv", {"timestamp": TIME, "x": 10 * SWEEP})
    _, text = proposed(capsys, first, wide(tmp_path / "log_debug_vect_1.csv", {"timestamp": TIME, "x": SWEEP}))
    assert "# x of log_debug_vect_0.csv: -10 to 10," in text


def test_controls_of_motors_are_commands_where_no_output_is(tmp_path, capsys):
    motors = wide(tmp_path / "a.csv", {"timestamp": TIME, "control[0]": 0.6 * SWEEP, "control[1]": NOUGHT})
    found, text = proposed(capsys, motors)
    told = "{column: 'control[0]', unit: '1', stop: 0, per_volt: 0.2, hold: previous}"
    assert found["thruster_0/throttle.commanded"].startswith(told) and "actuator_controls it is roll" in text
    assert "# 'control[1]' always 0" in text and "thruster_1" not in text
    outputs = wide(tmp_path / "b.csv", {"timestamp": TIME, "output[0]": np.round(1500 + 263 * SWEEP)})
    for files in ((motors, outputs), (outputs, motors)):
        found, text = proposed(capsys, *files)
        assert "column: 'output[0]'" in found["thruster_0/throttle.commanded"] and "# 'control[0]' -0.6 to 0.6" in text


def test_the_names_of_senders_are_listed_with_the_key_that_takes_their_rows(tmp_path, capsys):
    rows = [f"{20 * k},{('cell', 'flow')[k % 2]},{k % 7}" for k in range(40)]
    (tmp_path / "x.csv").write_text("\n".join(["timestamp,sender,x", *rows]))
    _, text = proposed(capsys, tmp_path / "x.csv")
    assert "# sender no numbers: cell, flow; `where: {sender: ...}` of an entry takes the rows of one" in text
    (tmp_path / "y.csv").write_text("\n".join(["timestamp,sender,x", '0,"a\nb: 1",0', *rows]))
    _, text = proposed(capsys, tmp_path / "y.csv")
    assert "# sender no numbers: 'a b: 1', cell, flow; " in text, "a cell never ends the comment"
