"""One opened case against its diagnosis: what was named, rightly or wrongly.

A key is what was sealed: kind, effects and outside (sizes by id and parameter), excitation, ... A diagnosis is the
content of diagnosis.json. A case without effect is right when nothing is claimed.
"""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from gap_diagnosis.blind_check.catalogue import EFFECTS, OUTSIDE, Kind

__all__ = [
    "CONFIDENT",
    "FOREIGN",
    "accepts",
    "block_right",
    "claims",
    "is_named",
    "named_claim",
    "quiet",
    "right",
    "silent",
    "size_of",
    "size_parameter",
    "top_block",
    "true_label",
    "true_names",
    "wrong_names",
]

Key = Mapping[str, Any]
Diagnosis = Mapping[str, Any]

CONFIDENT = 0.8
"""Probability from which a wrong name counts as confidently wrong."""
FOREIGN = ("outside", "left_out")
"""Kinds of case whose effect the diagnosis cannot know."""
_CLAIMED = 0.5
_ABSTAINS = ("cannot_tell", "not_enough_data")
_QUIET = ("no_gap", "parameters")
_WORDS = {
    "throttle": ("throttle", "command", "commanded"),
    "speed": ("speed", "state", "n"),
    "flow": ("flow", "ambient", "axial"),
    "load": ("load", "thrust", "torque", "wrench"),
}
_TWIN_CHANNEL = {"command_delay": "throttle", "flow_delay": "flow"}


def true_names(key: Key) -> list[str]:
    """Return the identifiers of what is hidden."""
    return [*key["effects"], *key["outside"]]


def claims(diagnosis: Diagnosis) -> list[Mapping[str, Any]]:
    """Return the effects that a diagnosis claims."""
    return list(diagnosis.get("effects") or []) if diagnosis.get("verdict") == "effect" else []


def silent(diagnosis: Diagnosis) -> bool:
    """Return whether the diagnosis says that the data do not suffice."""
    return diagnosis.get("verdict") in _ABSTAINS


def quiet(diagnosis: Diagnosis) -> bool:
    """Return whether the diagnosis says that no effect is needed."""
    return diagnosis.get("verdict") in _QUIET


def size_of(key: Key, name: str) -> float:
    """Return the true size of an effect of the case."""
    return float({**key["effects"], **key["outside"]}[name][size_parameter(key, name)])


def size_parameter(key: Key, name: str) -> str:
    """Return the name of the parameter that is the size of an effect of the case; of late stamps, their channel."""
    return _channel_of_key(key, name) or "" if name == "log_alignment" else _kind(name).size.name


def _kind(name: str) -> Kind:
    return EFFECTS[name] if name in EFFECTS else OUTSIDE[name]


def _channel_of_key(key: Key, name: str) -> str | None:
    return str(next(iter(key["effects"][name]))) if name == "log_alignment" else _TWIN_CHANNEL.get(name)


def _channels_of_claim(claim: Mapping[str, Any]) -> set[str]:
    """Return the channels that a claimed shift of stamps may concern; all where it does not say."""
    found = {c for c, words in _WORDS.items() if set(re.split(r"\W+", str(claim.get("channel") or ""))) & set(words)}
    if not found:
        sizes = {name: abs(entry["value"]) for name, entry in (claim.get("parameters") or {}).items()}
        found = {name for name, size in sizes.items() if name in _WORDS and size == max(sizes.values())}
    return found or set(_WORDS)


def _is(claim: Mapping[str, Any], key: Key, name: str) -> bool:
    """Return whether a claim's own identifier is that effect, or its exact twin, on the same channel."""
    if claim["id"] == "log_alignment" and name in ("log_alignment", *_TWIN_CHANNEL):
        return _channel_of_key(key, name) in _channels_of_claim(claim)
    return claim["id"] == name or claim["id"] in _twins(key, name)


def _labelled(label: str) -> dict[str, str]:
    """Return effect and channel of a candidate as a claim has them: "log_alignment:speed" is that of one channel."""
    name, _, channel = label.partition(":")
    return {"id": name, "channel": channel}


def _twins(key: Key, name: str) -> tuple[str, ...]:
    """Return the exact twins of an effect of the case: of late stamps, that of their channel alone."""
    twins = _kind(name).twins
    if name != "log_alignment":
        return twins
    return tuple(twin for twin in twins if _TWIN_CHANNEL[twin] == _channel_of_key(key, name))


def named_claim(key: Key, name: str, diagnosis: Diagnosis) -> Mapping[str, Any] | None:
    """Return the claim that names an effect of the case, alone or in its group; None: it is not named."""
    for claim in claims(diagnosis):
        if _is(claim, key, name):
            return claim
    for claim in claims(diagnosis):
        if any(_is(_labelled(member), key, name) for member in claim.get("indistinguishable_from") or ()):
            return claim
    return None


def is_named(key: Key, name: str, diagnosis: Diagnosis) -> bool:
    """Return whether an effect of the case is named, alone or in a group."""
    return named_claim(key, name, diagnosis) is not None


def wrong_names(key: Key, diagnosis: Diagnosis, least: float = CONFIDENT) -> list[str]:
    """Return the effects claimed, as a group, with at least that probability, of which none is in the case."""
    rightly = [named_claim(key, name, diagnosis) for name in key["effects"]]
    return [
        str(claim["id"])
        for claim in claims(diagnosis)
        if _probability(claim) >= least and not any(claim is right_one for right_one in rightly)
    ]


def _probability(claim: Mapping[str, Any]) -> float:
    """Return the probability with which a claim's group is said to be at work: what a reader is told."""
    return float(claim.get("group_probability") or claim.get("probability") or 0.0)


def top_block(diagnosis: Diagnosis) -> str | None:
    """Return the block with the largest share, as its first word."""
    where: Sequence[Mapping[str, Any]] = diagnosis.get("where") or ()
    if not where:
        return None
    name = str(max(where, key=lambda entry: float(entry.get("share") or 0.0))["block"])
    return re.split(r"[^a-z]", name.lower())[0]


def block_right(key: Key, diagnosis: Diagnosis) -> bool:
    """Return whether the first block is one in which an effect of the case, or its exact twin, enters."""
    right_ones = set()
    for name in true_names(key):
        right_ones |= {_kind(name).block, *(EFFECTS[twin].block for twin in _twins(key, name))}
    return top_block(diagnosis) in right_ones


def right(key: Key, diagnosis: Diagnosis) -> bool:
    """Return whether the verdict is right.

    Effects of the library: all are named, and nothing else with a probability of a half or more. None: no_gap or
    parameters. An effect that is not in the diagnosis' library: unknown, or the right block without a confidently
    wrong name; `parameters` where it equals a re-tuning. Poor excitation: to say that the data do not suffice is right
    as well.
    """
    verdict = diagnosis.get("verdict")
    names = true_names(key)
    if key["excitation"] not in ("rich", "closed_loop") and silent(diagnosis):
        return True
    if key["kind"] in FOREIGN:
        if verdict == "parameters" and not any(_kind(name).structural for name in names):
            return True
        told = verdict in ("effect", "parameters")
        return verdict == "unknown" or (told and not wrong_names(key, diagnosis) and block_right(key, diagnosis))
    if not names:
        return quiet(diagnosis)
    return all(is_named(key, name, diagnosis) for name in names) and not wrong_names(key, diagnosis, _CLAIMED)


def true_label(key: Key) -> str:
    """Return the truth of a case with one effect at most as a candidate: a name with its channel, none or unknown."""
    if key["kind"] in FOREIGN:
        return "unknown"
    names = list(key["effects"])
    if not names:
        return "none"
    return f"{names[0]}:{_channel_of_key(key, names[0])}" if names[0] == "log_alignment" else names[0]


def accepts(key: Key, label: str) -> bool:
    """Return whether a candidate, "none" or "unknown" is the truth of a case with one effect at most, or its twin."""
    if label in ("none", "unknown"):
        retuned = key["kind"] in FOREIGN and not any(_kind(name).structural for name in true_names(key))
        return label == true_label(key) or (label == "none" and retuned)
    return key["kind"] not in FOREIGN and any(_is(_labelled(label), key, name) for name in key["effects"])
