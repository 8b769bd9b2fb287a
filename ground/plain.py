"""Results in the types that JSON has: the one place that turns ours into dicts, lists, texts, numbers and None."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from operator import attrgetter
from pathlib import Path
from typing import Any, ClassVar

from exoid.ground.calling import Telling


def plain(value: Any) -> Any:
    """Return `value` in types JSON has: arrays become lists, numbers that are not finite become None.

    A result says by `to_json` what it is. Raises TypeError for anything else that JSON cannot hold.
    """
    if isinstance(value, bool) or value is None or isinstance(value, (str, int)):
        return value
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return plain_dict(value)
    if isinstance(value, (list, tuple, set, frozenset)):
        return [plain(item) for item in value]
    if isinstance(value, Path):
        return str(value)
    for convert in ("tolist", "to_json"):  # NumPy arrays and numbers; our own results
        if hasattr(value, convert):
            return plain(getattr(value, convert)())
    raise TypeError(f"{type(value).__name__} has no JSON form")


def plain_dict(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a dict of `values` in types JSON has."""
    return {str(key): plain(value) for key, value in values.items()}


def picked(value: Any, words: str) -> dict[str, Any]:
    """Return what `words` name of an object: "*" for all fields of a dataclass, a name for a field or property,
    "key=name" (or "key=name.of.its") where the key is another, "name{}" where a sequence becomes {name: one of them}.
    """
    out: dict[str, Any] = {}
    for word in words.split():
        if word == "*":
            out |= {f.name: getattr(value, f.name) for f in fields(value)}
        else:
            key, _, place = word.removesuffix("{}").partition("=")
            found = attrgetter(place or key)(value)
            out[key] = {one.name: one for one in found} if word.endswith("{}") else found
    return out


class AsJson(Telling):
    """A dataclass whose JSON is told by `JSON`, in the words that `picked` takes."""

    JSON: ClassVar[str] = "*"

    def to_json(self) -> dict[str, Any]:
        """Return what `JSON` names in plain types."""
        return plain_dict(picked(self, self.JSON))
