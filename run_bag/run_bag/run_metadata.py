"""What was run, as a recording carries it: three places, so that one survives whatever is done to the bag.

The MCAP metadata record `run` is the first; `ros2 bag convert` and re-recording drop it. `custom_data` of metadata.yaml
and a latched topic of one message hold the same text; converting and recording again keep the message.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

from .definitions import definitions
from .errors import SchemaError
from .layout import payload_layout
from .mcap_content import Scan

RUN_RECORD = "run"
TOPIC = "/run_metadata"
TYPE = "std_msgs/msg/String"
TYPES = (TYPE, "std_msgs/String")
MAX_DEPTH = 64
MAX_BYTES = 16 << 20


def run_text(metadata: Mapping[str, Any]) -> str:
    """Return metadata as the text that all places hold."""
    return json.dumps(metadata, allow_nan=False, ensure_ascii=False)


def found_metadata(
    scans: Iterable[Scan], description: Mapping[str, Any], bag_record: str
) -> tuple[dict[str, Any], list[str]]:
    """Return what was run, from wherever it was left, and warnings; the record beats the message, which is older."""
    warnings: list[str] = []
    result: dict[str, Any] = {}
    custom = description.get("custom_data")
    places = [("metadata.yaml", custom.get(RUN_RECORD))] if isinstance(custom, Mapping) else []
    scans = list(scans)
    for one in scans:
        places += [(f"{one.path.name}, {TOPIC}", _string(payload)) for payload in one.told]
    places += [(one.path.name, one.metadata.get(RUN_RECORD, {}).get("json")) for one in scans]
    for where, text in places:
        if text is None:
            continue
        try:
            loaded = _loaded(text)
        except (ValueError, RecursionError) as error:
            warnings.append(f"{where}: the run's metadata is no JSON: {' '.join(str(error).split())[:200]}")
            continue
        result.update(loaded if isinstance(loaded, dict) else {RUN_RECORD: loaded})
    for one in scans:
        for name, content in one.metadata.items():
            if name not in (RUN_RECORD, bag_record):
                result.setdefault("mcap", {})[name] = content
    return result, warnings


def _loaded(text: Any) -> Any:
    if not isinstance(text, str):
        raise ValueError(f"expected text, found {type(text).__name__}")
    if len(text) > MAX_BYTES:
        raise ValueError(f"expected at most {MAX_BYTES} characters, found {len(text)}")
    loaded = json.loads(text, parse_constant=str)
    level, depth = [loaded], 0
    while level:
        depth += 1
        if depth > MAX_DEPTH:
            raise ValueError(f"expected at most {MAX_DEPTH} levels, found more")
        inner: list[Any] = []
        for value in level:
            if isinstance(value, dict):
                inner += [*value, *value.values()]
            elif isinstance(value, list):
                inner += value
            elif isinstance(value, str):
                value.encode("utf-8")  # half of a surrogate pair is a ValueError
            elif isinstance(value, int | float) and not -1e300 < value < 1e300:
                raise ValueError("expected numbers that a computer has, found a larger one")
        level = inner
    return loaded


def _string(payload: bytes) -> str | None:
    """Return the text of a std_msgs/String, None where the message is none."""
    try:
        return payload_layout(definitions().fields(TYPE), TYPE, payload).text("data")
    except SchemaError:
        return None
