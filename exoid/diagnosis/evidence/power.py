"""Power of recordings: the smallest size at which each effect that is not in the model would be accepted.

An effect is imagined beside the model, at its usual shape and with multiples of its usual coefficients. What the error
on held-out motion would be more by it follows from the Gram blocks, the model refitted; accepted would be what takes
so much as the search asks for, and more than its own placebos and what noise of the angles makes of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate, feeds_back
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.library import Library
from exoid.diagnosis.evidence.simulated import Simulated, evidence_on, needed_beyond_noise
from exoid.ground.plain import AsJson
from exoid.ground.ties import index_of_least
from exoid.optimisation.fitting.shapes import to_unit
from exoid.symbolic.effect import Effect
from exoid.symbolic.effect_catalogue import find_effect
from exoid.symbolic.motion import Float
from exoid.symbolic.wording import called

DRAWS = 199
"""Placebos of each effect; it must do better than all of them."""
TOLD = 4
"""Effects that a sentence names at most."""
SURE = 3.0
"""Times the size at which it takes so much on average: by then it does whatever the noise, and in all splits."""
MOST = 0.5
"""Share of the loss that is asked of an effect at most."""
LARGEST = 1000.0
"""Times its usual size that no effect has: beyond, recordings show nothing of it."""


@dataclass(frozen=True)
class Power(AsJson):
    """From which `smallest` value of its `parameter` on recordings would have shown an effect, and how large it usually
    is, `usual`, both in `unit`; infinite where they show nothing of it.
    """

    effect: str
    joint: str | None
    parameter: str
    smallest: float
    usual: float
    unit: str

    @property
    def name(self) -> str:
        """Full name, e.g. "stribeck:knee"."""
        return self.effect if self.joint is None else f"{self.effect}:{self.joint}"

    @property
    def would_show(self) -> bool:
        """True if an effect of the usual size would have been accepted."""
        return self.smallest <= self.usual

    def _json(self) -> dict[str, Any]:
        return {**super()._json(), "would_show": self.would_show}


def power_of(
    fitted: FittedModel, evidence: Evidence, library: Library, simulated: Sequence[FittedModel]
) -> tuple[Power, ...]:
    """Power of the recordings of `fitted` to show every candidate of the `library`, in its order.

    `evidence` is that against the model `fitted`, `simulated` the same model on recordings that it made itself.
    """
    made = evidence_on(simulated, evidence)
    absent = (item for item in library.candidates if item.name not in fitted.model.effects)
    found = [_power(item, fitted, evidence, library, made) for item in absent]
    return tuple(entry for entry in found if entry is not None)


def _power(
    candidate: Candidate, fitted: FittedModel, evidence: Evidence, library: Library, made: Sequence[Simulated]
) -> Power | None:
    """Return the power for one candidate; None where nobody has said how large it usually is."""
    sizes = _usual_sizes(candidate)
    if sizes is None:
        return None
    key, unit, limit, usual, coefficients = sizes
    columns = library.columns(candidate, fitted)
    nodes = _usual_nodes(candidate)
    falls, unseen = evidence.would_gain(evidence.plain([c.some(nodes) for c in columns]), coefficients)
    least, most = evidence.rules.least_share, int(np.argmax(np.minimum(falls, unseen) if unseen.any() else falls))
    node = int(nodes[most])
    loss = float(evidence.fold_losses.sum())
    smooths = feeds_back(candidate.term)  # other effects noise of the angles does not make
    needed = least + (needed_beyond_noise(candidate, candidate.nodes[:, node], evidence, made) if smooths else 0.0)
    by_chance = float(evidence.shifted_gains([c.node(node) for c in columns], 0).max(initial=0.0))
    wanted = max(needed / (1.0 - min(needed, MOST)) * loss, by_chance)
    parts = [(wanted, falls[most])]
    if evidence.unseen_loss:
        parts.append((least * evidence.unseen_loss, unseen[most]))
    with np.errstate(divide="ignore"):
        times = max(float(np.sqrt(np.divide(need, gain))) if gain > 0.0 else np.inf for need, gain in parts)
    term, smallest = candidate.term, SURE * usual * times
    if smallest > min(usual * LARGEST, np.inf if limit is None else limit):  # a size that it cannot have
        smallest = np.inf
    return Power(term.effect.id, term.joint, key, smallest, usual, unit)


def _usual_sizes(candidate: Candidate) -> tuple[str, str, float | None, float, Float] | None:
    """Return the number that is told of a candidate, its unit, the most it can be, if any, how large it usually is, and
    the candidate's coefficients (m,) then.
    """
    term = candidate.term
    if term.parameters:
        sizes = np.array([parameter.typical or 0.0 for parameter in term.parameters])
        if not sizes.any():
            return None
        first = int(np.argmax(sizes != 0.0))
        parameter, key = term.parameters[first], list(term.effect.coefficients)[first]
        return key, parameter.unit, parameter.max, abs(float(sizes[first])), sizes
    (key, shape), *_ = term.placed_shape.items()
    if not shape.typical:
        return None
    sizes = np.array([shape.typical if candidate.tangent else 1.0])
    return key, shape.unit, shape.max, abs(shape.typical), sizes


def _usual_nodes(candidate: Candidate) -> np.ndarray:
    """Return the nodes that are nearest to the usual shape; where it has no usual place, those of every place."""
    shapes = list(candidate.term.placed_shape.values())
    nodes, away = candidate.nodes[0], np.zeros(candidate.nodes.shape[1])
    for k, shape in enumerate(shapes):
        if shape.typical is not None and shape.spacing != "position" and not candidate.tangent:
            own = to_unit(shape, shape.typical)
            away = away + np.abs([to_unit(shape, float(value)) - own for value in nodes[:, k]])
    return np.flatnonzero(away <= away[index_of_least(away)] + 1e-12)


def power_said(power: Sequence[Power], find: Callable[[str], Effect] = find_effect) -> str:
    """Effects that recordings would not have shown, that of which they say least first, as a sentence; "" where nothing
    is known.
    """
    hidden = [item for item in power if not item.would_show]
    if not power:
        return ""
    if not hidden:
        return "Each effect of the catalogue would have shown at its usual size."
    least = sorted(hidden, key=lambda one: (-one.smallest / one.usual, one.name))
    told = "; ".join(_said(entry, find) for entry in least[:TOLD])
    more = f"; and {len(least) - TOLD} more" if len(least) > TOLD else ""
    seen = f"{len(power) - len(hidden)} of {len(power)} effects" if len(hidden) < len(power) else "no effect"
    return f"At its usual size {seen} would have shown; too little is said by these recordings of: {told}{more}."


def _said(one: Power, find: Callable[[str], Effect]) -> str:
    name = called(one.name, find)
    if not np.isfinite(one.smallest):
        return f"{name} (at any size)"
    unit = "" if one.unit in ("1", "") else f" {one.unit}"
    return f"{name} (found from {one.smallest:.3g}{unit}, usually {one.usual:.3g})"
