"""Effects as layers that are added, switched and removed, and the steps on the way, to each of which one can return."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from exoid.ground.errors import EffectError
from exoid.ground.plain import AsJson


@dataclass(frozen=True)
class Layer(AsJson):
    """An effect that was added, by its full name ("stribeck:knee"), and whether it is switched on."""

    name: str
    on: bool = True


@dataclass(frozen=True)
class Change(AsJson):
    """One step of the way: what was done, in words, and the layers after it."""

    label: str
    layers: tuple[Layer, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Full names of the effects that are switched on, in the order in which they were added."""
        return tuple(layer.name for layer in self.layers if layer.on)


@dataclass(frozen=True)
class History(AsJson):
    """The steps so far and the place `at` which one stands; a new step forgets those that were undone."""

    steps: tuple[Change, ...] = (Change("base"),)
    at: int = 0

    @property
    def now(self) -> Change:
        """The step one stands at."""
        return self.steps[self.at]

    def add(self, *names: str) -> History:
        """Return the history with these effects added, each in a step of its own; EffectError where one is there."""
        out = self
        for name in names:
            if name in [layer.name for layer in out.now.layers]:
                raise EffectError(f"{name} was added already", where=name, remedy="switch it on, or remove it first")
            out = out._then(f"+ {name}", (*out.now.layers, Layer(name)))
        return out

    def switch(self, name: str) -> History:
        """Return the history with the effect switched off, or on again; EffectError where there is none."""
        layer = self._find(name)
        layers = tuple(replace(item, on=not item.on) if item is layer else item for item in self.now.layers)
        return self._then(f"{name} {'off' if layer.on else 'on'}", layers)

    def remove(self, name: str) -> History:
        """Return the history without the effect; EffectError where there is none."""
        layer = self._find(name)
        return self._then(f"− {name}", tuple(item for item in self.now.layers if item is not layer))

    def go(self, place: int) -> History:
        """Return the history at another of its steps; EffectError where there is no such step."""
        if not 0 <= place < len(self.steps):
            raise EffectError(f"there is no step {place}", where="history", remedy=f"0 to {len(self.steps) - 1}")
        return replace(self, at=place)

    def undo(self) -> History:
        """Return the history one step earlier; itself at the beginning."""
        return replace(self, at=max(0, self.at - 1))

    def redo(self) -> History:
        """Return the history one step later; itself at the end."""
        return replace(self, at=min(len(self.steps) - 1, self.at + 1))

    @classmethod
    def from_json(cls, value: Any) -> History:
        """Return the history that `to_json` wrote; EffectError where it is none."""
        try:
            steps = tuple(
                Change(str(s["label"]), tuple(Layer(str(e["name"]), bool(e["on"])) for e in s["layers"]))
                for s in value["steps"]
            )
            return cls(steps).go(int(value["at"]))
        except (KeyError, TypeError, ValueError) as error:
            raise EffectError(
                "this is no history of a session", where="history", remedy="open a folder that exoid saved"
            ) from error

    def _find(self, name: str) -> Layer:
        for layer in self.now.layers:
            if layer.name == name:
                return layer
        raise EffectError(f"{name} is not among the layers", where=name, remedy="add it first")

    def _then(self, label: str, layers: tuple[Layer, ...]) -> History:
        return History((*self.steps[: self.at + 1], Change(label, layers)), self.at + 1)
