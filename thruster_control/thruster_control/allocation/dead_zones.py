r"""Thrusts away from the dead zone: |T_i| >= smallest, by null vectors where there are some, else by a wrench error.

A null vector z changes the thrusts without changing the wrench: T + c z. The smallest |c| that takes all thrusters of
z out of the dead zone is 0 or lies at an end of one of the forbidden stretches |T_i + c z_i| < smallest. The former
choice has an advantage of `hysteresis`, so that noise does not toss between two of them. With several null vectors
they are tried one after the other: exact where they share no thruster.

Where no null vector helps, a thruster that needs less than `smallest` is asked for the nearer of 0 and `smallest` on
its side, changed with a hysteresis around the middle. It is off by at most (smallest + hysteresis) / 2.
"""

from thruster_model.compilation import equation

__all__ = ["away_by_null_vectors", "held_side"]

_ROUNDING = 1e-12


@equation
def _allowed(T, z, c, smallest, lower, upper):  # type: ignore[no-untyped-def]
    """Return whether T + c z stays out of the dead zone, and within the limits as far as T does."""
    for i in range(T.shape[0]):
        if z[i] == 0.0:
            continue
        moved = T[i] + c * z[i]
        if abs(moved) < smallest - _ROUNDING or moved > max(upper[i], T[i]) or moved < min(lower[i], T[i]):
            return False
    return True


@equation
def _cost(c, former, hysteresis):  # type: ignore[no-untyped-def]
    """Return |c|, and `hysteresis` [N] more on the other side of a former choice."""
    return abs(c) + (hysteresis if c * former < 0.0 else 0.0)


@equation
def _share_of(T, z, former, smallest, hysteresis, lower, upper):  # type: ignore[no-untyped-def]
    """Return c [N] for one null vector; 0 where none is needed, or none is allowed."""
    if _allowed(T, z, 0.0, smallest + (hysteresis if former != 0.0 else 0.0), lower, upper):
        return 0.0
    best, least = 0.0, -1.0
    for i in range(T.shape[0]):
        if z[i] == 0.0:
            continue
        for side in (1.0, -1.0):
            c = (side * smallest - T[i]) / z[i]
            cost = _cost(c, former, hysteresis)
            # of two that cost the same the positive one, whatever rounding says
            cheaper = least < 0.0 or cost < least - _ROUNDING or (cost < least + _ROUNDING and c > best)
            if cheaper and _allowed(T, z, c, smallest, lower, upper):
                best, least = c, cost
    return best


@equation
def away_by_null_vectors(T, null, along, smallest, hysteresis, lower, upper):  # type: ignore[no-untyped-def]
    """Move T (N,) [N] in place; null (k, N); along (>= k,) [N] holds the former shares and is filled with the new."""
    for k in range(null.shape[0]):
        z = null[k]
        c = _share_of(T, z, along[k], smallest, hysteresis, lower, upper)
        along[k] = c
        for i in range(T.shape[0]):
            T[i] += c * z[i]


@equation
def held_side(T, side, smallest, hysteresis):  # type: ignore[no-untyped-def]
    """Return (thrust [N], side) of one thruster; side 1.0, -1.0, or 0.0 while it stands still."""
    if abs(T) >= smallest - _ROUNDING:
        return T, (1.0 if T > 0.0 else -1.0)
    edge = 0.5 * (smallest - hysteresis if side * T > 0.0 else smallest + hysteresis)
    if abs(T) > edge:
        side = 1.0 if T > 0.0 else -1.0
    else:
        side = 0.0
    return side * smallest, side
