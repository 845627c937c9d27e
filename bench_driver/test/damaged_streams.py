"""Damaged copies of byte streams, many at a time."""

from collections.abc import Iterator

import numpy as np

__all__ = ["mutated"]

_BATCH = 4096


def mutated(streams: list[bytes], count: int, seed: int) -> Iterator[tuple[int, bytes]]:
    """Yield `count` damaged streams with the index of their original.

    Each is damaged in one to four places: a byte replaced, a bit turned, a run of up to 16 bytes dropped, doubled or
    replaced.
    """
    chance = np.random.default_rng(seed)
    while count > 0:
        size = min(count, _BATCH)
        count -= size
        originals = chance.integers(len(streams), size=size)
        places = chance.integers(1, 5, size=size)
        kinds = chance.integers(5, size=(size, 4))
        positions = chance.random((size, 4))
        lengths = chance.integers(1, 17, size=(size, 4))
        values = chance.integers(256, size=(size, 4, 16), dtype=np.uint8)
        for row in range(size):
            data = bytearray(streams[originals[row]])
            for place in range(places[row]):
                at = int(positions[row, place] * len(data))
                length, new = int(lengths[row, place]), values[row, place].tobytes()
                kind = kinds[row, place]
                if not data:
                    break
                if kind == 0:
                    data[at] = new[0]
                elif kind == 1:
                    data[at] ^= 1 << (new[0] & 7)
                elif kind == 2:
                    del data[at : at + length]
                elif kind == 3:
                    data[at:at] = data[at : at + length]
                else:
                    data[at : at + length] = new[:length]
            yield int(originals[row]), bytes(data)
