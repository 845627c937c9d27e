"""House words of reports, each explained where it first stands in a page's text: pointed at, focused or touched."""

import re
from html import escape

__all__ = ["WORDS", "explained"]

WORDS = {
    "free run": "a simulation from a fitted start that is driven by the recorded commands alone, never corrected",
    "innovation": "what is measured less what was predicted for it from all that was measured before",
    "held out": "kept from the fit, to judge it by",
    "left out": "kept from the fit, to judge it by",
    "NIS": "normalised innovation squared: how large innovations are beside what the filter says of them; 1 is right",
    "noise floor": "the error that the noise of the sensors leaves, with everything else right",
    "nuisance": "a number that is fitted along because it is not known, and that nobody asks for",
    "re-tuned": "with parameters fitted anew, within the deviations that their set states",
    "log odds": "by how much the data favour one answer over another: 5 is 150 to 1",
    "process noise": "random pushes of rotor and water that no model foresees",
    "dead zone": "throttles about zero at which the rotor is not driven",
    "one step ahead": "for the next sample, from all that was measured before it",
}
"""What each says in other words."""
_FORMS = {word: re.compile(rf"(?<![\w-]){word.replace(' ', '[ -]')}s?(?![\w-])") for word in WORDS}


def explained(text: str, told: set[str]) -> str:
    """Return a text as HTML, each word of `WORDS` that is not in `told` explained once; they are added to `told`."""
    found: list[tuple[int, int, str]] = []
    for word, form in _FORMS.items():
        place = None if word in told else form.search(text)
        if place is not None and not any(a < place.end() and place.start() < b for a, b, _ in found):
            found.append((place.start(), place.end(), word))
            told.add(word)
    parts, end = [], 0
    for start, stop, word in sorted(found):
        meaning = escape(WORDS[word])
        shown = escape(text[start:stop])
        parts += [escape(text[end:start]), f'<dfn tabindex="0" data-told="{meaning}">{shown}</dfn>']
        end = stop
    return "".join([*parts, escape(text[end:])])
