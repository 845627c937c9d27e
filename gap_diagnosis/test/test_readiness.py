"""`check`: what runs are good for, in a sentence each; 0 where they are usable, 1 where something would refuse them."""

from dataclasses import replace

import numpy as np
import pytest
from generated import campaign

from gap_diagnosis.blind_check.generator import Truth, generate
from gap_diagnosis.blind_check.signals import rich_campaign
from gap_diagnosis.blind_check.store_io import write_generated_run
from gap_diagnosis.cli_check import main
from gap_diagnosis.findings import Finding, lines_of
from gap_diagnosis.readiness import excitation, readiness
from gap_diagnosis.recording_io import recordings_of
from run_bag import Topic, read_run, write_run
from thruster_model.parameter_set_io import load_parameter_set

HL = load_parameter_set("hl")
CHANNELS = ("n", "ambient", "thrust", "torque")


def kinds(found, kind):
    return {": ".join(filter(None, (each.run, each.about))): each.sentence for each in found if each.kind == kind}


@pytest.fixture(scope="module")
def rich():
    return campaign(runs=2, duration=12.0)


@pytest.fixture(scope="module")
def ready(rich):
    stated, recordings = rich
    return readiness(recordings, stated)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A written recording of a thruster as stated."""
    rng = np.random.default_rng(5)
    programme = dict(list(rich_campaign(rng, duration=12.0).items())[:1])
    (made,) = generate(Truth(model="hl", parameters=dict(HL.values)), programme, closed_loop=False, seed=5)
    return write_generated_run(made, tmp_path_factory.mktemp("check"), CHANNELS)


def changed(run, path, **scales):
    """Write a run with some channels multiplied; return its path."""
    read = read_run(run)
    time = {kind: read.time(f"thruster_0/{kind}") for kind in ("throttle.commanded", "state.n", "load.wrench.force.x")}
    values = {kind: read[f"thruster_0/{kind}"].values * scales.get(kind.split(".")[0], 1.0) for kind in time}
    topics = [
        Topic.of_thruster(0, kind.split(".")[0], time[kind], {kind.partition(".")[2]: values[kind]}) for kind in time
    ]
    signs = np.ones(values["state.n"].size)
    topics[1] = replace(topics[1], fields={**topics[1].fields, "sign_source": signs})
    write_run(path, topics, {"hold": {"throttle": "previous"}})
    return path


def test_recordings_that_are_fine_are_refused_nothing(ready):
    assert not kinds(ready, "refused")
    assert set(kinds(ready, "good")) >= {f"sign and size of thruster_0/{c}" for c in ("state.n", "flow.ambient")}


def test_effects_that_would_show_and_those_of_a_channel_that_is_not_there_are_named(ready):
    shown = kinds(ready, "good")["effects that would show"]
    assert all(name in shown for name in ("command_delay", "dead_zone_shift", "load_cell_resonance"))
    assert "supply_sag" in shown
    assert "ventilation" in kinds(ready, "good")["effects that are looked for in the samples themselves"]


def test_effects_of_what_a_model_does_not_have_change_nothing():
    stated, recordings = campaign(runs=1, duration=12.0, channels=("n", "thrust"), model="simplified")
    idle = kinds(readiness(recordings, stated), "good")["effects that would change nothing"]
    assert "flow_lag" in idle and "ambient_current" in idle and "coulomb_friction" not in idle
    assert "flow_reversal_loss" in idle  # it shortens steps about a reversal all the same


def test_a_sensor_that_is_missing_takes_its_effects_away():
    stated, recordings = campaign(runs=1, duration=12.0, channels=("n",))
    blind = kinds(readiness(recordings, stated), "note")["effects that cannot be looked for"]
    assert "load_cell_resonance" in blind and "flow_spikes" in blind
    assert blind.endswith("; not measured: axial flow, ambient flow, thrust, torque") and "ventilation" in blind


def test_effects_of_thrust_that_nobody_measured_lack_a_sensor_and_no_part_of_the_model():
    stated, recordings = campaign(runs=1, duration=12.0, channels=("n",), model="simplified")
    found = readiness(recordings, stated)
    idle = kinds(found, "good")["effects that would change nothing"]
    blind, lacking = kinds(found, "note")["effects that cannot be looked for"].split("; not measured: ")
    for name in ("thrust_loss", "thrust_asymmetry", "cavitation", "axial_flow_loss"):
        assert name in blind and name not in idle
    assert lacking == "thrust, torque" and "flow_lag" in idle, "the model has no flow"
    assert "flow_spikes" in idle and "flow_spikes" not in blind, "and no sensor of it is missing"


def test_a_parameter_whose_only_sensor_is_missing_is_told_so_and_torque_is_no_note(tmp_path, capsys):
    programme = dict(list(rich_campaign(np.random.default_rng(5), duration=12.0).items())[:1])
    truth = Truth(model="simplified", parameters=dict(load_parameter_set("simplified").values))
    (made,) = generate(truth, programme, closed_loop=False, seed=5)
    run = write_generated_run(made, tmp_path, ("n",))
    assert main([str(run), "--set", "simplified"]) == 0
    lines = capsys.readouterr().out.splitlines()
    told = "c_T1, c_T2, delta_T1, delta_T2: only thrust would show it; not measured"
    assert f"? parameters of a fit without a sensor: {told}" in lines
    notes = [line for line in lines if line.startswith("? ")]
    of_fit = [line for line in notes if " a fit" in line.partition(":")[0]]
    assert 0 < len(of_fit) < len(notes), lines
    assert lines[-1] == f"usable: {len(notes)} notes (?), {len(of_fit)} of a fit alone"
    (torque,) = (line for line in lines if "parameter c_Q1 of a fit" in line)
    assert "not measured" not in torque, "the rotor tells its torque in this model"
    main([str(run), "--set", "yoerger"])
    said = capsys.readouterr().out
    assert "\n  parameters of a fit without a sensor: c_Q: only torque would show it; not measured\n" in said
    missing = "thruster_0/flow.axial, thruster_0/flow.ambient, thruster_0/load.wrench.torque.x"
    assert f"\n  not measured: {missing}\n" in said.replace(f"{run.name}: ", ""), "a model without flow needs none"


def test_what_is_as_loud_as_noise_is_said_to_hide(rich):
    stated, recordings = rich
    deaf = []
    for each in recordings:
        measurements = {name: replace(m, noise=1e4 * m.noise) for name, m in each.experiment.measurements.items()}
        deaf.append(replace(each, experiment=replace(each.experiment, measurements=measurements)))
    found = kinds(readiness(deaf, stated), "note")
    assert "command_delay" in found["effects that would not show"]


def test_excitation_counts_range_dead_zone_and_reversals(rich):
    recording = rich[1][0]
    steps = np.repeat([0.0, 2.0, -2.0, 0.5, 3.0], 100)
    experiment = replace(recording.experiment, throttle=steps, dt=0.01)
    found = excitation(replace(recording, experiment=experiment), HL)
    assert "-2 to 3 V over 5.0 s, 40 % of the time" in found.sentence
    assert "(-0.83 to 0.86 V), 2 reversals" in found.sentence and found.kind == "good"
    one_way = excitation(replace(recording, experiment=replace(experiment, throttle=np.abs(steps))), HL)
    assert one_way.kind == "note" and "expected both directions in turn" in one_way.sentence


def test_noise_of_a_command_that_was_measured_reverses_nothing(rich):
    recording, stated = rich[1][0], load_parameter_set("static_quadratic")
    steps = np.repeat([0.0, 2.0, 0.0, -2.0, 0.0], 100) + 0.001 * np.random.default_rng(1).normal(size=500)
    found = excitation(replace(recording, experiment=replace(recording.experiment, throttle=steps, dt=0.01)), stated)
    assert "60 % of the time" in found.sentence and "1 reversals" in found.sentence


def test_the_supply_that_a_set_reads_is_listed_or_said_to_be_missing(run, tmp_path, capsys):
    read = read_run(run)
    assert main([str(run), "--set", "force_table"]) in (0, 1)
    assert "thruster_0/state.supply_voltage (nominal_supply counts)" in capsys.readouterr().out
    time, values = read.time("thruster_0/state.n"), read["thruster_0/state.n"].values
    supply = 15.0 + 0.1 * np.sin(time)
    topics = [
        Topic.of_thruster(0, "state", time, {"n": values, "supply_voltage": supply, "sign_source": 0 * time + 1}),
        Topic.of_thruster(
            0, "throttle", read.time("thruster_0/throttle.commanded"),
            {"commanded": read["thruster_0/throttle.commanded"].values},
        ),
    ]  # fmt: skip
    write_run(tmp_path / "x", topics, {"hold": {"throttle": "previous"}})
    assert main([str(tmp_path / "x"), "--set", "force_table"]) in (0, 1)
    told = capsys.readouterr().out
    assert "thruster_0/state.supply_voltage: " in told and "nominal_supply counts" not in told
    main([str(tmp_path / "x"), "--set", "hl"])
    assert "supply_voltage" not in capsys.readouterr().out


def test_a_vehicle_s_run_beside_a_set_of_a_thruster_is_told_what_is_meant(run, tmp_path, capsys):
    read = read_run(run)
    time = read.time("thruster_0/throttle.commanded")
    throttle = {"commanded": read["thruster_0/throttle.commanded"].values}
    speed = {"n": read["thruster_0/state.n"].values, "sign_source": np.ones(read["thruster_0/state.n"].values.size)}
    topics = [Topic.of_thruster(k, "throttle", time, throttle) for k in (0, 1)]
    topics.append(Topic.of_thruster(0, "state", read.time("thruster_0/state.n"), speed))
    depth = Topic(
        name="rov/depth", type="thruster_msgs/msg/Depth", stamps=topics[0].stamps, fields={"depth": 3 + 0 * time}
    )
    write_run(tmp_path / "x", [*topics, depth], {"hold": {"throttle": "previous"}})
    main([str(tmp_path / "x"), "--set", "hl"])
    assert (
        "2 thrusters and rov/depth: of a vehicle's run say `--vehicle` in place of `--set`" in capsys.readouterr().out
    )
    main([str(run), "--set", "hl"])
    assert "--vehicle" not in capsys.readouterr().out


def test_cross_talk_of_a_torque_that_a_model_does_not_have_changes_nothing():
    _, recordings = campaign(runs=1, duration=12.0, channels=("n", "thrust"), model="simplified")
    found = readiness(recordings, load_parameter_set("force_table"))
    assert "load_cell_crosstalk" in kinds(found, "good")["effects that would change nothing"]
    assert "load_cell_crosstalk" not in kinds(found, "note").get("effects that would not begin to act", "")


def test_a_usable_run_ends_with_0_and_says_rates_parameters_and_what_states_no_hold(run, capsys):
    assert main([str(run), "--set", "hl"]) == 0
    said = capsys.readouterr().out
    assert "thruster_0/state.n: " in said and "Hz), longest gap" in said
    assert "nothing says what it does in the" in said
    assert "parameters that a fit would determine: " in said and "k_n" in said
    assert said.splitlines()[-1].startswith("usable: ")


@pytest.mark.parametrize(
    ("channels", "told", "noted"),
    [
        (("n", "ambient", "thrust", "torque"), ["flow.axial"], []),
        (("n", "ambient", "thrust"), ["flow.axial", "load.wrench.torque.x"], []),
        (("n", "torque"), [], ["flow.axial", "flow.ambient", "load.wrench.force.x"]),
        (("n", "thrust"), ["load.wrench.torque.x"], ["flow.axial", "flow.ambient"]),
    ],
)
def test_one_flow_is_enough_and_torque_serves_itself_alone(channels, told, noted, tmp_path, capsys):
    programme = dict(list(rich_campaign(np.random.default_rng(5), duration=12.0).items())[:1])
    (made,) = generate(Truth(model="hl", parameters=dict(HL.values)), programme, closed_loop=False, seed=5)
    main([str(write_generated_run(made, tmp_path, channels)), "--set", "hl"])
    lines = [line for line in capsys.readouterr().out.splitlines() if ": not measured: " in line]
    missing = {line[:2]: set(line.split(": not measured: ")[1].split(", ")) for line in lines}
    for mark, names in (("  ", told), ("? ", noted)):
        assert missing.get(mark, set()) == {f"thruster_0/{name}" for name in names}


def test_a_coefficient_that_the_set_has_at_its_bound_and_the_data_keep_there_is_no_note(run, capsys):
    main([str(run), "--set", "hl"])
    (line,) = (line for line in capsys.readouterr().out.splitlines() if "parameter c_nv_Q of a fit" in line)
    assert line.startswith("  ") and "cannot be told from its bound, 0 N s^2" in line


def test_a_stated_hold_is_told(run, tmp_path, capsys):
    main([str(changed(run, tmp_path / "stated")), "--set", "hl"])
    said = capsys.readouterr().out
    assert "hold of the throttle: between two samples the run states `previous`" in said
    assert "nothing says what it does" not in said


def test_a_size_that_no_known_unit_explains_is_a_note_not_an_agreement(run, tmp_path, capsys):
    main([str(changed(run, tmp_path / "large", state=4.0)), "--set", "hl"])
    said = capsys.readouterr().out
    (line,) = [line for line in said.splitlines() if "sign and size of thruster_0/state.n" in line]
    assert line.startswith("? ") and "another unit" in line
    assert float(line.split(": ")[1].split()[0]) == pytest.approx(4.0, rel=0.02)


def test_a_load_cell_in_another_known_unit_is_told_as_such(run, tmp_path, capsys):
    assert main([str(changed(run, tmp_path / "pounds", load=1.0 / 4.4482)), "--set", "hl"]) == 0
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "sign and size of thruster_0/load" in line]
    assert line.startswith("? ") and "as if in pound-force: is the map's `unit` right?" in line


def test_readings_that_all_run_against_the_throttle_may_be_the_thruster_s(run, tmp_path, capsys):
    assert main([str(changed(run, tmp_path / "reversed", throttle=-1.0)), "--set", "hl"]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("? sign and size of ")]
    assert len(lines) == 2 and all("or a thruster that is: then diagnose it so" in line for line in lines)


def test_of_few_recordings_quarters_are_left_out_and_of_three_nothing_is_to_be_said(ready, rich):
    about = "left out in turn by a diagnosis"
    assert kinds(ready, "good")[about].startswith("a quarter of each recording; from 3 recordings on whole ones")
    stated, (one, other) = rich
    assert about not in kinds(readiness([one, other, one], stated), "good")


@pytest.mark.parametrize(
    ("scales", "sentence"),
    [
        ({"load": -1.0}, "diagnose would refuse: thruster_0/load.wrench.force.x: its sign is opposite"),
        ({"state": 30.0 / np.pi}, "thruster_0/state.n: readings are"),
        ({"throttle": 0.1}, "diagnose would refuse: the throttle never leaves the dead zone"),
    ],
)
def test_what_would_be_refused_ends_with_1_and_the_sentence(run, tmp_path, capsys, scales, sentence):
    path = changed(run, tmp_path / "changed", **scales)
    assert main([str(path), "--set", "hl"]) == 1
    said = capsys.readouterr().out
    assert sentence in said
    assert said.splitlines()[-1].startswith("not usable as it is: ")


def test_a_file_that_is_no_run_is_told_to_be_imported_first(tmp_path, capsys):
    (tmp_path / "log.csv").write_text("time,throttle\n0,1\n")
    assert main([str(tmp_path / "log.csv"), "--set", "hl"]) == 1
    assert "is imported first: thruster import" in capsys.readouterr().err


def test_a_run_is_read_as_a_diagnosis_reads_it(run):
    (recording,) = recordings_of(read_run(run))
    assert not kinds(readiness([recording], HL), "refused")


def test_what_holds_of_all_runs_is_one_line_and_one_note():
    found = [
        Finding(kind="note", run=run, about="not measured", sentence=sentence)
        for run, sentence in (("a", "depth"), ("b", "depth"), ("c", "battery"))
    ]
    assert lines_of(found) == ["? a, b alike: not measured: depth", "? c: not measured: battery", "usable: 2 notes (?)"]
    assert lines_of(found[:2]) == ["? each run: not measured: depth", "usable: 1 note (?)"]
    assert lines_of(found[2:]) == ["? c: not measured: battery", "usable: 1 note (?)"]


def test_a_long_list_is_broken_between_words_and_a_sentence_is_one_line():
    names = "; ".join(f"effect {k} (first normal of thruster 0 1 2)" for k in range(20))
    found = [
        Finding(kind="note", about=about, sentence=names) for about in ("effects that would not show", "excitation")
    ]
    listed, said = lines_of(found)[:-2], lines_of(found)[-2]
    assert max(map(len, listed)) <= 120 and all(line.startswith(6 * " ") for line in listed[1:])
    assert " ".join(line.strip() for line in listed) == f"? effects that would not show: {names}"
    assert said == f"? excitation: {names}"
