"""What pictures of studies share: a backend without a screen, plain panels, files that depend on content alone."""

from pathlib import Path
from typing import Any

from safe_files.whole_files_io import whole_file

__all__ = ["BLUE", "GREY", "RED", "plain", "pyplot", "save"]

BLUE, RED, GREY = "#0072b2", "#d55e00", "#8b949e"


def pyplot() -> Any:
    """Return matplotlib.pyplot, set up."""
    import matplotlib  # half a second to import

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    matplotlib.rcParams["svg.fonttype"] = "none"
    matplotlib.rcParams["svg.hashsalt"] = "study"
    return plt


def plain(panel: Any) -> None:
    """Give a panel a light grid and take its upper and right edge away."""
    panel.grid(color="#dddddd", linewidth=0.6)
    panel.spines[["top", "right"]].set_visible(False)


def save(figure: Any, file: Path) -> None:
    """Write the figure and close it."""
    figure.tight_layout()
    with whole_file(file, replace=True) as partial:
        figure.savefig(partial, metadata={"Date": None} if file.suffix == ".svg" else None, dpi=110)
    pyplot().close(figure)
