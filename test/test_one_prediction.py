"""Simulators, fit and diagnosis predict the same: every effect of the library, every model, one definition each."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from bench_driver.device import Outputs
from gap_diagnosis.prediction import Situation
from gap_diagnosis.prediction import predict as diagnosed
from gap_diagnosis.recording import Recording
from rov_sim.bench_study.controllers import controller
from rov_sim.closed_loop import Plant, scatter_seed, simulate_loop
from rov_sim.emulated_bench import QUIET, BenchPlant, BenchSettings
from rov_sim.rig_sensors import Rig
from thruster_model.effects.active import ActiveEffects
from thruster_model.effects.chains import SENSED
from thruster_model.effects.stages import LIBRARY
from thruster_model.identification.experiment import Experiment, Measurement
from thruster_model.identification.prediction import happened, predict
from thruster_model.models import MODELS
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.stepper import AT_REST

Array = NDArray[np.float64]
DT, HELD, COUNT = 1e-3, 25, 300
THROTTLE_LATE = 0.05
COMPILED_FOR_SECONDS = ("airfoil", "four_quadrant")
EXACT = Rig(speed_noise=0.0, flow_noise=0.0, turbulence=0.0, spike_share=0.0, load_noise=0.0, quantised=False)
CLOSE: dict[str, Any] = {"rtol": 1e-9, "atol": 1e-9}


def sized(name: str) -> ActiveEffects:
    """Return an effect of a middling size that is no whole number of steps."""
    sizes = {}
    for p in LIBRARY[name].parameters:
        sizes[p.name] = 0.437 * (p.lower + p.upper) if name != "thruster_polarity" else 1.0
    if name == "log_alignment":
        sizes["throttle"] = THROTTLE_LATE
    if name == "tank_recirculation":
        sizes["delay"] = 1.0
    return ActiveEffects(sizes={name: sizes})


def recorded(effects: ActiveEffects, commands: Array, series: dict[str, tuple[Array, Array, float]]) -> Experiment:
    """Return the experiment that is recorded of (instants, values, width of a cell) with effects of the log."""
    late = round(float(effects.stamped("throttle", np.zeros(1))[0]) / DT)
    throttle = np.concatenate((np.zeros(late), commands))[: commands.size]
    measurements = {}
    for signal, (time, values, width) in series.items():
        stamps = effects.stamped(signal, time)
        measurements[signal] = Measurement(signal=signal, time=stamps, values=values, width=width, noise=1.0)
    return Experiment(name="run", dt=DT, throttle=throttle, measurements=measurements)


def assert_predicted(experiment: Experiment, p: Any, effects: ActiveEffects, seed: int, gates: Array) -> None:
    """Assert that fit and diagnosis predict what was recorded, speeds by magnitude, as far as the recording goes on."""
    known = happened(experiment, p, effects, gates=gates)
    fitted = predict(experiment, p, effects=effects, known=known, seed=seed)
    for signal, measurement in experiment.measurements.items():
        here = measurement.time < (experiment.throttle.size - 1) * DT - THROTTLE_LATE
        found, told = fitted[signal][here], measurement.values[here]
        if signal == "speed":
            found, told = np.abs(found), np.abs(told)
        np.testing.assert_allclose(found, told, err_msg=signal, **CLOSE)
    drawn = predict(experiment, p, effects=effects, known=known)
    by_diagnosis = diagnosed(Recording(experiment=experiment), p, effects.sizes, Situation(start=AT_REST, gates=gates))
    for signal, values in drawn.items():
        np.testing.assert_array_equal(by_diagnosis[signal], values, err_msg=signal)


@pytest.mark.parametrize(
    "model", [pytest.param(name, marks=pytest.mark.long if name in COMPILED_FOR_SECONDS else ()) for name in MODELS]
)
def test_the_emulated_bench_the_fit_and_the_diagnosis_agree_on_every_effect(model: str) -> None:
    p = load_parameter_set(model).coefficients
    levels = np.array([2.6, -3.1, 0.9, 4.0, -1.2, 0.0, 3.3, -4.4, 1.8, 2.2, -0.95, 2.9])
    commands = np.repeat(levels, HELD)[:COUNT]
    for name in LIBRARY:
        effects = sized(name)
        bench = BenchPlant(BenchSettings(coefficients=p, effects=effects, rig=QUIET, seed=6))
        rows = [bench.sensed()]
        for u in commands.tolist():
            bench(DT, Outputs(throttles=(u,), enabled=(True,), data=b""))
            rows.append(bench.sensed())
        time = np.asarray(DT * np.arange(COUNT + 1), dtype=np.float64)
        series = {signal: (time, values, 0.0) for signal, values in zip(SENSED, np.transpose(rows), strict=True)}
        assert_predicted(recorded(effects, commands, series), p, effects, seed=7, gates=bench.gates(COUNT))


@pytest.mark.parametrize("name", LIBRARY)
def test_the_closed_loop_the_fit_and_the_diagnosis_agree_on_an_effect(name: str) -> None:
    p, effects, periods, steps = load_parameter_set("hl_bench").coefficients, sized(name), 40, 40
    gates = (np.arange(periods) % 10 < 5).astype(float) if name == "ventilation" else np.empty(0)
    wanted = 8.0 * np.sign(np.sin(0.3 * np.arange(periods)))
    plant = Plant(coefficients=p, effects=effects, gates=gates if gates.size else None)
    run = simulate_loop(wanted, plant, controller("hl-ekf", p), rig=EXACT, seed=3)
    commands = np.repeat(run.of("acting"), steps)
    series = {
        "speed": (run.time, run.of("y_n"), 0.0),
        "ambient": (run.time, run.of("y_U"), 0.0),
        "thrust": (run.time + 0.5 * steps * DT, run.load, steps * DT),
    }
    experiment = recorded(effects, commands, series)
    assert_predicted(experiment, p, effects, scatter_seed(3), np.repeat(gates, steps))


@pytest.mark.parametrize("name", ["timestamp_jitter", "dropped_samples"])
def test_a_log_that_scatters_is_the_predictions_with_the_same_draws(name: str) -> None:
    p, effects = load_parameter_set("hl_bench").coefficients, sized(name)
    commands = np.repeat([2.6, -3.1, 1.4], 100)
    bench = BenchPlant(BenchSettings(coefficients=p, effects=effects, rig=QUIET))
    read = [bench.sensed().thrust]
    for u in commands.tolist():
        bench(DT, Outputs(throttles=(u,), enabled=(True,), data=b""))
        read.append(bench.sensed().thrust)
    time = np.asarray(DT * np.arange(301), dtype=np.float64)
    experiment = recorded(effects, commands, {"thrust": (time, np.array(read), 0.0)})
    predicted = predict(experiment, p, effects=effects)["thrust"]
    simulated_log, predicted_log = (
        effects.log("thrust", time, values, np.random.default_rng(5)) for values in (np.array(read), predicted)
    )
    assert not np.array_equal(simulated_log[0], time) or not np.array_equal(simulated_log[1], np.array(read))
    np.testing.assert_array_equal(simulated_log[0], predicted_log[0])
    np.testing.assert_allclose(simulated_log[1], predicted_log[1], **CLOSE)
