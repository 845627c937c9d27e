"""Fits, noise and sets of unmodelled effects for any system behind the protocol `System`."""

import os

# Its matrices are long and thin: several threads spend their time waiting for each other, a thousandfold on a busy
# machine. Processes do better. To be set before NumPy is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
