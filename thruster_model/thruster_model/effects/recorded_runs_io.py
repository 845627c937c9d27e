"""Effects of the log on a finished run: a copy with the stamps and repeated samples that they would have left.

They act on what is recorded, so a graph runs without them: its nodes join messages by their stamps.
"""

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from run_bag.restamping import restamp
from thruster_model.effects.active import ActiveEffects

__all__ = ["with_log_effects"]

Ticks = NDArray[np.int64]
_SIGNALS = {"throttle": "throttle", "throttle_sent": "throttle", "state": "speed", "flow": "ambient", "load": "thrust"}
_TOPIC = re.compile(r"(?:.*/)?thruster_\d+/(" + "|".join(_SIGNALS) + ")")


def with_log_effects(path: Path, target: Path, effects: ActiveEffects, seed: int) -> Path:
    """Return the run as it is logged: a copy at `target`, or the run itself where no effect is one of the log.

    Args:
        path: the run.
        target: of the copy; must not exist.
        effects: those of the log act, others are passed over.
        seed: of effects that scatter.

    Raises:
        RunError: the run cannot be read, or the copy not be written.
    """
    log = effects.of_the_log()
    if not log.sizes:
        return path
    about = {"log_effects": {name: dict(sizes) for name, sizes in log.sizes.items()}, "log_effects_seed": seed}
    return restamp(path, target, lambda stamps: _logged(stamps, log, seed), about).directory


def _logged(stamps: Mapping[str, Ticks], effects: ActiveEffects, seed: int) -> dict[str, tuple[Ticks, Ticks]]:
    """Return stamps [ns] and contents of the topics of thrusters; a clock that drifts is right at the first stamp."""
    signals = {topic: found[1] for topic in sorted(stamps) if (found := _TOPIC.fullmatch(topic))}
    begin = min((int(np.min(stamps[topic])) for topic in signals), default=0)
    logged = {}
    for k, (topic, field) in enumerate(signals.items()):
        time = np.asarray(1e-9 * (stamps[topic] - begin), dtype=np.float64)
        messages = np.arange(float(time.size))
        at, sources = effects.log(_SIGNALS[field], time, messages, np.random.default_rng((seed, k)))
        logged[topic] = (begin + np.round(1e9 * at).astype(np.int64), sources.astype(np.int64))
    return logged
