"""The structure between thruster and load cell is springy: it rings along the thrust after jumps."""

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter
from thruster_model.effects.mode import moved


@equation
def floats(step, e):  # type: ignore[no-untyped-def]
    """Return the size of the memory: load, reading and its rate at the last sample."""
    return 3


@equation
def sample(memory, x, outputs, step, e):  # type: ignore[no-untyped-def]
    """Return the reading of the mode, from rest without a load; exact for a load in straight lines between samples."""
    f, zeta = e.load_cell_resonance_frequency, e.load_cell_resonance_damping
    memory[1], memory[2] = moved(memory[1], memory[2], memory[0], x, step, f, zeta)
    memory[0] = x
    return memory[1]


EFFECT = Effect(
    id="load_cell_resonance",
    title="resonance of the load cell",
    block="sensor",
    equation="d2y/dt2 + 2 zeta w dy/dt + w^2 y = w^2 T, w = 2 pi f",
    parameters=(
        EffectParameter(
            name="frequency", unit="Hz", meaning="of the mode", lower=1.0, upper=30.0, neutral=float("inf")
        ),
        EffectParameter(
            name="damping", unit="1", meaning="share of the critical damping", lower=0.005, upper=1.0, neutral=0.05
        ),
    ),
    sample=sample,
    floats=floats,
    channel="thrust",
    order=1,
    search="fine",
    tries=(24, 5),
    steady=False,
)
