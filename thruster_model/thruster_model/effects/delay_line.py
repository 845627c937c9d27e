"""Samples that come late: a ring of those that are still on their way."""

from thruster_model.compilation import equation

__all__ = ["delayed", "filled", "line_floats", "remainder"]

_ROUNDING = 1e-9


@equation
def _whole(time, step):  # type: ignore[no-untyped-def]
    return int(time / step + _ROUNDING)


@equation
def remainder(time, step):  # type: ignore[no-untyped-def]
    """Return by how much of a step, 0 to below 1, a delay [s] is longer than whole steps [s]."""
    left = time / step - _whole(time, step)
    return left if left > _ROUNDING else 0.0


@equation
def line_floats(time, step):  # type: ignore[no-untyped-def]
    """Return the size of a line's memory: a place in the ring, and the ring."""
    return _whole(time, step) + 2


@equation
def filled(line, x):  # type: ignore[no-untyped-def]
    """Let a line be as if x had gone in for long."""
    line[0] = 0.0
    line[1:] = x


@equation
def delayed(line, x):  # type: ignore[no-untyped-def]
    """Return (the sample of as many whole steps before as the line is long, the one before that); take x in."""
    ring = line[1:]
    place = int(line[0])
    before = ring[place]
    following = (place + 1) % ring.size
    ring[place] = x
    line[0] = following
    return ring[following], before
