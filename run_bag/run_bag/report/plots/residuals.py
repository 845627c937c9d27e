"""What a model leaves over, in time and in frequency, side by side."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from .axis import FREQUENCY, TIME, Axis
from .curves import curves
from .plot import Plot
from .series import Series


@dataclass(frozen=True, kw_only=True, eq=False)
class Residual:
    """Residuals of one model, and their spectrum, computed by the caller.

    Args:
        name: of the model.
        time: (n,) [s].
        value: (n,) measured − predicted, in the unit of the channel; NaN makes a gap.
        frequency: (m,) [Hz], > 0.
        density: (m,) amplitude spectral density, in the channel's unit per √Hz.
        color: index into the palette.
    """

    name: str
    time: npt.ArrayLike
    value: npt.ArrayLike
    frequency: npt.ArrayLike
    density: npt.ArrayLike
    color: int | None = None


def residuals(
    models: Sequence[Residual],
    *,
    quantity: Axis,
    noise_floor: float | None = None,
    max_points: int = 1500,
    height: int = 300,
) -> tuple[Plot, Plot]:
    """Draw residuals over time and their spectrum; give both to `Report.figure` as one figure.

    Args:
        models: one or more models of the same channel.
        quantity: the channel, with its unit.
        noise_floor: amplitude spectral density of the sensor's noise, in the channel's unit per √Hz;
            drawn as a line.
        max_points: longer series are reduced for display, keeping every extreme; the plot then says so.
        height: in CSS pixels.
    """
    over_time = [Series(name=m.name, x=m.time, y=m.value, color=m.color) for m in models]
    spectra = [Series(name=m.name, x=m.frequency, y=m.density, color=m.color) for m in models]
    if noise_floor is not None and spectra:
        f = np.concatenate([np.asarray(m.frequency, dtype=np.float64) for m in models])
        ends = [np.min(f[f > 0.0]), np.max(f)]
        spectra.append(Series(name="noise floor", x=ends, y=[noise_floor] * 2, role="reference"))
    error = Axis(name=f"residual of {quantity.name}", unit=quantity.unit)
    frequency = Axis(name=FREQUENCY.name, unit=FREQUENCY.unit, symbol=FREQUENCY.symbol, log=True)
    density = Axis(name="amplitude density", unit=f"{quantity.unit}/√Hz", log=True)
    left = curves(over_time, x=TIME, y=error, max_points=max_points, height=height)
    right = curves(spectra, x=frequency, y=density, max_points=max_points, height=height)
    return replace(left, notes=("Residual: measured − predicted.", *left.notes)), right
