"""All periods of a closed loop: in one kernel, or kernel by kernel with effects on samples in between."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rov_sim.closed_loop_kernel import OUTPUTS, control_period, plant_period, run_loop
from rov_sim.rig_sensors import flow_read, speed_read
from thruster_control.inner_loop import AT_REST
from thruster_estimation.belief import in_numbers
from thruster_model import flow_tank
from thruster_model.effects.active import ActiveEffects
from thruster_model.effects.stages import LIBRARY
from thruster_model.pipeline import memory_length

__all__ = ["by_sample_effects", "compiled_whole", "sampled"]

Array = NDArray[np.float64]
_NO_GATES = np.empty(0)


def sampled(effects: ActiveEffects) -> bool:
    """Return whether effects act on what enters or leaves the plant in the loop."""
    here = [LIBRARY[name] for name in effects.sizes if LIBRARY[name].samples is not None]
    signals = {"speed", "ambient"}
    return any(e.block == "command" or (e.block == "sensor" and signals & set(e.channel.split())) for e in here)


def _parts(plant: Any, controller: Any, step: float) -> tuple[Any, ...]:
    """Return (state, belief, effects, gates, history) as kernels take them."""
    e = plant.effects.plant
    gates = _NO_GATES if plant.gates is None else np.ascontiguousarray(plant.gates, dtype=np.float64)
    history = np.zeros(int(memory_length(0.0, e) / step + 0.5) + 1)
    return flow_tank.PlantState(*map(float, plant.start)), in_numbers(controller.belief), e, gates, history


def compiled_whole(wanted, noise, plant, controller, clock, wiring, entropy, dense, out):  # type: ignore[no-untyped-def]
    state, belief, e, gates, history = _parts(plant, controller, clock.dt / clock.steps)
    run_loop(
        wanted, noise, state, AT_REST, belief, clock, wiring, controller.observer, controller.law,
        controller.coefficients, plant.coefficients, e, gates, history, dense, out,
    )  # fmt: skip


def by_sample_effects(wanted, noise, plant, controller, clock, wiring, entropy, dense, out):  # type: ignore[no-untyped-def]
    """Fill `dense` and `out` as `run_loop` does, with effects on commands and sensors between the kernels."""
    S, step = clock.steps, clock.dt / clock.steps
    state, belief, e, gates, history = _parts(plant, controller, step)
    memory, effects = AT_REST, plant.effects
    observer, law, p = controller.observer, controller.law, controller.coefficients
    commands = np.zeros(wanted.size * S)
    seen_U, seen_T = 0.0, 0.0

    def plant_on(first: int, count: int, gate: float) -> Any:
        throttle = np.ascontiguousarray(effects.command(commands, step)[first : first + count])
        return plant_period(state, throttle, step, first, history, gate, plant.coefficients, e, dense)

    for k in range(wanted.size):
        gate = float(gates[min(k, gates.size - 1)]) if gates.size else 1.0
        first, wired, T_d = k * S, (clock, wiring, observer, law, p, out), float(wanted[k])
        memory, belief = control_period(0, memory, belief, T_d, 0.0, seen_U, seen_T, k, *wired)
        if wiring.bench:
            commands[first + clock.delay :] = out[1, k]
            state, known = plant_on(first, S, gate), first + S
        else:
            known = first
            if k == 0:
                plant_on(0, 0, gate)
        at = max(first + clock.sample, 0)
        told = _sensors(dense, known, effects, step, entropy, at)
        y_n = speed_read(told["speed"], noise.speed[k], bool(wiring.quantised))
        seen_U = float(noise.told[k])
        if not np.isfinite(seen_U):
            seen_U = float(flow_read(told["ambient"], noise.flow[k], noise.eddies[k], bool(wiring.quantised)))
        seen_T = float(dense[3, at] + noise.load[k])
        memory, belief = control_period(1, memory, belief, T_d, float(y_n), seen_U, seen_T, k, *wired)
        if not wiring.bench:
            commands[first + clock.delay :] = out[1, k]
            state = plant_on(first, S, gate)


def _sensors(dense: Array, known: int, effects: ActiveEffects, step: float, entropy: list[int], at: int) -> Any:
    """Return what speed and ambient flow read at index `at`, of a record that is known up to index `known`."""
    held = dense.copy()
    held[:, known + 1 :] = dense[:, known : known + 1]
    outputs = dict(zip(OUTPUTS, held, strict=True))
    return {
        name: float(effects.reading(name, outputs, step, np.random.default_rng([*entropy, i]))[at])
        for i, name in enumerate(("speed", "ambient"))
    }
