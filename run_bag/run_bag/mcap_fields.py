"""The parts of an MCAP record: strings, maps, compressed bytes. What does not fit is a ValueError."""

from __future__ import annotations

import lz4.frame
import zstandard


def prefixed(data: bytes) -> tuple[bytes, bytes]:
    """Return the bytes behind a length word, and the rest."""
    length = int.from_bytes(data[:4], "little")
    if len(data) < 4 + length or len(data) < 4:
        raise ValueError(f"a length of {length} beyond the record")
    return data[4 : 4 + length], data[4 + length :]


def string(data: bytes) -> tuple[str, bytes]:
    """Return a string, and the rest."""
    text, rest = prefixed(data)
    return text.decode("utf-8"), rest


def mapping(data: bytes) -> dict[str, str]:
    """Return a map of strings."""
    rest, _ = prefixed(data)
    position, texts = 0, []
    while position < len(rest):
        end = position + 4 + int.from_bytes(rest[position : position + 4], "little")
        if position + 4 > len(rest) or end > len(rest):
            raise ValueError(f"a length of {end - position - 4} beyond the record")
        texts.append(rest[position + 4 : end].decode("utf-8"))
        position = end
    if len(texts) % 2:
        raise ValueError("a key without a value")
    return dict(zip(texts[::2], texts[1::2], strict=True))


def decompress(compression: str, data: bytes, size: int) -> bytes:
    """Decompress at most `size` bytes (+ 1, to notice more); of cut data what can be had."""
    if compression == "":
        return data[: size + 1]
    if compression == "zstd":
        with zstandard.ZstdDecompressor().stream_reader(data) as reader:
            return reader.read(size + 1)
    if compression == "lz4":
        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1))
    raise ValueError(f"compression {compression!r}; known are zstd, lz4 and none")
