"""Recordings of the blind check's own generator, as the tests of the diagnosis need them."""

import numpy as np

from gap_diagnosis.blind_check.generator import Truth, generate
from gap_diagnosis.blind_check.signals import rich_campaign
from gap_diagnosis.preparing import recording_of
from system_identification.noise import white_noise
from thruster_model.parameter_set_io import load_parameter_set

SIGNALS = {"n": "speed", "ambient": "ambient", "thrust": "thrust", "torque": "torque"}


def campaign(
    effects=None, *, outside=None, model="hl", seed=1, spread=0.05, duration=15.0, runs=3, channels=SIGNALS,
    load_late=None, **stating,
):  # fmt: skip
    """Return (parameter set of the simulator, recordings of a thruster that differs from it).

    load_late: by which the stamps of the load cell are late [s], of each run; stating: what the recordings state.
    """
    rng = np.random.default_rng(seed)
    stated = load_parameter_set(model)
    true = {
        name: value * (1.0 + spread * float(np.clip(rng.standard_normal(), -2.0, 2.0)) * (name != "u_dot_max"))
        for name, value in stated.values.items()
    }
    programme = dict(list(rich_campaign(rng, duration=duration).items())[:runs])
    truth = Truth(model=model, parameters=true, effects=effects or {}, outside=outside or {})
    recorded = generate(truth, programme, closed_loop=False, seed=seed)
    return stated, [
        recording_of(
            run.name,
            (run.recorded["throttle"].time, run.recorded["throttle"].values),
            {
                SIGNALS[name]: (
                    run.recorded[name].time + late * (name in ("thrust", "torque")),
                    run.recorded[name].values,
                )
                for name in channels
            },
            **stating,
        )
        for run, late in zip(recorded, load_late or len(recorded) * (0.0,), strict=True)
    ]


def noise_of(problem):
    """Return the generator's own white noise as the map that whitens a problem's rows."""
    return white_noise(problem, {"speed": 1.2, "ambient": 0.006, "thrust": 0.25, "torque": 4e-4})
