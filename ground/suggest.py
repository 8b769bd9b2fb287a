"""What a person probably meant."""

from __future__ import annotations

from collections.abc import Iterable


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return "did you mean 'x'?" for the entries of `known` that resemble `word`, or "" if none does."""
    import difflib

    names = sorted(set(known))
    close = difflib.get_close_matches(word.lower(), names, n=3, cutoff=0.6)
    close += [name for name in names if word and name.startswith(word.lower()) and name not in close]
    if not close:
        return ""
    return f"did you mean {' or '.join(repr(name) for name in close[:3])}?"
