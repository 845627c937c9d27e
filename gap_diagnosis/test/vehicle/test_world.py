"""The world of sealed cases and the plant share no code; a vehicle without effects must move alike in both."""

import numpy as np
import pytest

from gap_diagnosis.vehicle.blind.draws import EFFECTS, Draw, drawn
from gap_diagnosis.vehicle.blind.truth import truth_of
from gap_diagnosis.vehicle.blind.world import run_world
from rov_sim.vehicle.effects.active import VEHICLE_LIBRARY, ActiveVehicleEffect
from rov_sim.vehicle.plant import simulate
from rov_sim.vehicle.settings import vehicle_settings
from rov_sim.vehicle.truth import at_rest
from thruster_model.effects import stages
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.vehicle_set_io import load_vehicle_set


@pytest.mark.parametrize(("name", "diameter"), [("bluerov2_heavy", 0.0), ("ngs", 0.0), ("ngs", 0.08)])
def test_a_vehicle_moves_in_both_alike(name: str, diameter: float) -> None:
    vehicle, own = load_vehicle_set(name), load_parameter_set("hq")
    N, K = len(vehicle.layout), 500
    draw = Draw(seed=1, vehicle=name, deviations=0.0, effects=(("ram_drag", {}, {"diameter": diameter}),))
    ram = ActiveVehicleEffect(id="ram_drag", sizes={"diameter": diameter})
    truth = truth_of(draw, vehicle, (own,) * N)
    rng = np.random.default_rng(0)
    base = np.repeat(rng.uniform(-3.0, 3.0, (K // 25, N)), 25, axis=0)
    sent, out, speeds = np.zeros((K, N)), np.zeros((K * 20, 18)), np.zeros((K * 20, N))
    run_world(
        base, 20, truth.thrusters, truth.M, truth.D_L, truth.D_Q, truth.weight, truth.buoyancy, truth.r_G, truth.r_B,
        truth.current, truth.tether, truth.ram, truth.interaction, truth.sag, truth.wiring, truth.sign, truth.sliding,
        np.zeros((K, 6)), np.array([0.0, 0.0, 3.0]), np.eye(3), np.zeros((N, 12)), np.zeros((K, 4)), np.zeros((K, 12)),
        np.array([1.0, 0.0]), out, speeds, sent, np.zeros((K * 20, 2)),
    )  # fmt: skip
    begin = at_rest(N, position=(0.0, 0.0, 3.0))
    run = simulate(vehicle_settings(vehicle, [own] * N, initial=begin, effects=(ram,)), sent, 0.04)
    # both of them are exact to a step's square; a rotor a step late would differ by a rad/s in its transients
    assert np.abs(out[::20, 12:18] - run.velocity[:-1]).max() < 0.005 * np.abs(run.velocity).max()
    assert np.abs(speeds[::20] - run.n[:-1]).max() < 0.15


def test_every_hidden_effect_is_one_of_the_libraries_and_its_size_within_their_range() -> None:
    for effect, sizes in EFFECTS.items():
        library = VEHICLE_LIBRARY.get(effect) or stages.LIBRARY[effect]
        ranges = {p.name: p for p in library.parameters}
        for name, _, largest in sizes:
            assert largest <= ranges[name].upper, (effect, name)


def test_a_seed_is_a_case() -> None:
    assert drawn(1234) == drawn(1234)
    kinds = [len(drawn(s).effects) for s in range(200)]
    assert {0, 1, 2} == set(kinds)
