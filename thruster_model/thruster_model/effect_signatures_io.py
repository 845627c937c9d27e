"""What each effect does to what sensors read, as one picture: a row an effect, a column a signal."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thruster_model.effects.chains import SENSED
from thruster_model.effects.effect import Effect, EffectParameter
from thruster_model.effects.stages import LIBRARY, NEUTRAL, effect_values
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.whole_run import readings, simulated_rows

__all__ = ["draw_signatures", "signatures", "typical_sizes"]

Array = NDArray[np.float64]
_STEP = 0.005
_UNITS = {"speed": "n [rad/s]", "thrust": "T [N]", "torque": "Q [N m]", "axial": "v [m/s]", "ambient": "U [m/s]"}
_LEAST = {"speed": 1e-3, "thrust": 1e-4, "torque": 1e-6, "axial": 1e-6, "ambient": 1e-6}
"""Of a change that is drawn: below it the integration's own error."""
_SET = "hl"
_SEED = 1


def _programme() -> tuple[Array, Array]:
    """Return (time [s], throttle [V]): steps both ways, a short reversal, a ramp through the dead zone."""
    time = np.arange(0.0, 20.0, _STEP)
    steps = np.select([time < 1.0, time < 4.0, time < 7.0, time < 8.0, time < 10.0], [0.0, 3.0, -3.0, 4.5, 1.5], 0.0)
    return time, np.where(time < 10.0, steps, 4.0 * np.sin(2.0 * np.pi * (time - 10.0) / 10.0))


def typical_sizes(effect: Effect) -> dict[str, float]:
    """Return half the range of an effect's first size, of all where each is one by itself, else the others as usual."""
    first, *others = effect.parameters
    if effect.apart:
        return {p.name: _half(p) for p in effect.parameters}
    sizes = {first.name: _half(first)}
    for p in others:
        inside = p.lower < p.neutral < p.upper
        sizes[p.name] = p.neutral if inside or p.neutral == p.upper else _half(p)
    return sizes


def _half(p: EffectParameter) -> float:
    if p.lower < p.neutral < p.upper:
        return 0.5 * p.upper
    return 0.5 * (p.lower + p.upper) if np.isfinite(p.neutral) else p.lower + 0.2 * (p.upper - p.lower)


def signatures() -> tuple[Array, dict[str, dict[str, Array]]]:
    """Return instants [s] and, by effect and signal, what is read with it less what is read without."""
    time, throttle = _programme()
    coefficients = load_parameter_set(_SET).coefficients
    closed = np.where(
        (time > 2.0) & (time < 3.0) | (time > 12.0) & (time < 13.0), 0.0, 1.0
    )  # of effects that come and go

    def read(effects: Any) -> Mapping[str, Array]:
        rows = simulated_rows(coefficients, throttle, _STEP, largest_step=_STEP / 2.0, effects=effects, gates=closed)
        return dict(zip(SENSED, readings(rows, _STEP, effects, _SEED)[:, :-1], strict=True))

    plain = read(NEUTRAL)
    out = {}
    for name, effect in LIBRARY.items():
        sizes = typical_sizes(effect)
        if effect.logged is None:
            seen = read(effect_values({name: sizes}))
        else:
            seen = {signal: _logged(effect, sizes, signal, time, values) for signal, values in plain.items()}
        out[name] = {signal: seen[signal] - plain[signal] for signal in SENSED}
    return time, out


def _logged(effect: Effect, sizes: Mapping[str, float], signal: str, time: Array, values: Array) -> Array:
    assert effect.logged is not None
    whole = {p.name: sizes.get(p.name, p.neutral) for p in effect.parameters}
    stamps, told = effect.logged(signal, time, values, np.random.default_rng(_SEED), **whole)
    return np.asarray(np.interp(time, stamps, told))


def draw_signatures(file: Path) -> None:
    """Draw the picture.

    Raises:
        FileExistsError: the file exists and is not overwritten.
    """
    import matplotlib  # half a second to import

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    if file.exists():
        raise FileExistsError(f"{file}: exists and is not overwritten")
    time, found = signatures()
    figure, panels = plt.subplots(
        len(found) + 1, len(SENSED), figsize=(11.0, 0.52 * (len(found) + 1)), sharex=True, layout="constrained"
    )
    for panel in panels.ravel():
        panel.set_axis_off()
    for column, signal in enumerate(SENSED):
        panels[0, column].set_title(_UNITS[signal], fontsize=9)
    panels[0, 0].plot(*_programme(), color="#5b6770", linewidth=0.8)
    panels[0, 0].text(-0.05, 0.5, "throttle, up to 4.5 V", transform=panels[0, 0].transAxes, ha="right", fontsize=8)
    for row, (name, signals) in enumerate(found.items(), start=1):
        panels[row, 0].text(
            -0.05, 0.4, f"{LIBRARY[name].id}\n{_told(LIBRARY[name])}", transform=panels[row, 0].transAxes, ha="right",
            va="center", fontsize=7,
        )  # fmt: skip
        for column, signal in enumerate(SENSED):
            change, panel = signals[signal], panels[row, column]
            largest = float(np.max(np.abs(change)))
            largest = largest if largest > _LEAST[signal] else 0.0
            panel.plot(
                time,
                change if largest > 0.0 else 0.0 * change,
                color="#1f77b4" if largest > 0.0 else "#c8ced3",
                linewidth=0.7,
            )
            if largest > 0.0:
                panel.set_ylim(-1.15 * largest, 1.15 * largest)
                panel.text(1.0, 0.98, f"{largest:.2g}", transform=panel.transAxes, ha="right", va="top", fontsize=6)
    figure.savefig(file, dpi=90)
    plt.close(figure)


def _told(effect: Effect) -> str:
    units = {p.name: p.unit for p in effect.parameters}
    if effect.apart:
        first = effect.parameters[0]
        return f"each {typical_sizes(effect)[first.name]:g} {first.unit}"
    return ", ".join(f"{n} {s:g}{'' if units[n] == '1' else ' ' + units[n]}" for n, s in typical_sizes(effect).items())
