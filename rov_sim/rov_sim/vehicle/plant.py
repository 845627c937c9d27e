"""A vehicle with its thrusters: a whole run at once, or period by period with the same numbers.

settings = vehicle_settings(load_vehicle_set("ngs"))
run = simulate(settings, throttles, 0.04)                                  # throttles (K, N) [V]
plant = VehiclePlant(settings)
truth = plant.advance(throttles[0], 0.04)
"""

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rov_sim.vehicle.kernel import advance_period, measured, record_width, run_vehicle
from rov_sim.vehicle.tables import BODY, MEMORY, STATE, Tables, empty_sheet, tables_of
from rov_sim.vehicle.truth import VehicleState, VehicleTrajectory, VehicleTruth, at_rest, trajectory_of, truth_of
from thruster_model.effects.chains import command_begin, command_memory
from thruster_model.effects.stages import NO_EFFECTS
from thruster_model.errors import VehicleError
from thruster_model.pipeline import memory_length
from thruster_model.vehicle_coefficients import VehicleCoefficients

__all__ = ["VehiclePlant", "VehicleSettings", "sheet_of", "simulate"]

Array = NDArray[np.float64]
LARGEST_STEP = 1e-3
_FASTEST = 2.5  # rate times step up to which RK4 damps, with room


@dataclass(frozen=True, kw_only=True)
class VehicleSettings:
    """What a plant is made of, checked when constructed.

    Attributes:
        coefficients: of body, water and layout.
        thrusters: N coefficients of one class.
        effects: N `EffectValues`, or N `NO_EFFECTS` (the default).
        initial: state at the first instant; at rest where none is given.
        largest_step: upper bound of the integration step [s]; shorter ones are taken where an effect is abrupt.

    Raises:
        VehicleError: what is wrong with any of them.
    """

    coefficients: VehicleCoefficients
    thrusters: tuple[Any, ...]
    effects: tuple[Any, ...] = ()
    initial: VehicleState | None = None
    largest_step: float = LARGEST_STEP
    tables: Tables = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "thrusters", tuple(self.thrusters))
        object.__setattr__(self, "effects", tuple(self.effects) or (NO_EFFECTS,) * len(self.thrusters))
        object.__setattr__(self, "tables", tables_of(self.coefficients, self.thrusters, self.effects))
        if self.initial is None:
            object.__setattr__(self, "initial", at_rest(self.count))
        problems = self._state_problems() + self._step_problems()
        if any(memory_length(0.0, e) > 0.0 for e in self.effects):
            problems.append("effects: tank_recirculation belongs to a flow tank; a vehicle has none")
        if problems:
            raise VehicleError("vehicle", problems)

    @property
    def count(self) -> int:
        """Number of thrusters."""
        return self.coefficients.thrusters

    def steps_in(self, period: float) -> int:
        """Return how many steps a period [s] takes."""
        if not (math.isfinite(period) and period > 0.0):
            raise VehicleError("vehicle", [f"period: expected a positive time; found {period} s"])
        steps = max(1, math.ceil(period / self.largest_step - 1e-9))
        if self.remembers and abs(period / steps / self.largest_step - 1.0) > 1e-6:
            expected = (
                f"expected a multiple of the step, {self.largest_step:g} s, at which delays of commands are remembered"
            )
            raise VehicleError("vehicle", [f"period: {expected}; found {period:g} s"])
        return steps

    @property
    def remembers(self) -> bool:
        """Whether effects of the command remember more than one step."""
        return any(command_memory(self.largest_step, e) > 1 for e in self.effects)

    def _state_problems(self) -> list[str]:
        problems = []
        expected = {"position": (3,), "attitude": (4,), "velocity": (6,), "thrusters": (self.count, 4)}
        for name, shape in expected.items():
            value = np.asarray(getattr(self.initial, name), dtype=np.float64)
            if value.shape != shape or not np.all(np.isfinite(value)):
                problems.append(f"initial.{name}: expected finite numbers of shape {shape}; found {value.tolist()}")
            elif name == "attitude" and abs(np.linalg.norm(value) - 1.0) > 1e-6:
                problems.append(f"initial.attitude: expected a unit quaternion; found length {np.linalg.norm(value):g}")
        return problems

    def _step_problems(self) -> list[str]:
        if not (math.isfinite(self.largest_step) and self.largest_step > 0.0):
            return [f"largest_step: expected a positive time; found {self.largest_step} s"]
        rates = {"a rotor (k_n)": max(abs(float(p.k_n)) for p in self.thrusters if p.drive_gain != 0.0)}
        rates["an axial flow (k_v)"] = max(abs(float(p.k_v)) for p in self.thrusters)
        matrices = (np.asarray(m, dtype=np.float64) for m in (self.coefficients.mass_matrix, self.coefficients.D_L))
        rates["the body's drag"] = _settling(*(m.tobytes() for m in matrices))
        return [
            f"largest_step: expected at most {_FASTEST / rate:.3g} s, as {what} settles at {rate:.4g} 1/s; found "
            f"{self.largest_step:g} s"
            for what, rate in rates.items()
            if rate * self.largest_step > _FASTEST
        ]


@lru_cache(maxsize=512)
def _settling(M: bytes, D_L: bytes) -> float:
    """Return the largest rate [1/s] at which linear drag lets a body settle, of two matrices of doubles (6, 6)."""
    inertia, drag = (np.frombuffer(each).reshape(6, 6) for each in (M, D_L))
    return float(np.max(np.abs(np.linalg.eigvals(np.linalg.solve(inertia, drag)))))


def sheet_of(settings: VehicleSettings) -> Array:
    """Return a sheet with the initial state, for kernels."""
    N, state = settings.count, settings.initial
    assert state is not None
    plain = all(e is NO_EFFECTS for e in settings.effects)
    memory = max(command_memory(settings.largest_step, e) for e in settings.effects)
    sheet = empty_sheet(N, None if plain else memory)
    row = sheet[STATE]
    row[:3], row[3:7], row[7:BODY] = state.position, state.attitude, state.velocity
    row[BODY : BODY + 4 * N] = np.asarray(state.thrusters, dtype=np.float64).T.ravel()
    stand_still(sheet, settings)
    if not plain:
        for i, e in enumerate(settings.effects):
            command_begin(sheet[MEMORY + i], float(state.thrusters[i, 2]), settings.largest_step, e)
    return sheet


def stand_still(sheet: Array, settings: VehicleSettings) -> None:
    """Make rotors that have stopped stand still."""
    N, row, stuck = settings.count, sheet[STATE], settings.coefficients.turning == 0.0
    row[BODY : BODY + N][stuck] = 0.0
    row[BODY + 2 * N : BODY + 3 * N][stuck] = 0.0


def _state(sheet: Array, N: int) -> VehicleState:
    row = sheet[STATE].copy()
    return VehicleState(row[:3], row[3:7], row[7:BODY], row[BODY : BODY + 4 * N].reshape(4, N).T.copy())


def _diverged(time: float, step: float) -> VehicleError:
    why = "the step is too long for what moves that fast, or a parameter is beyond what a vehicle is"
    return VehicleError(
        "vehicle", [f"state: expected finite numbers; found others after {time:.6g} s at {step:g} s: {why}"]
    )


def _numbers(name: str, values: ArrayLike, shape: tuple[int, ...]) -> Array:
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.shape != shape:
        raise VehicleError("vehicle", [f"{name}: expected shape {shape}; found {array.shape}"])
    if not np.all(np.isfinite(array)):
        raise VehicleError("vehicle", [f"{name}: expected finite numbers; found {array[~np.isfinite(array)][0]}"])
    return array


def simulate(
    settings: VehicleSettings,
    u_commanded: ArrayLike,
    dt: float,
    *,
    wrench: ArrayLike | None = None,
    gates: ArrayLike | None = None,
) -> VehicleTrajectory:
    """Simulate a vehicle under commanded throttles.

    Args:
        settings: what the plant is made of.
        u_commanded: throttle commands [V], shape (K, N), each held for `dt`.
        dt: period of the commands [s].
        wrench: what acts on the body from outside in each period (K, 6), body axes [N, N m].
        gates: 0 in periods in which a propeller may draw air, else 1 (K, N).

    Returns:
        Trajectory at the K + 1 instants 0, dt, ..., K dt.

    Raises:
        VehicleError: inputs of other shapes or not finite; a state that is no longer finite.
    """
    K, N = np.shape(u_commanded)[0], settings.count
    commands = _numbers("u_commanded", u_commanded, (K, N))
    wrenches = _numbers("wrench", np.zeros((K, 6)) if wrench is None else wrench, (K, 6))
    opened = _numbers("gates", np.ones((K, N)) if gates is None else gates, (K, N))
    steps = settings.steps_in(dt)
    sheet, out = sheet_of(settings), np.empty((K + 1, record_width(N)))
    if K == 0:
        measured(sheet, np.ones(N), np.zeros(6), *settings.tables, out[0])
    done = run_vehicle(sheet, commands, steps, dt / steps, opened, wrenches, *settings.tables, out)
    if done < K:
        raise _diverged(done * dt, dt / steps)
    return trajectory_of(dt * np.arange(K + 1), out, _state(sheet, N))


class VehiclePlant:
    """A vehicle that is advanced period by period."""

    def __init__(self, settings: VehicleSettings, *, time: float = 0.0) -> None:
        self.settings = settings
        self._sheet = sheet_of(settings)
        self._time = time
        self._out = np.empty(record_width(settings.count))
        self._calm, self._open = np.zeros(6), np.ones(settings.count)

    @property
    def time(self) -> float:
        """Time of the state [s]."""
        return self._time

    @property
    def state(self) -> VehicleState:
        """The state, a copy: a plant made with it goes on from here."""
        return _state(self._sheet, self.settings.count)

    def turn(self, thruster: int, n: float) -> None:
        """Give a rotor a speed [rad/s]; one that has stopped keeps standing still."""
        self._sheet[STATE, BODY + thruster] = n
        stand_still(self._sheet, self.settings)

    def change(self, settings: VehicleSettings) -> None:
        """Go on from the present state as what is made of other settings.

        What effects remember of commands stays where the new ones remember as many steps.
        """
        sheet = sheet_of(replace(settings, initial=self.state))
        if sheet.shape == self._sheet.shape:
            sheet[:] = self._sheet
            stand_still(sheet, settings)
        self.settings, self._sheet = settings, sheet

    def truth(self, wrench: ArrayLike | None = None, gates: ArrayLike | None = None) -> VehicleTruth:
        """Return what is true now, under an outer wrench (6,) [N, N m], with gates (N,)."""
        w, g = self._outside(wrench, gates)
        measured(self._sheet, g, w, *self.settings.tables, self._out)
        return truth_of(self._time, self._out.copy())

    def advance(
        self, throttles: ArrayLike, period: float, wrench: ArrayLike | None = None, gates: ArrayLike | None = None
    ) -> VehicleTruth:
        """Hold throttles (N,) [V] for a period [s]; return what is true at its end.

        Raises:
            VehicleError: inputs of other shapes or not finite; a state that is no longer finite.
        """
        commands = _numbers("throttles", throttles, (self.settings.count,))
        w, g = self._outside(wrench, gates)
        steps = self.settings.steps_in(period)
        advance_period(self._sheet, commands, steps, period / steps, g, w, *self.settings.tables)
        if not np.all(np.isfinite(self._sheet[STATE])):
            raise _diverged(self._time, period / steps)
        self._time += period
        return self.truth(w, g)

    def _outside(self, wrench: ArrayLike | None, gates: ArrayLike | None) -> tuple[Array, Array]:
        return (
            self._calm if wrench is None else _numbers("wrench", wrench, (6,)),
            self._open if gates is None else _numbers("gates", gates, (self.settings.count,)),
        )
