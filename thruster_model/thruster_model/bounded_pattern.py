"""Regular expressions of strangers, for names of at most 31 characters: none that a matcher may try for minutes.

The matcher of `re` tries, at worst, every way in which a pattern can be laid over a text. Ways are counted from above:

    one character, class, bracket, anchor     1
    a sequence                                the product of its parts'
    a|b                                       the sum of both
    x{m,n}                                    p^m + ... + p^min(n, 31), with p the ways of x

so `.*` has 32, `(.*)*` more than 10^46. Source: the backtracking of CPython's `re`, without its short cuts.
"""

import importlib
import re
import sys
import warnings
from collections.abc import Iterable
from typing import Any

_SRE: Any = importlib.import_module("re._parser" if sys.version_info >= (3, 11) else "sre_parse")

__all__ = ["LONGEST_FILE", "LONGEST_NAME", "LONGEST_PATTERN", "MOST_WAYS", "bounded", "ways"]

LONGEST_NAME = 31
"""Characters of a sheet's name, as spreadsheets allow them."""
LONGEST_FILE = 100
"""Characters of the name of a file in which a pattern may be looked for: seconds at worst."""
LONGEST_PATTERN = 200
MOST_WAYS = 2**21
"""Four times `.*` and one `?`: a hundredth of a second at worst."""


def bounded(text: str) -> re.Pattern[str]:
    """Return the compiled pattern.

    Raises:
        ValueError: it is no regular expression, is ambiguous, or may be laid over a name in too many ways.
    """
    if len(text) > LONGEST_PATTERN:
        raise ValueError(f"longer than {LONGEST_PATTERN} characters")
    with warnings.catch_warnings():
        warnings.simplefilter("error", FutureWarning)
        try:
            pattern = re.compile(text)
        except (re.error, FutureWarning, OverflowError, RecursionError) as error:
            raise ValueError(str(error)) from error
    if ways(text) > MOST_WAYS:
        raise ValueError(
            "it repeats so much that a name may take minutes; four repetitions at most, none inside another"
        )
    return pattern


def ways(text: str) -> int:
    """Return in how many ways a valid pattern may be laid over a name, counted up to just beyond `MOST_WAYS`."""
    return _of_sequence(_SRE.parse(text))


def _of_sequence(items: Iterable[Any]) -> int:
    product = 1
    for operator, value in items:
        product = min(product * _of(str(operator), value), MOST_WAYS + 1)
    return product


def _of(operator: str, value: Any) -> int:
    if operator in ("MAX_REPEAT", "MIN_REPEAT", "POSSESSIVE_REPEAT"):
        least, most, repeated = value
        p, times = _of_sequence(repeated), range(min(least, LONGEST_NAME), min(most, LONGEST_NAME) + 1)
        return min(sum(p**k for k in times), MOST_WAYS + 1)
    if operator == "BRANCH":
        return sum(_of_sequence(each) for each in value[1])
    if operator == "SUBPATTERN":
        return _of_sequence(value[-1])
    if operator == "ATOMIC_GROUP":
        return _of_sequence(value)
    if operator in ("ASSERT", "ASSERT_NOT"):
        return _of_sequence(value[1])
    if operator == "GROUPREF_EXISTS":
        _, there, absent = value
        return _of_sequence(there) + _of_sequence(absent or ())
    return 1
