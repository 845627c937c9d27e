"""Vehicle sets: what they say, and what is wrong with others, each in a sentence."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from thruster_model.effect_entry import EffectEntry
from thruster_model.errors import VehicleError
from thruster_model.vehicle_parameters import REQUIRED, definition_of
from thruster_model.vehicle_set_io import (
    available_vehicles,
    dump_vehicle_set,
    load_vehicle_set,
    parse_vehicle_set,
)


def document(name="ngs"):
    return yaml.safe_load(dump_vehicle_set(load_vehicle_set(name)))


def parsed(changed):
    return parse_vehicle_set(yaml.safe_dump(changed), origin="mine.yaml")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("ngs", [2.0400507, 1.0359013, 0.8758799, 0.5980914, 0.2285953, 0.2145336]),
        ("bluerov2_heavy", [2, 1.4198431, 1.419463, 0.4342713, 0.377595, 0.2391124]),
    ],
)
def test_layouts_have_the_known_singular_values(name, expected) -> None:
    found = np.linalg.svd(load_vehicle_set(name).configuration, compute_uv=False)
    np.testing.assert_allclose(found, expected, atol=5e-8)


def test_the_fifth_column_of_the_inverse_of_the_ngs_layout_is_the_known_one() -> None:
    found = np.linalg.inv(load_vehicle_set("ngs").configuration)[:, 4]
    np.testing.assert_allclose(found, [2.1872266, 2.1872266, -2.1872266, -2.1872266, 0, 0], atol=5e-8)


def test_the_standard_bluerov2_has_no_pitch() -> None:
    K_t = load_vehicle_set("bluerov2").configuration
    assert np.linalg.matrix_rank(K_t) == 5
    np.testing.assert_allclose(K_t[4], 0.085 * K_t[0], atol=1e-15)


def test_the_pool_rovs_thrusters_make_the_moments_of_its_drawing() -> None:
    f = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    _, _, _, K, M, N = load_vehicle_set("pool_rov").configuration @ f
    assert pytest.approx(0.11 * (f[0] - f[1]) + 0.11 * f[5]) == K
    assert pytest.approx(0.19 * (f[0] + f[1]) - 0.17 * f[4]) == M
    assert pytest.approx(0.11 * (f[2] - f[3])) == N


@pytest.mark.parametrize(
    ("angles", "axis"),
    [
        ({"yaw_deg": 90}, [0, 1, 0]),
        ({"pitch_deg": 90}, [0, 0, 1]),
        ({"yaw_deg": -90, "pitch_deg": 30}, [0, -np.sqrt(0.75), 0.5]),
    ],
)
def test_a_thruster_s_yaw_is_from_ahead_to_starboard_its_pitch_down_and_one_left_out_is_0(angles, axis) -> None:
    changed = document()
    del changed["thrusters"][1]["axis"]
    changed["thrusters"][1].update(angles)
    np.testing.assert_allclose(parsed(changed).configuration[:3, 1], axis, atol=1e-15)


def test_hovering_the_thrusters_carry_what_buoyancy_leaves() -> None:
    for name, thrust in (("ngs", [-0.9847472606] * 2), ("bluerov2_heavy", [0.24525] * 4)):
        c = load_vehicle_set(name).coefficients
        needed = np.linalg.pinv(c.K_t) @ [0, 0, c.buoyancy - c.weight, 0, 0, 0]
        np.testing.assert_allclose(needed[-len(thrust) :], thrust, atol=5e-11)


@pytest.mark.parametrize("name", available_vehicles())
def test_every_set_states_source_and_deviation_and_reads_back_what_it_writes(name) -> None:
    vehicle = load_vehicle_set(name)
    again = parse_vehicle_set(dump_vehicle_set(vehicle), origin="again")
    assert again.values == vehicle.values
    np.testing.assert_allclose(again.configuration, vehicle.configuration, atol=1e-15)
    assert all(p.source for p in vehicle.parameters.values())
    assert vehicle.deviation("mass") == vehicle.parameters["mass"].standard_deviation or vehicle.deviation(
        "mass"
    ) == pytest.approx(0.05 * vehicle.values["mass"])


def test_a_layout_may_be_an_ardusub_frame() -> None:
    changed = document("bluerov2_heavy")
    for thruster in changed["thrusters"]:
        del thruster["axis"]
    vehicle = parsed({**changed, "frame": "vectored_6dof"})
    heavy = load_vehicle_set("bluerov2_heavy")
    np.testing.assert_allclose(vehicle.configuration, -heavy.configuration, atol=1e-15)  # ArduSub counts the other way


def test_hands_and_effects_are_read() -> None:
    effect = {"id": "thrust_loss", "thruster": 2, "parameters": {"share": {"value": 0.3, "unit": "1"}}}
    vehicle = parsed({**document(), "effects": [effect]})
    assert vehicle.effects == (EffectEntry(id="thrust_loss", sizes={"share": 0.3}, units={"share": "1"}, thruster=2),)
    assert list(vehicle.coefficients.hands) == [-1, 1, -1, -1, -1, 1]
    assert parse_vehicle_set(dump_vehicle_set(vehicle), origin="again").effects == vehicle.effects


def test_entries_beside_the_diagonal_come_where_their_names_say() -> None:
    changed = document()
    changed["parameters"]["A_uq"] = {"value": 1.5, "unit": "kg m", "source": "test"}
    changed["parameters"]["Q_vr"] = {"value": 3.0, "unit": "N s^2", "source": "test"}
    changed["parameters"]["L_rv"] = {"value": 2.0, "unit": "N s", "source": "test"}
    c = parsed(changed).coefficients
    assert c.M_A[0, 4] == c.M_A[4, 0] == 1.5
    assert (c.D_Q[1, 5], c.D_Q[5, 1], c.D_L[5, 1], c.D_L[1, 5]) == (3.0, 0.0, 2.0, 0.0)


@pytest.mark.parametrize("unit", ["kg/m^3", "kg m^-3", "kg/m3", "kg/m³", "kg·m⁻³"])
def test_a_unit_may_be_spelt_in_any_usual_way(unit: str) -> None:
    changed = document()
    changed["parameters"]["density"] = {"value": 1025.0, "unit": unit, "source": "test"}
    assert parsed(changed).parameters["density"].unit == "kg/m^3"


def spoiled(change):
    changed = document()
    change(changed)
    return changed


def parameter(name, **entry):
    return lambda d: d["parameters"].setdefault(name, {}).update(entry)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda d: d.pop("name"), "key 'name': missing"),
        (lambda d: d.update(hull=1), "key 'hull': unknown; known are effects, frame"),
        (lambda d: d["parameters"].pop("mass"), "key 'parameters.mass': missing"),
        (parameter("mass", value=-1.0), "key 'parameters.mass.value': expected a number from 1e-06 to 1e+06 kg"),
        (parameter("mass", unit="g"), "key 'parameters.mass.unit': expected 'kg'; found 'g'"),
        (parameter("mass", value="heavy"), "key 'parameters.mass.value': expected a number; found 'heavy'"),
        (parameter("A_uu", value=1.0, unit="kg", source="x"), "key 'parameters.A_uu': expected a parameter of"),
        (parameter("A_u", value=-5.0), "key 'parameters.A_u.value': expected a number from 0 to"),
        (parameter("A_uq", value=50.0, unit="kg m", source="x"), "M_A: expected a positive definite matrix; found"),
        (lambda d: d.update(thrusters=[]), "key 'thrusters': expected at least one thruster; found none"),
        (lambda d: d["thrusters"][1].pop("axis"), "key 'thrusters.1': expected either axis or yaw_deg and pitch_deg"),
        (lambda d: d["thrusters"][1].update(axis=[0, 0, 0]), "key 'thrusters.1.axis': expected a direction; found one"),
        (lambda d: d["thrusters"][1].update(position=[0, 1]), "key 'thrusters.1.position': expected three numbers"),
        (lambda d: d["thrusters"][1].update(hand="up"), "key 'thrusters.1.hand': expected left or right; found 'up'"),
        (lambda d: d["thrusters"][1].update(name="T1"), "key 'thrusters': expected names of their own; found 'T1'"),
        (lambda d: d.update(frame="vectored"), "key 'thrusters.0.axis': the frame gives the axes"),
        (lambda d: d["thrusters"][1].update(pitch_deg=90), "key 'thrusters.1': expected either axis or yaw_deg"),
        (
            lambda d: d["thrusters"].__setitem__(1, {"name": "T", "position": [0, 0, 0], "pitch_deg": "down"}),
            "key 'thrusters.1': expected numbers yaw_deg and pitch_deg; found",
        ),
        (lambda d: d.update(frame="triangle"), "key 'frame': expected one of bluerov1, vectored"),
        (lambda d: d.update(effects=[{"thruster": 1}]), "key 'effects': expected a list of mappings with an id"),
        (lambda d: d.update(effects=[{"id": "x", "thruster": "T1"}]), "key 'effects.0.thruster': expected the number"),
    ],
)  # fmt: skip
def test_a_wrong_set_is_refused_with_a_sentence(change, sentence) -> None:
    with pytest.raises(VehicleError) as caught:
        parsed(spoiled(change))
    assert any(each.startswith(sentence) for each in caught.value.problems), caught.value.problems
    assert str(caught.value).startswith("mine.yaml: ")


def test_the_thrusters_set_of_a_file_is_looked_for_beside_it_first(tmp_path: Path) -> None:
    text = dump_vehicle_set(replace(load_vehicle_set("ngs"), model="mine.yaml"))
    (tmp_path / "own.yaml").write_text(text, "utf-8")
    assert load_vehicle_set(tmp_path / "own.yaml").model == "mine.yaml"
    (tmp_path / "mine.yaml").write_text("base: hl\n", "utf-8")
    found = load_vehicle_set(tmp_path / "own.yaml")
    assert set(found.models) == {str((tmp_path / "mine.yaml").resolve())}


def test_a_vehicle_that_is_trimmed_weighs_what_it_displaces_whatever_its_mass() -> None:
    trimmed = document()
    del trimmed["parameters"]["volume"]
    trimmed["parameters"]["net_buoyancy"] = {"value": 2.0, "unit": "N", "source": "spring balance"}
    vehicle = parsed(trimmed)
    assert vehicle.values["volume"] == pytest.approx((30.0 + 2.0 / 9.81) / 1000.0)
    for heavier in (vehicle, vehicle.with_values({"mass": 33.0}, source="scale")):
        assert heavier.coefficients.buoyancy - heavier.coefficients.weight == pytest.approx(2.0)
    assert parsed(yaml.safe_load(dump_vehicle_set(vehicle))) == vehicle
    trimmed["parameters"]["net_buoyancy"]["value"] = -400.0
    with pytest.raises(VehicleError, match="buoyancy: expected more than 0 N"):
        parsed(trimmed)
    trimmed["parameters"]["volume"] = document()["parameters"]["volume"]
    with pytest.raises(VehicleError, match="expected in place of 'volume'; found both"):
        parsed(trimmed)


def test_a_vehicle_that_nobody_knows_is_named_with_those_that_are() -> None:
    with pytest.raises(VehicleError, match=r"known vehicles \(bluerov2, bluerov2_heavy, ngs, pool_rov\)"):
        load_vehicle_set("submarine")


def test_every_required_parameter_has_a_definition() -> None:
    assert all(definition_of(name) is not None for name in REQUIRED)
