"""Numbers as a reader wants them: aligned decimals, a real minus sign, a dash for what is missing."""

import math
from collections.abc import Sequence
from numbers import Integral, Real

MISSING = "–"
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def is_number(value: object) -> bool:
    """Tell numbers (numpy's too) from text; a truth value is text."""
    return isinstance(value, Real) and not isinstance(value, bool) and type(value).__name__ != "bool"


def column_decimals(values: Sequence[object], digits: int) -> int | None:
    """Choose one number of decimals for a column, or None where its values span more than three decades.

    Args:
        values: the cells of the column; only finite non-zero numbers count.
        digits: significant digits wanted of the largest value.
    """
    sizes = [abs(float(v)) for v in values if isinstance(v, Real) and is_number(v)]
    sizes = [s for s in sizes if math.isfinite(s) and s > 0.0]
    if not sizes:
        return 0
    if max(sizes) > 1e3 * min(sizes) or max(sizes) >= 1e7 or max(sizes) < 1e-4:
        return None
    return max(0, digits - 1 - math.floor(math.log10(max(sizes))))


def format_number(value: object, digits: int = 4, decimals: int | None = None) -> str:
    """Format one number: fixed `decimals` if given, else `digits` significant digits.

    Returns:
        text with U+2212 as minus and ×10ⁿ for very large or small values; a dash for None and NaN.
    """
    if value is None:
        return MISSING
    if not isinstance(value, Real):
        return str(value)
    number = float(value)
    if math.isnan(number):
        return MISSING
    if math.isinf(number):
        return "∞" if number > 0 else "−∞"
    if isinstance(value, Integral):
        return f"{int(value)}".replace("-", "−")
    if decimals is not None:
        return f"{number:.{decimals}f}".replace("-", "−")
    if number != 0.0 and not 1e-4 <= abs(number) < 1e7:
        mantissa, exponent = f"{number:.{digits - 1}e}".split("e")
        return f"{mantissa}×10{str(int(exponent)).translate(_SUPERSCRIPT)}".replace("-", "−")
    whole = 1 if number == 0.0 else math.floor(math.log10(abs(number))) + 1
    return f"{number:.{max(0, digits - whole)}f}".replace("-", "−")
