"""Lines in space: a path with what is drawn along it, to be turned by hand."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import plotly.graph_objects as go

from ..decimation import compact, keep_extremes
from ..errors import ReportError
from .axis import Axis, plot_text
from .plot import Plot
from .series import Role, colour_indices, colour_of, reduction_note

_WIDTHS = {"data": 3.0, "fit": 4.0, "reference": 2.0}


@dataclass(frozen=True, kw_only=True, eq=False)
class Track:
    """A line in space.

    Args:
        name: shown in the legend; tracks of one name share colour and legend entry.
        x, y, z: (n,) in the units of the axes; NaN makes a gap.
        role: "data" is drawn in grey, "fit" in colour, "reference" thin and light.
        color: index into the palette, as that of a `Series`.
    """

    name: str
    x: npt.ArrayLike
    y: npt.ArrayLike
    z: npt.ArrayLike
    role: Role = "fit"
    color: int | None = None

    def __post_init__(self) -> None:
        shapes = set()
        for name in ("x", "y", "z"):
            array = np.array(getattr(self, name), dtype=np.float64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)
            shapes.add(array.shape)
        if len(shapes) > 1 or len(next(iter(shapes))) != 1:
            raise ReportError(f"track {self.name!r}: expected x, y and z of one shape (n,), got {sorted(shapes)}")


def needles(name: str, start: npt.ArrayLike, end: npt.ArrayLike, *, color: int | None = None) -> Track:
    """Return straight pieces from `start` to `end`, (n, 3) each, as one track with gaps."""
    a, b = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    if a.shape != b.shape or a.ndim != 2 or a.shape[1] != 3:
        raise ReportError(f"needles {name!r}: expected start and end of one shape (n, 3), got {a.shape}, {b.shape}")
    x, y, z = np.stack([a, b, np.full_like(a, np.nan)], axis=1).reshape(-1, 3).T
    return Track(name=name, x=x, y=y, z=z, color=color)


def space(
    tracks: Sequence[Track],
    *,
    x: Axis,
    y: Axis,
    z: Axis,
    z_down: bool = False,
    max_points: int = 2000,
    height: int = 460,
) -> Plot:
    """Draw tracks in space, one unit of length alike in all directions.

    Args:
        tracks: what to draw; those without gaps are reduced when they are longer than `max_points`.
        x, y, z: the axes, drawn right-handed with z up.
        z_down: z grows downwards; x, y, z are then left-handed, as east, north, depth are.
        max_points: longer tracks are reduced for display, keeping every extreme; the plot then says so.
        height: in CSS pixels.
    """
    if not tracks:
        raise ReportError("space: expected at least one track, got none")
    indices = colour_indices(tracks)
    traces: list[dict[str, Any]] = []
    named: set[str] = set()
    longest = 0
    for track in tracks:
        values = tuple(np.asarray(v) for v in (track.x, track.y, track.z))
        whole = bool(np.isfinite(values).all())
        kept = keep_extremes(*values, max_points=max_points) if whole else np.arange(values[0].size)
        longest = max(longest, values[0].size if kept.size < values[0].size else 0)
        traces.append(
            {
                "type": "scatter3d",
                "mode": "lines",
                **{key: compact(v[kept]) for key, v in zip("xyz", values, strict=True)},
                "name": plot_text(track.name),
                "legendgroup": plot_text(track.name),
                "showlegend": track.name not in named,
                "line": {"color": colour_of(track, indices), "width": _WIDTHS[track.role]},
                "hovertemplate": "<br>".join((x.readout("x"), y.readout("y"), z.readout("z"))),
            }
        )
        named.add(track.name)
    scene = {
        "xaxis": {"title": {"text": x.full}},
        "yaxis": {"title": {"text": y.full}},
        "zaxis": {"title": {"text": z.full}, **({"autorange": "reversed"} if z_down else {})},
        "aspectmode": "data",
        "dragmode": "turntable",
        "camera": {"eye": {"x": -1.5, "y": -1.65, "z": 0.9}, "center": {"x": 0.0, "y": 0.0, "z": -0.15}},
    }
    layout = {"scene": scene, "hovermode": "closest", "margin": {"l": 0, "r": 0, "t": 0, "b": 0}}
    return Plot(figure=go.Figure(data=traces, layout=layout), notes=reduction_note(longest, max_points), height=height)
