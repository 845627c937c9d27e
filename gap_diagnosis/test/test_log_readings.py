"""How commands act between their samples is asked again once an effect is known that looked like it."""

from dataclasses import replace

import numpy as np

from gap_diagnosis.log_readings import LogReading, read_as_suits
from gap_diagnosis.plausibility import checked
from gap_diagnosis.preparing import recording_of
from gap_diagnosis.problem import Problem, deviations_of
from gap_diagnosis.suspects import suspects
from system_identification.hypothesis import weighed
from system_identification.noise import whitener
from thruster_model.effects.active import ActiveEffects
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.whole_run import simulated_rows

HL = load_parameter_set("hl")
NOISE = {"speed": 1.2, "ambient": 0.006, "thrust": 0.25, "torque": 4e-4}
RATE = 12.0  # [V/s]
DT, PERIOD, LENGTH = 1e-3, 0.05, 30.0  # [s]


def recorded(seed, rough=0.0, rate=RATE):
    """Return a recording in which commands are held, and followed at a limited rate; how they act is not stated.

    `rough`: share of readings that are 30 deviations off; `rate`: [V/s].
    """
    rng = np.random.default_rng(seed)
    at = PERIOD * np.arange(round(LENGTH / PERIOD))
    tones, phases = rng.uniform(0.05, 0.9, (6, 1)), rng.uniform(0.0, 2.0 * np.pi, (6, 1))
    commands = 0.9 * np.sum(np.sin(2.0 * np.pi * tones * at + phases), axis=0)
    effects = ActiveEffects(sizes={"throttle_rate_limit": {"rate": rate}})
    sent = np.repeat(commands, round(PERIOD / DT))
    n, _, ambient, thrust, torque, _ = simulated_rows(HL.coefficients, sent, DT, effects=effects.plant)[:, :-1:20]
    true = {"speed": n, "ambient": ambient, "thrust": thrust, "torque": torque}
    time = 20 * DT * np.arange(n.size)
    signals = {name: (time, x + NOISE[name] * rng.standard_normal(n.size)) for name, x in true.items()}
    for name, (_, readings) in signals.items():
        off = rng.uniform(size=n.size) < rough
        readings[off] += 30.0 * NOISE[name] * rng.choice([-1.0, 1.0], np.sum(off))
    return recording_of(f"run {seed}", (at, commands), signals, hold=None)


def limited(problem):
    """Return the set of the limited rate alone, fitted."""
    suspect = next(each for each in suspects(set(NOISE)) if each.effect == "throttle_rate_limit")
    posed = problem.with_effects(suspect.slots)
    x = np.append(posed.start()[: posed.nuisances], RATE / suspect.slots[0].width)
    return weighed(posed, (suspect,), x, whitener(posed, x))


def test_a_limited_rate_is_not_taken_for_straight_lines_once_it_is_known():
    recordings = tuple(checked([recorded(seed) for seed in (1, 2)]).recordings)
    asked = []

    def investigated(problem, grew):
        asked.append(problem)
        grew(limited(problem))
        return "found"

    log = Problem(recordings=recordings, parameter_set=HL, deviations=deviations_of(HL))
    reading, found = read_as_suits(log, investigated)
    assert (reading.straight, found) == (False, "found")
    assert asked[-1].recordings[0] is not log.recordings[0].straight
    lines = LogReading(log=log, straight=True)
    assert lines.better_for(limited(lines.problem)) == replace(lines, straight=False)


def test_outliers_have_no_say_in_how_commands_act():
    log = Problem(
        recordings=tuple(checked([recorded(seed, 0.004) for seed in (1, 2)]).recordings),
        parameter_set=HL,
        deviations=deviations_of(HL),
    )
    held, lines = (LogReading(log=log, straight=straight) for straight in (False, True))
    assert held.better_for(limited(held.problem)) is None
    assert lines.better_for(limited(lines.problem)) == held


def test_of_two_ways_that_are_the_same_none_is_better_however_rough_the_noises_of_a_set_are():
    recordings = checked([recorded(seed, rate=4.0) for seed in (1, 2)]).recordings
    same = tuple(replace(each, straight=replace(each, straight=None)) for each in recordings)
    way = LogReading(log=Problem(recordings=same, parameter_set=HL, deviations=deviations_of(HL)), straight=False)
    start = way.problem.start()  # without the effect, and noises of the first look
    assert way.better_for(weighed(way.problem, (), start, whitener(way.problem, start))) is None
