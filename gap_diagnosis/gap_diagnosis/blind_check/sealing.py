"""Sealed keys: what is hidden in a case, with a nonce, and the hash that is published before it may be opened."""

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

__all__ = ["BrokenSealError", "Seal", "hash_of_all", "seal", "unseal"]


class BrokenSealError(Exception):
    """A sealed key does not have the published hash.

    Attributes:
        case, published, found: name of the case and both hashes.
    """

    def __init__(self, case: str, published: str | None, found: str) -> None:
        self.case, self.published, self.found = case, published, found
        said = "no hash was published for it" if published is None else f"the published hash is {published}"
        super().__init__(f"the seal of {case} is broken: {said}, its content has {found}; it is not scored")


@dataclass(frozen=True)
class Seal:
    """A sealed key as bytes: JSON (with the nonce), the clean channels, and the hash over both."""

    key: bytes
    channels: bytes

    @property
    def hash(self) -> str:
        """SHA-256 over length and content of both parts."""
        digest = hashlib.sha256(f"{len(self.key)} {len(self.channels)}\n".encode())
        digest.update(self.key)
        digest.update(self.channels)
        return digest.hexdigest()


def seal(key: Mapping[str, Any], channels: bytes, nonce: str) -> Seal:
    """Return the seal of a key; the nonce, from a source that nobody can guess, keeps it from being tried out."""
    return Seal(json.dumps({**key, "nonce": nonce}, sort_keys=True, allow_nan=False).encode(), channels)


def unseal(case: str, sealed: Seal, published: str | None) -> dict[str, Any]:
    """Return the key of a case.

    Raises:
        BrokenSealError: the content does not have the published hash, or none was published.
    """
    if sealed.hash != published:
        raise BrokenSealError(case, published, sealed.hash)
    content: dict[str, Any] = json.loads(sealed.key)
    return content


def hash_of_all(hashes: Iterable[str]) -> str:
    """Return the hash of the hashes of all seals of a check, in the order of its cases."""
    return hashlib.sha256("".join(hashes).encode()).hexdigest()
