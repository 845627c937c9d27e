"""Why a simulated thruster and a recorded one disagree: where, by which unmodelled effect, and how far it shrinks."""

import os

# Its matrices are long and thin: several threads spend their time waiting for each other, a thousandfold on a busy
# machine. Processes do better. To be set before NumPy is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
