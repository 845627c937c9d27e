"""Effects of a vehicle: neutral to the bit, and each does what its equation says, worked out by hand."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from rov_sim.vehicle.effects.active import VEHICLE_LIBRARY, ActiveVehicleEffect, body_with
from rov_sim.vehicle.plant import VehiclePlant, VehicleSettings, simulate
from rov_sim.vehicle.settings import active_effect
from rov_sim.vehicle.settings_io import load_vehicle_settings
from rov_sim.vehicle.truth import VehicleTruth, at_rest
from thruster_model.effect_entry import EffectEntry
from thruster_model.errors import VehicleError

TARGETS: dict[str, dict[str, Any]] = {
    "added_mass": {"axis": "surge"},
    "linear_drag": {"axis": "sway"},
    "quadratic_drag": {"axis": "yaw"},
    "added_mass_coupling": {"axis": "sway-yaw"},
    "drag_coupling": {"axis": "surge-pitch"},
    "hull_interaction": {"thruster": 0},
    "thruster_interaction": {"thruster": 0, "other": 3},
    "thruster_misalignment": {"thruster": 1, "kind": "first_normal"},
    "thruster_failure": {"thruster": 2, "kind": "no_thrust"},
    "thruster_swap": {"thruster": 0, "other": 1},
}
OTHERS = ("buoyancy_offset", "payload", "cg_shift", "cb_shift", "water_current", "water_density", "tether_drag",
          "ram_drag", "reaction_torque", "supply_sag")  # fmt: skip
NU = np.array([0.4, -0.2, 0.1, 0.3, -0.2, 0.5])
N = np.array([80.0, 60.0, -70.0, 90.0, 40.0, -50.0])
U = np.array([2.0, 1.8, -1.9, 2.2, 1.5, -1.7])
PLAIN = load_vehicle_settings("ngs")
C = PLAIN.coefficients
M = C.mass_matrix


def effect(name: str, *, sizes: dict[str, float], **target: Any) -> ActiveVehicleEffect:
    return ActiveVehicleEffect(id=name, sizes=sizes, **(target or TARGETS.get(name, {})))


def with_effects(*active: ActiveVehicleEffect) -> VehicleSettings:
    return replace(PLAIN, coefficients=body_with(C, active))


def moving(settings: VehicleSettings) -> VehicleTruth:
    """Return what is true of a vehicle on its way, rolled and pitched, with its rotors turning."""
    start = at_rest(6, angles=(0.3, -0.4, 1.0), velocity=NU)
    start.thrusters[:, 0], start.thrusters[:, 1], start.thrusters[:, 2] = N, 0.1, U
    return VehiclePlant(replace(settings, initial=start)).truth()


def gained(*active: ActiveVehicleEffect) -> Any:
    """Return the wrench (6,) that effects which leave M alone add [N, N m]."""
    return M @ (moving(with_effects(*active)).acceleration - moving(PLAIN).acceleration)


def test_every_effect_of_the_body_is_tried_here() -> None:
    assert {*TARGETS, *OTHERS} == {name for name, each in VEHICLE_LIBRARY.items() if each.body is not None}


@pytest.mark.parametrize("name", [*TARGETS, *OTHERS])
def test_at_neutral_an_effect_changes_no_bit(name: str) -> None:
    neutral = {p.name: p.neutral for p in VEHICLE_LIBRARY[name].parameters}
    changed = body_with(C, [effect(name, sizes=neutral)])
    for field, before, after in zip(C._fields, C, changed, strict=True):
        np.testing.assert_array_equal(before, after, err_msg=field)


def test_drag_grows_along_its_axis() -> None:
    found = gained(effect("linear_drag", sizes={"share": 0.5}), effect("quadratic_drag", sizes={"share": -0.2}))
    expected = [0, -0.5 * 20 * NU[1], 0, 0, 0, 0.2 * 5.7 * abs(NU[5]) * NU[5]]
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_drag_couples_the_first_axis_to_motion_along_the_second() -> None:
    found = gained(effect("drag_coupling", sizes={"size": 3.0}))
    np.testing.assert_allclose(found, [-3.0 * NU[4], 0, 0, 0, 0, 0], atol=1e-12)


def test_added_mass_takes_its_share_of_a_push() -> None:
    heavier = with_effects(effect("added_mass", sizes={"share": 0.5}))
    assert heavier.coefficients.mass_matrix[0, 0] == pytest.approx(30 + 1.5 * 14.1)
    coupled = with_effects(effect("added_mass_coupling", sizes={"size": 2.0})).coefficients
    assert coupled.M_A[1, 5] == coupled.M_A[5, 1] == 2.0
    pushed = VehiclePlant(replace(PLAIN, coefficients=coupled)).truth(np.array([0, 10.0, 0, 0, 0, 0]))
    by_hand = np.linalg.solve([[30 + 15.8, 2.0], [2.0, 1.4 + 0.84]], [10.0, 0.0])
    np.testing.assert_allclose(pushed.acceleration[[1, 5]], by_hand, rtol=1e-12)


def test_buoyancy_lifts_at_its_centre() -> None:
    level = replace(PLAIN, coefficients=body_with(C, [effect("buoyancy_offset", sizes={"force": 10.0})]))
    difference = VehiclePlant(level).truth().acceleration - VehiclePlant(PLAIN).truth().acceleration
    np.testing.assert_allclose(M @ difference, [0, 0, -10.0, 0, 0, 0], atol=1e-12)


def test_a_payload_is_a_point_mass_in_weight_and_inertia() -> None:
    m, r = 2.0, np.array([0.3, -0.1, 0.2])
    c = body_with(C, [effect("payload", sizes={"mass": m, "x": 0.3, "y": -0.1, "z": 0.2})])
    assert c.weight == pytest.approx((30 + m) * 9.81)
    np.testing.assert_allclose(c.r_G, m * r / (30 + m))
    speed = NU[:3] + np.cross(NU[3:], r)
    assert pytest.approx(m * speed @ speed) == NU @ (c.M_RB - C.M_RB) @ NU


def test_a_shifted_centre_of_mass_pulls_with_the_weight_at_its_arm() -> None:
    shifted = VehiclePlant(with_effects(effect("cg_shift", sizes={"x": 0.02}))).truth()
    moment = shifted.acceleration[4] * (0.87 + 0.511 + 30 * 0.02**2) - 30 * 0.02 * shifted.acceleration[2]
    assert moment == pytest.approx(-30 * 9.81 * 0.02, rel=1e-12)


def test_a_shifted_centre_of_buoyancy_lifts_at_its_arm_and_moves_no_mass() -> None:
    shifted = with_effects(effect("cb_shift", sizes={"x": 0.02, "y": -0.01}))
    difference = VehiclePlant(shifted).truth().acceleration - VehiclePlant(PLAIN).truth().acceleration
    np.testing.assert_allclose(M @ difference, C.buoyancy * np.array([0, 0, 0, 0.01, 0.02, 0.0]), atol=1e-12)


def test_a_current_drags_a_vehicle_along_until_it_drifts_with_it() -> None:
    settings = with_effects(effect("water_current", sizes={"north": 0.3, "east": -0.1}))
    hull = settings.coefficients._replace(weight=C.buoyancy, thrust_scale=np.zeros(6), r_B=np.zeros(3))
    drifting = at_rest(6, angles=(0, 0, 0.7))
    run = simulate(replace(settings, coefficients=hull, initial=drifting), np.zeros((3000, 6)), 0.1, wrench=None)
    ground = (run.position[-1] - run.position[-2]) / 0.1
    np.testing.assert_allclose(ground, [0.3, -0.1, 0.0], atol=3e-3)
    started = VehiclePlant(replace(settings, coefficients=hull, initial=drifting)).truth()
    assert started.ambient[0] == pytest.approx(-C.K_t[:3, 0] @ _in_body((0.3, -0.1, 0.0), 0.7), rel=1e-12)


def _in_body(v: tuple[float, float, float], yaw: float) -> Any:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([c * v[0] + s * v[1], -s * v[0] + c * v[1], v[2]])


def test_denser_water_holds_lifts_and_pushes_more() -> None:
    c = body_with(C, [effect("water_density", sizes={"share": 0.03})])
    for name in ("M_A", "D_L", "D_Q", "buoyancy", "thrust_scale", "density"):
        np.testing.assert_allclose(getattr(c, name), 1.03 * getattr(C, name), rtol=1e-15)
    dense = moving(replace(PLAIN, coefficients=c))
    np.testing.assert_allclose(dense.thrust, 1.03 * moving(PLAIN).thrust, rtol=1e-14)


def test_a_tether_pulls_against_the_motion_of_its_anchor() -> None:
    r = np.array([-0.3, 0.0, -0.1])
    found = gained(effect("tether_drag", sizes={"length": 40.0, "x": -0.3, "z": -0.1}))
    v = NU[:3] + np.cross(NU[3:], r)
    force = -0.5 * 1000 * 1.2 * 0.008 * 40 * np.linalg.norm(v) * v
    np.testing.assert_allclose(found, [*force, *np.cross(r, force)], atol=1e-11)


def test_thrusters_turn_the_water_that_they_take_in_into_their_axes() -> None:
    found, expected = gained(effect("ram_drag", sizes={"diameter": 0.08})), np.zeros(6)
    for r, e, thrust in zip(C.positions.T, C.K_t[:3].T, moving(PLAIN).thrust, strict=True):
        v = NU[:3] + np.cross(NU[3:], r)
        mass_flow = np.sqrt(1000 * np.pi * 0.04**2 * abs(thrust) / 2)
        force = -mass_flow * (v - (v @ e) * e)
        expected += [*force, *np.cross(r, force)]
    np.testing.assert_allclose(found, expected, atol=1e-11)


@pytest.mark.parametrize(("kind", "acts"), [(None, True), ("forward", True), ("reverse", False)])
def test_a_wake_on_the_hull_takes_thrust_along_one_axis(kind: str | None, acts: bool) -> None:
    target = {"thruster": 0} | ({} if kind is None else {"kind": kind})
    found = gained(effect("hull_interaction", sizes={"share": 0.4}, **target))
    expected = np.zeros(6)
    expected[0] = -0.4 * C.K_t[0, 0] * moving(PLAIN).thrust[0] if acts else 0.0
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_a_thruster_in_a_wake_loses_thrust_as_the_other_pushes() -> None:
    before = moving(PLAIN).thrust
    after = moving(with_effects(effect("thruster_interaction", sizes={"share": 0.5}))).thrust
    expected = before[3] * (1 - 0.5 * abs(before[0]) / C.full_thrust[0])
    np.testing.assert_allclose(after, [*before[:3], expected, *before[4:]], rtol=1e-13)


@pytest.mark.parametrize("kind", ["first_normal", "second_normal"])
def test_a_turned_thruster_pushes_and_meets_the_water_along_its_new_axis(kind: str) -> None:
    c = body_with(C, [effect("thruster_misalignment", sizes={"angle": 0.2}, thruster=1, kind=kind)])
    e, old = c.K_t[:3, 1], C.K_t[:3, 1]
    assert e @ old == pytest.approx(np.cos(0.2))
    assert np.linalg.norm(e) == pytest.approx(1.0)
    np.testing.assert_allclose(c.K_t[3:, 1], np.cross(C.positions[:, 1], e), atol=1e-15)
    np.testing.assert_array_equal(c.inflow, c.K_t)


def test_the_two_normals_are_square_to_each_other_and_to_the_axis() -> None:
    turned = [
        body_with(C, [effect("thruster_misalignment", sizes={"angle": 0.2}, thruster=1, kind=kind)]).K_t[:3, 1]
        for kind in ("first_normal", "second_normal")
    ]
    steps = [e - np.cos(0.2) * C.K_t[:3, 1] for e in turned]
    assert steps[0] @ steps[1] == pytest.approx(0.0, abs=1e-15)


def test_a_moved_thruster_pushes_at_another_arm() -> None:
    found = gained(effect("thruster_misalignment", sizes={"x": 0.1, "z": -0.05}, thruster=1, kind="position"))
    assert np.all(np.abs(found[:3]) < 0.2)  # but for the inflow's change the force stays
    c = body_with(C, [effect("thruster_misalignment", sizes={"x": 0.1}, thruster=1, kind="position")])
    np.testing.assert_allclose(c.K_t[3:, 1] - C.K_t[3:, 1], np.cross([0.1, 0, 0], C.K_t[:3, 1]), atol=1e-15)


def test_a_failed_thruster_turns_without_thrust_or_stands_still() -> None:
    dead = moving(with_effects(effect("thruster_failure", sizes={"failed": 1.0})))
    assert dead.thrust[2] == 0.0
    assert dead.n[2] == N[2]
    stopped = moving(with_effects(effect("thruster_failure", sizes={"failed": 1.0}, thruster=2, kind="stopped")))
    assert stopped.n[2] == stopped.u[2] == 0.0


def test_exchanged_thrusters_do_what_the_other_is_told() -> None:
    u = np.tile(U, (25, 1))
    swapped = simulate(with_effects(effect("thruster_swap", sizes={"swapped": 1.0})), u, 0.04)
    by_hand = simulate(PLAIN, u[:, [1, 0, 2, 3, 4, 5]], 0.04)
    np.testing.assert_array_equal(swapped.velocity, by_hand.velocity)


def test_propellers_turn_the_vehicle_against_their_hands() -> None:
    hands = np.array([-1, 1, -1, -1, -1, 1])  # L R L L L R
    expected = -(C.K_t[:3] * (hands * 2.5e-5 * N * np.abs(N))).sum(axis=1)
    np.testing.assert_allclose(
        gained(effect("reaction_torque", sizes={"share": 1.0})), [0, 0, 0, *expected], atol=1e-12
    )


def test_one_supply_sags_under_the_load_of_all() -> None:
    p = PLAIN.thrusters[0]
    gamma = np.where(U > 0, p.c_u2 * (U - p.delta_u2), p.c_u1 * (U - p.delta_u1))
    strongest = max(p.c_u2 * (5 - p.delta_u2), p.c_u1 * (5 + p.delta_u1))
    share = np.mean(np.abs(gamma * N)) / (strongest * strongest / p.k_n)
    truth = moving(with_effects(effect("supply_sag", sizes={"share": 0.4})))
    assert truth.current == pytest.approx(share, rel=1e-12)
    assert truth.supply == pytest.approx(1 - 0.4 * share, rel=1e-12)


def test_effects_that_a_vehicle_cannot_have_are_refused() -> None:
    with pytest.raises(ValueError, match=r"thruster': expected 0 to 5; found 6"):
        body_with(C, [effect("thruster_failure", sizes={"failed": 1.0}, thruster=6, kind="stopped")])
    heavy = load_vehicle_settings("bluerov2_heavy").coefficients
    with pytest.raises(ValueError, match="needs the hand, left or right, of each propeller"):
        body_with(heavy, [effect("reaction_torque", sizes={"share": 1.0})])
    with pytest.raises(ValueError, match=r"share.unit': expected '1'; found 'N'"):
        active_effect(EffectEntry(id="thrust_loss", sizes={"share": 0.2}, units={"share": "N"}))
    with pytest.raises(VehicleError, match="expected a YAML file or one of the known"):
        load_vehicle_settings("nowhere")
