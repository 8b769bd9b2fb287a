"""Results in the types that JSON has: the one place that turns ours into dicts, lists, texts, numbers and None."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, Protocol, TypeVar


class HasName(Protocol):
    """Anything with a name."""

    @property
    def name(self) -> str: ...  # noqa: D102


Named = TypeVar("Named", bound=HasName)

SPOILT = (LookupError, TypeError, ValueError, ArithmeticError, AttributeError, RecursionError)
"""What JSON that is not what we wrote raises when it is read and gone through."""


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


def by_name(several: Iterable[Named]) -> dict[str, Named]:
    """Return {name: one of them}."""
    return {item.name: item for item in several}


class AsJson:
    """A dataclass with a JSON form: all its fields, unless its `_json` says what else."""

    def to_json(self) -> dict[str, Any]:
        """Return the result in plain types."""
        return plain_dict(self._json())

    def _json(self) -> dict[str, Any]:
        return {f.name: getattr(self, f.name) for f in fields(self)}  # type: ignore[arg-type]
