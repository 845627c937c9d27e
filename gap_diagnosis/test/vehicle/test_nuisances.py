"""What a vehicle's set leaves open is as unsure as a vehicle is trimmed; what it states stands."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.fit import FittedNumber
from gap_diagnosis.vehicle.fit_io import fitted_set
from gap_diagnosis.vehicle.log import CHANNELS_OF
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.nuisances import nuisances
from gap_diagnosis.vehicle.rules import CHARGED, EMPTYING, PLACED, POINTED, SHARED, TIMING, TRIMMED, VOLTMETER
from gap_diagnosis.vehicle.unknowns import unit_of, words_of
from thruster_model.parameter_set import Parameter
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.vehicle_set_io import dump_vehicle_set, parse_vehicle_set

WIDTHS = {"level": CHARGED, "rate": EMPTYING}


def believing(**stated: Parameter) -> Model:
    """Return a vehicle whose set says of centres of mass and of buoyancy only z_B and this."""
    model = load_model("bluerov2")
    kept = {n: p for n, p in model.vehicle.parameters.items() if n == "z_B" or n[1:] not in ("_G", "_B")}
    return replace(model, vehicle=replace(model.vehicle, parameters=kept | stated))


def test_biases_and_numbers_of_the_battery_have_names_and_units() -> None:
    assert words_of(("gyro", 0, 2)) == "bias of the gyro's z in recording 1"
    assert words_of(("force", 1, 0)) == "bias of the accelerometer's x in recording 2"
    assert words_of(("power", "idle_current")) == "idle current of the battery"
    assert (unit_of(("gyro", 0, 2)), unit_of(("force", 0, 2))) == ("rad/s", "m/s^2")


def test_a_centre_of_mass_that_a_set_leaves_out_is_as_unsure_as_a_vehicle_is_trimmed() -> None:
    model = believing(z_G=Parameter(value=0.02, unit="m", source="s"))
    found = nuisances(model, [])
    trimmed = TRIMMED * np.cbrt(model.vehicle.values["volume"])
    assert found["vehicle", "x_G"] == found["vehicle", "y_G"] == pytest.approx(trimmed)
    assert found["vehicle", "z_G"] == pytest.approx(0.05 * 0.02)  # what is stated stands


@pytest.mark.parametrize("point", ["x_G", "x_B"])
@pytest.mark.parametrize("deviation", [0.0, 0.001])
def test_a_deviation_that_is_stated_stands_also_for_a_centre_at_0(point: str, deviation: float) -> None:
    stated = Parameter(value=0.0, unit="m", source="s", standard_deviation=deviation)
    model = believing(**{point: stated})
    expected = {("vehicle", "x_G"): float(TRIMMED * np.cbrt(model.vehicle.values["volume"]))} if point == "x_B" else {}
    expected |= {("vehicle", point): deviation} if deviation else {}
    assert {k: d for k, d in nuisances(model, []).items() if k[1] in ("x_G", "x_B")} == expected


@pytest.mark.parametrize("stated", [None, 0.5])
def test_a_trimmed_vehicles_mass_moves_nothing_up_or_down(stated: float | None) -> None:
    model = load_model("bluerov2")
    parameters = {n: p for n, p in model.vehicle.parameters.items() if n != "volume"}
    parameters["net_buoyancy"] = Parameter(value=2.0, unit="N", source="s", standard_deviation=stated)
    model = replace(model, vehicle=replace(model.vehicle, parameters=parameters))
    free = nuisances(model, [])
    lifted = TRIMMED * model.vehicle.coefficients.buoyancy
    assert free["vehicle", "net_buoyancy"] == (stated or pytest.approx(lifted)) and ("vehicle", "volume") not in free
    heavier = model.built({("vehicle", "mass"): 1.0}).settings.coefficients
    assert heavier.buoyancy - heavier.weight == pytest.approx(2.0)
    assert heavier.M_RB[0, 0] == pytest.approx(model.vehicle.values["mass"] + 1.0)
    lifted_by = model.built({("trim", "net_buoyancy", 1): 3.0}, run=1).settings.coefficients
    assert lifted_by.buoyancy - lifted_by.weight == pytest.approx(2.0 + 0.5 * 3.0)


def test_where_the_centre_of_buoyancy_is_says_nothing_of_where_the_centre_of_mass_is() -> None:
    assert ("vehicle", "z_G") in nuisances(load_model("bluerov2_heavy"), [])  # which states z_B


def test_a_centre_of_mass_that_was_left_out_is_written_as_fitted() -> None:
    model = believing()
    key = ("vehicle", "x_G")
    assert key in nuisances(model, [])
    fitted = FittedNumber(key=key, before=0.002, moved=0.0013, after=0.0004, together=None)
    again = parse_vehicle_set(dump_vehicle_set(fitted_set(model, [fitted])), origin="own.yaml")
    assert again.values["x_G"] == pytest.approx(0.0013)
    assert again.deviation("x_G") == pytest.approx(0.0004)


def test_sensors_are_calibrated_and_mounted_to_a_degree_where_they_are_there() -> None:
    model = load_model("bluerov2")
    there = dict.fromkeys((*CHANNELS_OF, "tachometer", "battery"), False) | {"gyro": True, "velocity": True}
    found = nuisances(model, [SimpleNamespace(there=there, battery=np.full((3, 2), np.nan))])  # type: ignore[list-item]
    assert found["sensor", "gyro_scale", None, "z"] == 0.005 and found["sensor", "velocity_scale", None, "x"] == 0.01
    assert found["sensor", "sensor_lever_arm", "velocity", "y"] == 0.01
    assert found["late", "velocity"] == TIMING and ("late", "tachometer") not in found
    assert not [key for key in found if key[0] == "sensor" and "depth" in key[1:]]
    assert ("sensor", "gyro_scale", None, None) not in found  # that of all axes is all three


def test_products_of_inertia_turn_a_vehicle_about_another_axis() -> None:
    model = load_model("bluerov2")
    moments = model.vehicle.coefficients.mass_matrix.diagonal()
    found = nuisances(model, [])
    assert found["product", "yz"] == pytest.approx(0.02 * np.sqrt(moments[4] * moments[5]))
    plain, slanted = (model.built(v).settings.coefficients.mass_matrix for v in ({}, {("product", "yz"): 0.03}))
    changed = slanted - plain
    assert changed[4, 5] == changed[5, 4] == pytest.approx(0.03) and np.count_nonzero(changed) == 2


@pytest.mark.parametrize(
    ("base", "changed", "numbers"),
    [
        ("bessa", {"k_2": 0.02}, ("k_2",)),
        ("simplified", {"k_Q": 0.03}, ("k_Q", "delta_T1", "delta_T2")),
    ],
)
def test_what_brakes_a_rotor_and_the_dead_zone_of_a_thrust_are_uncertain(
    base: str, changed: dict[str, float], numbers: tuple[str, ...]
) -> None:
    given = load_parameter_set(base)
    parameters = {
        n: replace(p, standard_deviation=changed[n] * abs(p.value)) if n in changed else p
        for n, p in given.parameters.items()
    }
    model = load_model("bluerov2")
    model = replace(model, sets=(replace(given, parameters=parameters),) * model.thrusters)
    found = nuisances(model, [])
    assert all(("shared", n) in found and ("own", n, 3) in found for n in numbers)
    assert {n: found["shared", n] for n in changed} == pytest.approx(changed)
    built = model.built({("shared", n): 0.1 for n in numbers}).settings.thrusters[0]
    believed = given.coefficients
    assert all(getattr(built, n) == pytest.approx(1.1 * getattr(believed, n)) for n in numbers)


def test_numbers_of_a_thruster_are_those_of_its_set() -> None:
    given = load_parameter_set("force_table")
    rate = replace(given.parameters["rate"], standard_deviation=1.5)
    model = load_model("bluerov2")
    model = replace(model, sets=(replace(given, parameters={**given.parameters, "rate": rate}),) * model.thrusters)
    found = nuisances(model, [])
    shared = {key[1]: deviation for key, deviation in found.items() if key[0] == "shared"}
    scale = given.parameters["command_scale"]
    assert shared["drive"] == scale.standard_deviation and shared["rate"] == pytest.approx(0.15)
    assert shared["thrust"] == given.parameters["thrust_scale"].standard_deviation
    assert {"c_u1", "c_u2"}.isdisjoint(shared)
    built = model.built({("shared", "drive"): 0.1}).settings.thrusters[0]
    assert (built.c_u1, built.c_u2) == pytest.approx((1.1 * given.coefficients.c_u1, 1.1 * given.coefficients.c_u2))


def test_a_number_by_another_name_than_its_coefficient_has_the_deviation_that_is_stated() -> None:
    given = load_parameter_set("first_order")
    g_1 = replace(given.parameters["g_1"], standard_deviation=0.2 * given.parameters["g_1"].value)
    model = load_model("bluerov2")
    model = replace(model, sets=(replace(given, parameters={**given.parameters, "g_1": g_1}),) * model.thrusters)
    found = nuisances(model, [])
    assert found["shared", "c_u1"] == pytest.approx(0.2) and found["shared", "c_u2"] == SHARED


@pytest.mark.parametrize(("volts", "deviation"), [(14.0, VOLTMETER), (16.0, 0.1)])
def test_volts_are_read_to_a_voltmeters_accuracy_where_the_thrusters_table_has_volts(
    volts: float, deviation: float
) -> None:
    model = load_model("bluerov2", "force_table")
    model = replace(model, sensors=replace(model.sensors, nominal_voltage=volts))
    there = dict.fromkeys((*CHANNELS_OF, "tachometer"), False) | {"gyro": True, "battery": True}
    found = nuisances(model, [SimpleNamespace(there=there, battery=np.full((3, 2), 15.0))])  # type: ignore[list-item]
    assert found["power", "nominal_voltage"] == deviation


def test_places_and_directions_of_thrusters_are_uncertain() -> None:
    model = load_model("bluerov2_heavy")
    free = nuisances(model, [])
    placed = PLACED * np.cbrt(model.vehicle.values["volume"])
    for i in range(model.thrusters):
        assert free["own", "first angle", i] == free["own", "second angle", i] == POINTED
        assert free["own", "first offset", i] == free["own", "second offset", i] == pytest.approx(placed)


@pytest.mark.parametrize("thruster", [0, 5])
def test_a_thruster_that_was_found_elsewhere_is_written_there(thruster: int) -> None:
    model = load_model("bluerov2_heavy")
    moved = {"first angle": 0.05, "second angle": -0.03, "first offset": 0.01, "second offset": -0.02}
    numbers = [
        FittedNumber(key=("own", name, thruster), moved=size, before=0.02, after=1e-3, together=None)
        for name, size in moved.items()
    ]
    found = parse_vehicle_set(dump_vehicle_set(fitted_set(model, numbers)), origin="written")
    expected = model.built({n.key: n.moved for n in numbers}).settings.coefficients
    assert found.coefficients.K_t == pytest.approx(expected.K_t, abs=2e-6)
    before, after = model.vehicle.layout, found.layout
    where = [
        (*a.position, *a.axis) == pytest.approx((*b.position, *b.axis), abs=1e-6)
        for a, b in zip(after, before, strict=True)
    ]
    assert where == [i != thruster for i in range(model.thrusters)]
    shift = np.subtract(after[thruster].position, before[thruster].position)
    assert np.linalg.norm(shift) == pytest.approx(np.hypot(0.01, 0.02))
    assert shift @ np.array(before[thruster].axis) == pytest.approx(0.0, abs=1e-9)
    turned = np.arccos(np.dot(after[thruster].axis, before[thruster].axis))
    assert turned == pytest.approx(np.hypot(0.05, 0.03), rel=1e-3)


def test_a_battery_is_as_full_as_it_may_be_in_each_recording_that_has_not_its_voltage() -> None:
    there = dict.fromkeys((*CHANNELS_OF, "tachometer", "battery"), False)
    unread, read = np.full((3, 2), np.nan), np.array([[np.nan, np.nan], [15.8, np.nan], [np.nan, np.nan]])
    logs = [SimpleNamespace(there=there, battery=battery) for battery in (unread, read, unread)]
    found = nuisances(load_model("bluerov2"), logs)  # type: ignore[arg-type]
    charges = {key: deviation for key, deviation in found.items() if key[0] == "charge"}
    assert charges == {("charge", k, what): width for k in (0, 2) for what, width in WIDTHS.items()}


def test_the_turn_by_which_an_attitude_errs_is_uncertain_in_each_recording() -> None:
    there = dict.fromkeys((*CHANNELS_OF, "tachometer", "battery"), False)
    logs = [SimpleNamespace(there=there | {"attitude": told}, battery=np.zeros((3, 2))) for told in (True, False, True)]
    found = nuisances(load_model("bluerov2"), logs)  # type: ignore[arg-type]
    turns = {key[1:]: deviation for key, deviation in found.items() if key[0] == "tilt"}
    assert turns == {(run, axis): 0.01 for run in (0, 2) for axis in range(3)}
