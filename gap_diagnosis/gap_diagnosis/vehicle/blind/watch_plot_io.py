"""How long the watch took for a loss of thrust, against what that thruster gave on average, as a picture."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from safe_files.whole_files_io import whole_file

__all__ = ["draw_delays"]

_LONGEST = 60.0  # s, for which a loss was watched
_LEAST = 0.02  # N


def draw_delays(path: Path, found: Sequence[tuple[str, float, float]], threshold: float) -> None:
    """Draw (kind of dive, mean thrust [N], delay [s], infinity: not found) of each loss; replaces what is there."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.fonttype"] = "none"
    matplotlib.rcParams["svg.hashsalt"] = "watch"
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6.4, 3.6), layout="constrained")
    for k, kind in enumerate(dict.fromkeys(kind for kind, _, _ in found)):
        thrust = np.array([max(t, _LEAST) for each, t, _ in found if each == kind])
        delay = np.array([d for each, _, d in found if each == kind])
        there = np.isfinite(delay)
        axes.scatter(thrust[there], delay[there], s=16, color=f"C{k}", label=kind)
        axes.scatter(thrust[~there], np.full((~there).sum(), 1.1 * _LONGEST), s=20, color=f"C{k}", marker="^")
    axes.axhline(10.0, color="0.6", linewidth=0.8, linestyle="--")
    axes.set(
        xscale="log", yscale="log", xlabel="mean thrust of the thruster [N]", ylabel="delay [s]",
        title=f"Loss of 30 %, threshold {threshold:.0f}; triangles: not found in {_LONGEST:.0f} s",
    )  # fmt: skip
    axes.title.set_fontsize(9)
    axes.legend(frameon=False)
    axes.grid(alpha=0.2)
    with whole_file(path, replace=True) as partial:
        figure.savefig(partial, metadata={"Date": None} if path.suffix == ".svg" else None)
    pyplot.close(figure)
