"""The legend of a figure as buttons: they wrap on phones, work by keyboard and print."""

from collections.abc import Iterable, Mapping
from html import escape, unescape
from typing import Any

from .theme import FITS, dark_partner


def legend(traces: Iterable[Mapping[str, Any]]) -> str:
    """Return one button for each legend group among plotly traces, or nothing when none is named."""
    keys: dict[str, str] = {}
    for k, trace in enumerate(traces):
        name = trace.get("name")
        if (
            name
            and trace.get("showlegend") is not False
            and trace.get("type", "scatter") in ("scatter", "scatter3d", "bar")
        ):
            group = str(trace.get("legendgroup") or name)
            if group not in keys:
                keys[group] = _key(group, unescape(str(name)), trace, k)
    if not keys:
        return ""
    return f'<div class="keys" role="group" aria-label="Legend: show or hide">{"".join(keys.values())}</div>'


def _key(group: str, name: str, trace: Mapping[str, Any], index: int) -> str:
    marker, line = trace.get("marker") or {}, trace.get("line") or {}
    bar, mode = trace.get("type") == "bar", str(trace.get("mode") or "lines")
    colour = (marker if bar or mode == "markers" else line).get("color")
    colour = colour if isinstance(colour, str) else FITS[index % len(FITS)]
    if bar or marker.get("symbol") == "square":
        shape = '<rect x="3" y="1" width="18" height="10" rx="1" fill="currentColor"/>'
    elif mode == "markers":
        shape = '<circle cx="12" cy="6" r="3.5" fill="currentColor"/>'
    else:
        dash = str(line.get("dash") or "solid").replace("px", "")
        dashes = f' stroke-dasharray="{escape(dash)}"' if dash[0].isdigit() else ""
        shape = f'<path d="M1 6H23" stroke="currentColor" stroke-width="2.4"{dashes}/>'
    dark = dark_partner(colour)
    return (
        f'<button type="button" class="key" aria-pressed="true" data-group="{escape(group)}">'
        f'<svg width="24" height="12" aria-hidden="true" '
        f'style="--light:{escape(colour)};--dark:{escape(dark)}">'
        f"{shape}</svg>{escape(name)}</button>"
    )
