"""Nameless dependences: what one number makes of all recordings, and a number of any size."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gap_diagnosis.vehicle import screening
from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.filtering import filtered, prepared_with
from gap_diagnosis.vehicle.gram import Column, evidence, gathered
from gap_diagnosis.vehicle.learning import first_noises
from gap_diagnosis.vehicle.log_io import read_logs
from gap_diagnosis.vehicle.screening import Screen
from gap_diagnosis.vehicle.stage import of_any_size
from gap_diagnosis.vehicle.whitening import whitened
from run_bag import write_run


def test_where_there_is_less_of_a_feature_there_is_less_of_its_wrench(monkeypatch: pytest.MonkeyPatch) -> None:
    fast = np.array([0.6, -0.2, 0.4])
    runs: Any = [SimpleNamespace(log=SimpleNamespace(count=3), feature=share * fast) for share in (1.0, 0.25)]
    monkeypatch.setattr(screening, "features", lambda run, name: run.feature)
    monkeypatch.setattr(screening, "filtered", lambda model, run, values, effects, extra=0.0, coarse=False: extra)
    monkeypatch.setattr(screening, "whitened", lambda run, result: np.asarray(result))
    model: Any = None
    column = Screen(model=model, runs=runs, values={}).of_nameless(("nameless", "pitch", "u|u|"))
    first, second = (column.change(k)[:, 4] for k in (0, 1))
    np.testing.assert_allclose(second, 0.25 * first)
    assert np.mean(np.concatenate((first, second)) ** 2) == pytest.approx(0.1**2)
    assert not column.change(0)[:, [0, 1, 2, 3, 5]].any()


@pytest.mark.parametrize("size", [0.0, 1.0, 20.0])
def test_a_number_of_any_size_costs_little_more_than_one_whose_size_was_foreseen(size: float) -> None:
    rng = np.random.default_rng(5)
    noise, trace = rng.normal(size=500), rng.normal(size=500)

    def gains(deviation: float) -> float:
        gram = gathered([noise - size * trace], [Column("number", deviation, lambda k: trace)])
        return evidence(gram, [0]) - evidence(gram, [])

    gram = gathered([noise - size * trace], [Column("number", 1.0, lambda k: trace)])
    found = of_any_size(gram, [], 0) - evidence(gram, [])
    assert max(map(gains, (1.0, 5.0, 25.0))) - np.log(3.0) < found < max(map(gains, (1.0, 5.0, 25.0)))
    if size == 20.0:
        assert found > gains(1.0) + 150.0, "with a deviation of 1 a size of 20 costs 200 nats"


def test_an_attitude_that_follows_the_accelerometer_is_an_error_of_its_angles_that_goes_with_acceleration(
    tmp_path: Path,
) -> None:
    model = load_model("ngs")
    draw = Draw(seed=17, vehicle="ngs", kinds=("steps",), duration=30.0)
    (topics,) = recorded(draw, model.vehicle, model.sets, model.sensors)
    (log,), model = read_logs([write_run(tmp_path / "run", topics)], model)
    # by hand: an estimate of the pitch that forgets the gyro in 0.8 s for what the accelerometer takes for down
    upright = Rotation.from_quat(log.attitude[:, [1, 2, 3, 0]])
    felt = log.told[:, 6:9] + 9.81 * upright.inv().apply([0.0, 0.0, 1.0])  # without gravity
    wrong = np.zeros(log.count)
    for k in range(log.count - 1):
        wrong[k + 1] = wrong[k] + log.period / 0.8 * (felt[k, 0] / 9.81 - wrong[k])
    pulled = upright * Rotation.from_rotvec(np.outer(wrong, [0.0, 1.0, 0.0]))
    spoiled = replace(log, attitude=pulled.as_quat()[:, [3, 0, 1, 2]])
    run = prepared_with(model, log, 0, first_noises(model, [log]), {})
    screen = Screen(model=model, runs=[run], values={})
    made = whitened(run, filtered(model, replace(run, log=spoiled), {})) - screen.residual(0)

    def share(place: str, feature: str) -> float:
        column = screen.of_nameless(("nameless", place, feature)).change(0)
        return float(np.sum(column * made) ** 2 / (np.sum(column**2) * np.sum(made**2)))

    assert share("pitch angle", "late acceleration along x") > 0.6
    assert (
        max(share("roll angle", "late acceleration along y"), share("pitch", "u|u|"), share("pitch angle", "time"))
        < 0.2
    )
