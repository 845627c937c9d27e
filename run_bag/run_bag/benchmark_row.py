"""One line of the benchmark table, as every package's `benchmark.rows` returns them."""

from typing import NamedTuple


class Row(NamedTuple):
    """One comparison: what, ours and the plain way, in `unit`."""

    what: str
    ours: float
    plain: float
    unit: str
