"""Changes that were named go on acting: what they make of later windows, and these as if nothing had changed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from exoid.apps.watch.course import Onset
from exoid.apps.watch.window import Window
from exoid.diagnosis.against.result import ChangeFound
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.symbolic.motion import Float


@dataclass(eq=False)
class Applied:
    """Changes that were `found` at once, `since` when; `age` blocks ago, and whether they were `refined` since."""

    found: tuple[ChangeFound, ...]
    since: Onset
    age: int = 0
    refined: bool = False

    @property
    def labels(self) -> set[str]:
        """The names of what changed."""
        return {item.name for item in self.found}

    @property
    def lasting(self) -> Applied | None:
        """That part of it which no number of the model takes up, None where there is none."""
        found = tuple(item for item in self.found if item.kind not in ("number", "load"))
        return replace(self, found=found) if found else None


def as_usual(one: Window, now: FittedModel, applied: Iterable[Applied]) -> Window:
    """Return a window with the torque (J, K) that it would have without what was `applied`."""
    torque = one.torque
    for change in applied:
        if one.t[-1] <= change.since.t:
            continue
        base = now.block_of(one).columns
        for found in change.found:
            if found.acting is not None:
                torque = torque - (one.t > change.since.t) * found.acting.torque(one, base, now)
    return one if torque is one.torque else replace(one, torque=torque)


def already(applied: Sequence[Applied]) -> dict[str, Float]:
    """Return by how much each thing differs already, {name: its numbers}."""
    out: dict[str, Float] = {}
    for change in applied:
        for item in change.found:
            size = np.array([e.value for e in item.change])
            known = out.get(item.name)
            out[item.name] = size if known is None or known.size != size.size else known + size
    return out
