"""Message definitions: where they come from, their text as rosbag2 stores it, and their type hash.

Common interfaces are those of ROS 2 Jazzy that the rosbags library carries. Other packages are
looked up in the ament index, then in the folder beside this package in a source checkout.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import TypeAlias

from rosbags.interfaces import Nodetype
from rosbags.interfaces.typing import Fielddefs, FieldDesc, Typesdict
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.base import TypesysError
from rosbags.typesys.store import Typestore

from .errors import SchemaError

SEPARATOR = "=" * 80 + "\n"
FieldsOf: TypeAlias = Mapping[str, Fielddefs]
"""Fields of each message type by its full name, as rosbags parses them."""

MAX_SCHEMA_BYTES = 1 << 20
_UNPARSABLE = (TypesysError, UnicodeDecodeError, ValueError, KeyError, TypeError, AttributeError, IndexError,
               AssertionError, RecursionError, ArithmeticError)  # fmt: skip
"""What the parsers of definitions raise on forms that they do not know: annotations, nested modules, expressions."""


def full_name(name: str) -> str:
    """Return "package/msg/Type" for "package/Type" or "package/msg/Type"."""
    parts = name.split("/")
    return f"{parts[0]}/msg/{parts[1]}" if len(parts) == 2 else name


def message_folders(package: str) -> list[Path]:
    """Return the folders that may hold the .msg files of a package: ament index first, then the checkout."""
    prefixes = [p for p in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p]
    folders = [Path(p) / "share" / package / "msg" for p in prefixes]
    return [*folders, Path(__file__).resolve().parents[2] / package / "msg"]


def _text_on_disk(name: str) -> str | None:
    if not re.fullmatch(r"\w+/msg/\w+", name):
        return None
    package, _, message = name.split("/")
    files = [folder / f"{message}.msg" for folder in message_folders(package)]
    return next((f.read_text(encoding="utf-8") for f in files if f.is_file()), None)


class Definitions:
    """The message types that can be written; loads packages when one of their types is first asked for."""

    def __init__(self) -> None:
        self.store: Typestore = get_typestore(Stores.ROS2_JAZZY)
        self._texts: dict[str, str] = {}

    def require(self, name: str) -> None:
        """Make a type and all it is built from known.

        Raises:
            SchemaError: the type is nowhere to be found, or its definition cannot be parsed.
        """
        pending = [name]
        while pending:
            wanted = pending.pop()
            if wanted in self.store.fielddefs:
                continue
            text = _text_on_disk(wanted)
            if text is None:
                where = "ROS 2 Jazzy's common interfaces, the ament index and beside this package"
                raise SchemaError(f"message type {wanted!r} not found; looked in {where}", found=wanted)
            try:
                types = get_types_from_msg(text, wanted)
            except TypesysError as error:
                raise SchemaError(f"message type {wanted!r}: cannot parse its definition: {error}") from error
            self.store.register(types)
            self._texts[wanted] = text
            pending += references(types[wanted][1])

    def fields(self, name: str) -> FieldsOf:
        """Return the fields of every known type, after making sure that `name` is among them."""
        self.require(name)
        return {key: value[1] for key, value in self.store.fielddefs.items()}

    def text(self, name: str) -> str:
        """Return the concatenated `ros2msg` definition: the type's own text, then each dependency once."""
        self.require(name)
        order, pending = [name], [name]
        while pending:
            for used in references(self.store.fielddefs[pending.pop(0)][1]):
                if used not in order:
                    order.append(used)
                    pending.append(used)
        blocks = [self._own_text(name)]
        blocks += [f"MSG: {key.replace('/msg/', '/')}\n{self._own_text(key)}" for key in order[1:]]
        return SEPARATOR.join(blocks)

    def _own_text(self, name: str) -> str:
        text = self._texts.get(name)
        if text is None:
            text = self.store.gendefhash(name, {}, 2)[0]
        return text.rstrip("\n") + "\n"

    def type_hash(self, name: str) -> str:
        """Return the REP 2011 hash of a type, "RIHS01_" and 64 hexadecimal digits."""
        self.require(name)
        return self.store.hash_rihs01(name)


@lru_cache(maxsize=1)
def definitions() -> Definitions:
    """Return the definitions of this process (parsed once)."""
    return Definitions()


def references(fields: Fielddefs) -> list[str]:
    """Return the message types that these fields are made of, in order."""
    names = []
    for _, description in fields:
        inner: FieldDesc = description
        if inner[0] in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            inner = inner[1][0]  # type: ignore[assignment]
        if inner[0] == Nodetype.NAME:
            names.append(str(inner[1]))
    return names


def parse_schema(name: str, encoding: str, data: bytes) -> FieldsOf:
    """Parse a schema out of a file; the file is the authority, not what this machine has installed.

    A schema without text (old recorders) falls back to the definitions known here.

    Raises:
        SchemaError: unknown encoding, unparsable or incomplete definition.
    """
    name = full_name(name)
    if len(data) > MAX_SCHEMA_BYTES:
        raise SchemaError(f"schema {name!r}: {len(data)} bytes, at most {MAX_SCHEMA_BYTES} are read")
    if not data.strip():
        return definitions().fields(name)
    try:
        types = _parse_text(name, encoding, data.decode("utf-8"))
    except SchemaError:
        raise
    except _UNPARSABLE as error:
        why = " ".join(str(error).split())[:200] or type(error).__name__
        raise SchemaError(f"schema {name!r}: cannot parse its {encoding} definition: {why}") from error
    fields = {key: value[1] for key, value in types.items()}
    for key, own in fields.items():
        names = [field for field, _ in own]
        if len(set(names)) < len(names):
            twice = next(field for field in names if names.count(field) > 1)
            raise SchemaError(f"schema {name!r}: {key} has the field {twice!r} twice", expected=name, found=twice)
    missing = {r for own in fields.values() for r in references(own)} - set(fields)
    if name not in fields or missing:
        lacking = ", ".join(sorted(missing)) or name
        raise SchemaError(f"schema {name!r}: its definition lacks {lacking}", expected=name, found=sorted(fields))
    return fields


def _parse_text(name: str, encoding: str, text: str) -> Typesdict:
    if encoding == "ros2msg":
        return get_types_from_msg(text, name)
    if encoding in ("ros2idl", "omgidl"):
        if not text.startswith(SEPARATOR + "IDL: "):
            return get_types_from_idl(text)
        types: Typesdict = {}
        for block in text.split(SEPARATOR)[1:]:
            types.update(get_types_from_idl(block.split("\n", 1)[1]))
        return types
    raise SchemaError(
        f"schema {name!r}: expected encoding ros2msg or ros2idl, found {encoding!r}",
        expected="ros2msg",
        found=encoding,
    )
