"""The drawing library of a page: the smallest of plotly.js's bundles that draws what is in it, packed."""

import base64
import gzip
import re
from collections.abc import Collection
from dataclasses import dataclass
from importlib.resources import files

from plotly.offline import get_plotlyjs

from .errors import ReportError

__all__ = ["Library", "libraries_for"]

_SPACE = frozenset({"cone", "isosurface", "mesh3d", "scatter3d", "streamtube", "surface", "volume"})
_FLAT = frozenset(
    {
        "bar", "box", "contour", "heatmap", "histogram", "histogram2d", "histogram2dcontour", "image", "pie", "scatter",
        "scatterternary", "violin",
    }
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Library:
    """A bundle of plotly.js.

    Args:
        name: as plotly.js calls the bundle; "full" for the whole library.
        packed: its script, packed by gzip.
    """

    name: str
    packed: bytes

    def render(self) -> str:
        """Return the bundle as an element that the page unpacks; plotly.js's notice stands before it in plain text."""
        script = gzip.decompress(self.packed).decode("utf-8")
        notice = re.match(r"/\*\*.*?\*/", script, re.DOTALL)
        if notice is None or "--" in notice[0]:
            raise ReportError(f"plotly.js, bundle {self.name}: expected its notice first, found {script[:60]!r}")
        data = base64.b64encode(self.packed).decode("ascii")
        return (
            f'<!--\n{notice[0]}\n-->\n<script type="text/plain" class="library" data-name="{self.name}">{data}</script>'
        )


def libraries_for(types: Collection[str]) -> list[Library]:
    """Return the bundles that draw traces of these types: none for none, the whole library for what no bundle draws."""
    wanted = set(types)
    if not wanted:
        return []
    if not wanted <= _SPACE | _FLAT:
        return [Library(name="full", packed=gzip.compress(get_plotlyjs().encode("utf-8"), mtime=0))]
    if wanted & _SPACE and wanted <= _SPACE | {"scatter"}:
        return [_bundle("gl3d")]
    return [_bundle("cartesian"), *([_bundle("gl3d")] if wanted & _SPACE else [])]


def _bundle(name: str) -> Library:
    file = files(__package__) / "plotly_js" / f"plotly-{name}.min.js.gz"
    return Library(name=name, packed=file.read_bytes())
