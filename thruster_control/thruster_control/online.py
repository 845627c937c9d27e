"""An inner loop while estimates arrive: what it remembers from one instant to the next, as a pure function."""

from typing import Any, NamedTuple

from thruster_control.inner_loop import AT_REST, Memory, Output, compiled_step

__all__ = ["START", "Inputs", "Track", "advance"]


class Inputs(NamedTuple):
    """What is known at an instant [ns]; NaN: not.

    T_d: wanted thrust [N]; n [rad/s], v, U [m/s]: estimates, usable where `valid`, `age` [s] old; T: measured
    thrust [N]; supply: its voltage over the nominal one.
    """

    stamp: int
    T_d: float
    n: float
    v: float
    U: float
    valid: bool
    T: float
    age: float
    supply: float = 1.0


class Track(NamedTuple):
    """The memory after the instant `stamp` [ns]; None before the first."""

    memory: Memory
    stamp: int | None


START = Track(AT_REST, None)


def advance(track: Track, inputs: Inputs, period: float, settings: Any, p: Any) -> tuple[Track, Output]:
    """Return the track after an instant, and the loop's output.

    The first instant, and each that does not lie after the former one, begins anew: at rest, over one nominal `period`
    [s]. `settings`, `p`: as `inner_loop_step` takes them.
    """
    memory, dt = track.memory, float(period)
    if track.stamp is not None:
        dt = (inputs.stamp - track.stamp) / 1e9
        if dt <= 0.0:
            memory, dt = AT_REST, float(period)
    memory, out = compiled_step(
        memory,
        inputs.T_d,
        inputs.n,
        inputs.v,
        inputs.U,
        inputs.valid,
        dt,
        settings,
        p,
        inputs.T,
        inputs.age,
        inputs.supply,
    )
    return Track(Memory(*memory), inputs.stamp), Output(*out)
