"""Names that a person probably meant."""

from __future__ import annotations

from collections.abc import Iterable


def nearest(word: str, known: Iterable[str], most: int = 3, cutoff: float = 0.6) -> list[str]:
    """Return at most `most` entries of `known` that resemble `word` (ratio of difflib ≥ `cutoff`) or begin with it."""
    import difflib

    names = sorted(set(known))
    alike = (difflib.get_close_matches(item, names, most, cutoff) for item in (word, word.lower()))
    close = next(filter(None, alike), [])
    close += [name for name in names if word and name.startswith(word.lower()) and name not in close]
    return close[:most]


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return "did you mean 'x'?" for the entries of `known` that resemble `word`, or "" if none does."""
    close = nearest(word, known)
    return f"did you mean {' or '.join(map(repr, close))}?" if close else ""
