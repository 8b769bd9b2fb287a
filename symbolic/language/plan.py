"""Torque texts that are evaluated again and again, along other motions, with the same numbers in them.

All texts together are one list of steps, in which what several have in common is computed once. The values are those
of `to_numpy`, bit for bit; but what is not finite is handed on, and a number stays a number.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

import numpy as np

from exoid.symbolic.language.lower import ARITHMETIC, NUMPY, known, power, with_memory
from exoid.symbolic.language.operators import MEMORY
from exoid.symbolic.language.tree import CONSTANTS, Node
from exoid.symbolic.language.walk import Spelling, lower


class TextPlan:
    """Steps that grow with each text that is added; `names` are the words whose values have to be given."""

    def __init__(self) -> None:
        self.names: dict[str, int] = {}
        self._signs: dict[str, int] = {}
        self._places: dict[Any, int] = {}
        self._begin: list[Any] = []  # numbers where they are known, None elsewhere
        self._steps: list[tuple[int, Callable[..., Any], tuple[int, ...]]] = []

    def add(self, node: Node, numbers: Mapping[str, float], velocities: Iterable[str]) -> int:
        """Add a text with these `numbers` in it and return its place among the values.

        `velocities` are the words whose sign is a signal of its own.
        """
        fixed = {**CONSTANTS, **numbers}
        table = Spelling(
            number=self._number,
            name=lambda name: self._number(fixed[name]) if name in fixed else self._given(self.names, name),
            negative=lambda a: self._step("-", np.negative, a),
            power=lambda base, exponent: self._step(exponent, partial(power, exponent=exponent, root=np.sqrt), base),
            binary={word: partial(self._step, word, function) for word, function in ARITHMETIC.items()},
            functions={word: partial(self._step, word, function) for word, function in NUMPY.items()}
            | {word: partial(self._with_memory, word) for word in MEMORY},
            signs={word: self._given(self._signs, word) for word in velocities},
        )
        return int(lower(node, table))

    def values(self, words: Mapping[str, Any], signs: Mapping[str, Any]) -> list[Any]:
        """Return the values of all steps, signals (N,) or numbers, for signals and signs by their words."""
        found = list(self._begin)
        for name, place in self.names.items():
            found[place] = known(name, words)
        for name, place in self._signs.items():
            found[place] = signs[name]
        with np.errstate(all="ignore"):
            for place, function, arguments in self._steps:
                found[place] = function(*[found[k] for k in arguments])
        return found

    def _new(self, value: Any = None) -> int:
        self._begin.append(value)
        return len(self._begin) - 1

    def _number(self, value: float) -> int:
        key = "number", float(value)
        if key not in self._places:
            self._places[key] = self._new(np.float64(value))
        return self._places[key]

    def _given(self, among: dict[str, int], name: str) -> int:
        if name not in among:
            among[name] = self._new()
        return among[name]

    def _step(self, what: Any, function: Callable[..., Any], *arguments: int) -> int:
        key = what, arguments
        if key not in self._places:
            self._places[key] = place = self._new()
            self._steps.append((place, function, arguments))
        return self._places[key]

    def _with_memory(self, word: str, *arguments: int) -> int:
        return self._step(word, partial(with_memory, word), self._given(self.names, "t"), *arguments)
