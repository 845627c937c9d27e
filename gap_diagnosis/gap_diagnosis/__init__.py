"""Why a simulated thruster and a recorded one disagree: where, by which unmodelled effect, and how far it shrinks."""

import importlib
import os
from typing import Any

__all__ = ["Diagnosis", "diagnose", "diagnose_paths", "read_recordings"]

# Its matrices are long and thin: several threads spend their time waiting for each other, a thousandfold on a busy
# machine. Processes do better. To be set before NumPy is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

_PLACES = {
    "Diagnosis": "diagnosis",
    "diagnose": "diagnosis",
    "diagnose_paths": "diagnose_io",
    "read_recordings": "recording_io",
}


def __getattr__(name: str) -> Any:
    """Load a public name when it is asked for: kernels take their time."""
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_PLACES[name]}"), name)
