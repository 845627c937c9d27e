"""The one reader of YAML files: sets, maps, plans, settings, whoever wrote them.

YAML 1.2 with its core schema: `017` is seventeen, `1:30`, `yes` and dates are text, `1e-3` is a number, and what is
quoted is text. Nothing but mappings, sequences and scalars is made. What a file could mean twice or grow by is refused
with its line: a key given twice, an alias, a tag, a second document, numbers that are none to a computer, and sizes
beyond the limits.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError
from ruamel.yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
)

from .errors import YamlError

__all__ = ["LIMITS", "YamlLimits", "parse_yaml", "read_yaml", "yaml_mapping"]

_CORE = re.compile(
    r"(?P<null>null|Null|NULL|~|)|(?P<true>true|True|TRUE)|(?P<false>false|False|FALSE)"
    r"|(?P<int>[-+]?[0-9]+)|(?P<oct>0o[0-7]+)|(?P<hex>0x[0-9a-fA-F]+)"
    r"|(?P<float>[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?)"
    r"|(?P<inf>[-+]?\.(?:inf|Inf|INF))|(?P<nan>\.(?:nan|NaN|NAN))"
)
_UNQUOTED = re.compile(r"but got '[^<]|character '[%@`]' that cannot start|mapping values are not allowed")
"""What the parser says of text without quotes that has a sign of YAML's own in it."""
_DIGITS = 400


@dataclass(frozen=True, kw_only=True)
class YamlLimits:
    """How large a file may be: bytes, scalars and collections in all, and how deep they nest."""

    size: int = 4 << 20
    nodes: int = 100_000
    depth: int = 32


LIMITS = YamlLimits()


def read_yaml(path: Path, limits: YamlLimits = LIMITS) -> Any:
    """Return what a YAML file says.

    Raises:
        YamlError: it cannot be read, is no UTF-8, no YAML, or beyond the limits; `position` is the line.
    """
    try:
        with path.open("rb") as file:
            data = file.read(limits.size + 1)
    except OSError as error:
        raise YamlError(str(path), f"expected a YAML file; cannot be read: {error.strerror or error}") from error
    if len(data) > limits.size:
        raise YamlError(str(path), f"expected YAML of at most {limits.size} bytes, found more")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise YamlError(str(path), f"expected UTF-8, found the byte 0x{data[error.start]:02x}", line=line) from error
    return parse_yaml(text, str(path), limits)


def parse_yaml(text: str, origin: str, limits: YamlLimits = LIMITS) -> Any:
    """Return what a YAML text says; `origin` names it in errors.

    Raises:
        YamlError: as `read_yaml`.
    """
    if len(text) > limits.size:
        raise YamlError(origin, f"expected YAML of at most {limits.size} characters, found {len(text)}")
    return _Builder(origin, limits).build(text)


def yaml_mapping(source: Path | str, error: Callable[[str, list[str]], Exception], origin: str = "") -> dict[Any, Any]:
    """Return the mapping at the top of a YAML file (a path) or text (a str, called `origin`).

    `error`: raised as error(origin, [sentence]) where there is none.
    """
    origin = str(source) if isinstance(source, Path) else origin
    try:
        document = read_yaml(source) if isinstance(source, Path) else parse_yaml(source, origin)
    except YamlError as wrong:
        raise error(origin, [wrong.told]) from wrong
    if not isinstance(document, dict):
        kind = "nothing" if document is None else type(document).__name__
        raise error(origin, [f"expected a mapping at the top; found {kind}"])
    return document


class _Builder:
    """Makes values of the parser's events, without recursion."""

    def __init__(self, origin: str, limits: YamlLimits) -> None:
        self.origin, self.limits = origin, limits
        self.line = 1
        self.nodes = 0

    def wrong(self, sentence: str, line: int | None = None) -> YamlError:
        return YamlError(self.origin, sentence, line=self.line if line is None else line)

    def build(self, text: str) -> Any:
        parser = YAML(typ="safe", pure=True)
        parser.version = "1.2"
        try:
            return self.document(iter(parser.parse(text)))
        except YAMLError as error:
            mark = getattr(error, "problem_mark", None)
            why = str(getattr(error, "problem", None) or error)
            told = f"expected YAML; found what is none: {' '.join(why.split())[:200]}"
            if _UNQUOTED.search(told):
                told += "; text with brackets, braces, commas, colons or % goes in quotes: 'U1 [V]'"
            raise self.wrong(told, None if mark is None else mark.line + 1) from error
        except (ValueError, RecursionError, AttributeError, AssertionError, TypeError, IndexError) as error:
            # what the parser itself trips over in broken text: a directive of another version, half an escape
            raise self.wrong(f"expected YAML; found what is none: {' '.join(str(error).split())[:200]}") from error

    def document(self, events: Iterator[Any]) -> Any:
        result: Any = None
        stack: list[Any] = []  # collections under way
        keys: list[Any] = []  # for each of them the key whose value comes next; _NONE: a key comes next
        documents = 0
        for event in events:
            self.line = event.start_mark.line + 1
            if isinstance(event, DocumentStartEvent):
                documents += 1
                if documents > 1:
                    raise self.wrong("expected one document, found a second one")
                continue
            if isinstance(event, AliasEvent):
                raise self.wrong(f"expected the value itself, found the alias *{event.anchor}")
            if isinstance(event, MappingEndEvent | SequenceEndEvent):
                stack.pop()
                keys.pop()
                continue
            if not isinstance(event, ScalarEvent | MappingStartEvent | SequenceStartEvent):
                continue
            value = self.value(event)
            if not stack:
                result = value
            elif isinstance(stack[-1], list):
                stack[-1].append(value)
            elif keys[-1] is _NONE:
                keys[-1] = self.key(event, value, stack[-1])
            else:
                stack[-1][keys[-1]] = value
                keys[-1] = _NONE
            if not isinstance(event, ScalarEvent):
                stack.append(value)
                keys.append(_NONE)
                if len(stack) > self.limits.depth:
                    raise self.wrong(f"expected at most {self.limits.depth} levels, found more")
        return result

    def value(self, event: Any) -> Any:
        self.nodes += 1
        if self.nodes > self.limits.nodes:
            raise self.wrong(f"expected at most {self.limits.nodes} values, found more")
        if event.tag not in (None, "!"):
            raise self.wrong(f"expected no tag, found {str(event.tag)[:80]}")
        if isinstance(event, MappingStartEvent):
            return {}
        if isinstance(event, SequenceStartEvent):
            return []
        return self.scalar(event.value) if event.implicit[0] else event.value

    def key(self, event: Any, value: Any, found: Mapping[Any, Any]) -> Any:
        if not isinstance(event, ScalarEvent):
            raise self.wrong("expected a text or number as a key, found a collection")
        if value in found:
            raise self.wrong(f"expected each key once, found {value!r} again")
        return value

    def scalar(self, text: str) -> Any:
        match = _CORE.fullmatch(text)
        kind = match.lastgroup if match else None
        if kind is None:
            return text
        if kind in ("null", "true", "false"):
            return {"null": None, "true": True, "false": False}[kind]
        if len(text) > _DIGITS:
            raise self.wrong(f"expected a number of at most {_DIGITS} digits, found {len(text)}")
        if kind in ("int", "oct", "hex"):
            number = int(text, {"int": 10, "oct": 8, "hex": 16}[kind])
            if not -(1 << 63) <= number < 1 << 63:
                raise self.wrong(f"expected a whole number below 2^63, found {text[:40]}")
            return number
        if kind == "float":
            real = float(text)
            if not math.isfinite(real):
                raise self.wrong(f"expected a number that a computer has, found {text[:40]}")
            return real
        return math.nan if kind == "nan" else math.copysign(math.inf, -1.0 if text[0] == "-" else 1.0)


_NONE = object()
