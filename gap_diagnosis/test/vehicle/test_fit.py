"""Fits of a vehicle's numbers: a vehicle heavier and draggier than stated, recorded in the sealed cases' own world."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.cli_fit_vehicle import main
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.fit import VehicleFit, fitted_vehicle
from gap_diagnosis.vehicle.fit_io import fitted_set, written
from gap_diagnosis.vehicle.log_io import read_logs
from gap_diagnosis.vehicle.model import Model
from run_bag import write_run
from thruster_model.vehicle_set_io import load_vehicle_set

DRAG, MASS = 1.4, 1.15


@pytest.fixture(scope="module")
def fitted(tmp_path_factory: pytest.TempPathFactory) -> tuple[Model, VehicleFit]:
    """Return the believed model and its fit to two recordings of a vehicle whose surge differs from it."""
    folder = tmp_path_factory.mktemp("fit")
    believed = load_model("ngs")
    v = believed.vehicle.values
    true = believed.vehicle.with_values(
        {"Q_u": DRAG * v["Q_u"], "A_u": v["A_u"] + (MASS - 1.0) * (v["mass"] + v["A_u"])}, source="truth"
    )
    loose = {n: replace(believed.vehicle.parameters[n], standard_deviation=0.5 * v[n]) for n in ("Q_u", "A_u")}
    wide = replace(believed.vehicle, parameters={**believed.vehicle.parameters, **loose})
    draw = Draw(seed=21, vehicle="ngs", deviations=0.0, wrench=0.05, kinds=("steps", "sines"), duration=24.0)
    paths = [
        write_run(folder / f"run_{k}", topics)
        for k, topics in enumerate(recorded(draw, true, believed.sets, believed.sensors))
    ]
    logs, model = read_logs(paths, replace(believed, vehicle=wide))
    return model, fitted_vehicle(model, logs)


def test_numbers_that_differ_are_found_within_their_deviations(fitted: tuple[Model, VehicleFit]) -> None:
    model, fit = fitted
    v = model.vehicle.values
    found = {n.key[1]: n for n in fit.numbers if n.key[0] == "vehicle"}
    for name, truth in (("Q_u", (DRAG - 1.0) * v["Q_u"]), ("A_u", (MASS - 1.0) * (v["mass"] + v["A_u"]))):
        assert found[name].told
        assert abs(found[name].moved - truth) < 3.5 * found[name].after, name


def test_what_the_recordings_cannot_tell_keeps_its_deviation_and_is_named(fitted: tuple[Model, VehicleFit]) -> None:
    # drag of roll, where nothing but the hold of the attitude excites it, against its inertia: little is told
    open_ones = [n for n in fitted[1].numbers if not n.told]
    assert open_ones
    assert all(n.after > 0.8 * n.before for n in open_ones)
    assert all(n.after < 1.001 * n.before for n in fitted[1].numbers)


def test_free_runs_on_recordings_left_out_come_nearer(fitted: tuple[Model, VehicleFit]) -> None:
    errors = fitted[1].errors
    assert [e.horizon for e in errors] == [2.0, 10.0] and fitted[1].left_out
    assert errors[1].fitted["velocity"] < 0.8 * errors[1].as_stated["velocity"]


def test_the_set_written_carries_the_fitted_numbers_and_loads(fitted: tuple[Model, VehicleFit], tmp_path: Path) -> None:
    model, fit = fitted
    paths = {p.name: p for p in written(model, fit, {"runs": ["made here"]}, tmp_path / "out")}
    again = load_vehicle_set(paths["vehicle.yaml"])
    assert again.values == pytest.approx(fitted_set(model, fit.numbers).values)
    told = next(n for n in fit.numbers if n.key == ("vehicle", "Q_u"))
    assert again.deviation("Q_u") == pytest.approx(told.after)
    content = json.loads(paths["fit.json"].read_text("utf-8"))
    assert {n["name"] for n in content["numbers"]} >= {"mass", "Q_u", "thrust of thruster 0", "thrust of all thrusters"}
    assert np.isfinite(content["free_runs"][0]["fitted"]["gyro"])


def test_recordings_that_are_not_there_are_said_to_be_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(tmp_path / "none"), "--vehicle", "ngs", "--out", str(tmp_path / "out")]) == 1
    assert "none" in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_a_number_that_a_fit_leaves_beyond_its_range_is_written_at_its_end(fitted: tuple[Model, VehicleFit]) -> None:
    model, fit = fitted
    drag = next(n for n in fit.numbers if n.key == ("vehicle", "Q_u"))
    assert fitted_set(model, [replace(drag, moved=-1e4)]).values["Q_u"] == 0.0


def test_what_dives_differ_by_sums_to_zero_over_them_and_is_none_of_the_vehicles() -> None:
    model = load_model("ngs")
    values = {("trim", "x_G", 1): 0.01, ("trim", "x_G", 2): -0.02, ("trim", "volume", 2): 1e-4}
    r_G = [model.built(values, run=k).settings.coefficients.r_G[0] for k in range(3)]
    believed = model.built({}).settings.coefficients.r_G[0]
    assert r_G[1] - r_G[0] == pytest.approx(0.01)
    assert r_G[2] - np.mean(r_G[:2]) == pytest.approx(-0.02)
    assert np.mean(r_G) == pytest.approx(believed)
    assert model.built(values, run=-1).settings.coefficients.r_G[0] == pytest.approx(believed)
