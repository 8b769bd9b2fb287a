"""Does the answer depend on the filter? The same fit at a lower and a higher cut-off, compared with its intervals.

The cut-off moves parameters more than any effect (a faster one lets the noise of accelerations pull inertias to zero,
a slower one shows less of what is missing). Where neighbouring cut-offs agree within the intervals stated, they may be
believed; where not, the report says which parameter moves, from where to where.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from exoid.ground.errors import ExoidError
from exoid.ground.plain import plain_dict
from exoid.ground.thresholds import Threshold
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import Prepared, prepare
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

FACTORS = (0.8, 1.25)
"""Neighbouring cut-offs, relative to the one used."""
BEYOND: Threshold = 0.1
"""half-widths by which a value leaves its interval at another cut-off: rounding"""


@dataclass(frozen=True, eq=False)
class Neighbours:
    """Every parameter at neighbouring cut-offs: `values` (C, M) at `cutoffs` (C,) in Hz, in the order of `fit`."""

    fit: Fit
    cutoff: float
    cutoffs: tuple[float, ...]
    values: tuple[Float, ...]

    @property
    def moved(self) -> tuple[tuple[str, float, float], ...]:
        """(name, cut-off, value) of every parameter that leaves its 95 % interval at a neighbouring cut-off."""
        return tuple(
            (e.name, cutoff, float(value))
            for cutoff, row in zip(self.cutoffs, self.values, strict=True)
            for e, value in zip(self.fit.estimates, row, strict=True)
            if max(e.low - value, value - e.high) > 0.5 * BEYOND * (e.high - e.low)
        )

    @property
    def agree(self) -> bool:
        """True if every parameter stays within its interval."""
        return not self.moved

    def findings(self) -> tuple[Finding, ...]:
        """Findings that call for care; none where they agree."""
        at = {e.name: e for e in self.fit.estimates}
        remedy = "do not trust its interval: something is missing or noise reaches the accelerations; `exoid diagnose`"
        found = []
        for name, cutoff, value in self.moved:
            own = at[name]
            what = f"{value:.4g} {own.unit} at {cutoff:g} Hz, outside its interval {own.low:.4g} to {own.high:.4g}"
            passed = own.high if value > own.high else own.low
            found.append(Finding("cut_off", "warning", f"{what} at {self.cutoff:g} Hz", name, value, passed, remedy))
        return tuple(found)

    def to_json(self) -> dict[str, Any]:
        """Return cut-offs, values by parameter, and what moved, in plain types."""
        names = [e.name for e in self.fit.estimates]
        return plain_dict({
            "cutoff": self.cutoff,
            "cutoffs": self.cutoffs,
            "parameters": {n: [float(row[k]) for row in self.values] for k, n in enumerate(names)},
            "agree": self.agree,
            "moved": [{"parameter": n, "cutoff": c, "value": v} for n, c, v in self.moved],
        })


def neighbours(fit: Fit, model: Model, prepared: Prepared, recordings: Sequence[Recording]) -> Neighbours:
    """Return `fit` of `prepared` (from `recordings`) at neighbouring cut-offs, as many as the sampling rate allows.

    Shape parameters are searched from where they are; they are numbers like the others.
    """
    cutoffs, values = [], []
    for factor in FACTORS:
        cutoff = factor * prepared.choice.cutoff
        try:
            again = prepare(model, recordings, cutoff=cutoff, derivative=prepared.derivative)
            near = identify(
                model, again.train, optimisers=(), start=fit.start, physical=fit.held is not None,
                weighted=bool(np.any(fit.weight != 1.0)),
            )  # fmt: skip
        except ExoidError:  # too fast for the recordings' clock: then there is no such neighbour
            continue
        cutoffs.append(cutoff)
        values.append(np.concatenate([near.linear, near.shape]))
    return Neighbours(fit, prepared.choice.cutoff, tuple(cutoffs), tuple(values))
