"""Parts of recordings, and what is held true of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gain import RecordingEvidence
from exoid.diagnosis.hypotheses.recordings import Claim, Node, StateColumn
from exoid.measurement.reading.names import joints_of
from exoid.optimisation.preparation.prepare import Prepared
from exoid.symbolic.joints import Vector
from exoid.symbolic.motion import Float

Cuts = Mapping[int, int]
"""{recording: its kept sample from which on something may be different}, by index."""
UNCUT: Cuts = MappingProxyType({})


@dataclass(frozen=True, eq=False)
class Claimed:
    """A claim that is held true, at a node; each of the `groups` of parts (indices) has a number."""

    claim: Claim
    node: Node
    groups: tuple[Group, ...]

    @property
    def count(self) -> int:
        """Numbers that tell it in one group: of what has a place, what shows of that place, too."""
        return 1 + (int(self.turn.any(axis=0).sum()) if len(self.claim.nodes) > 1 else 0)

    @property
    def along(self) -> float | Vector:
        """Place of a load as a `Payload` has it: m along its link, or three numbers in space."""
        first, *others = self.node
        return (first, others[0], others[1]) if others else first

    @property
    def turn(self) -> Float:
        """Derivative (m, D) of how its pieces are mixed, by its node (D,)."""
        steps = STEP * np.eye(len(self.node))
        ends = [[self.claim.mix(tuple(self.node + way * step)) for way in (1.0, -1.0)] for step in steps]
        return np.stack([(ahead - behind) / (2.0 * STEP) for ahead, behind in ends], axis=1)


State = tuple[Claimed, ...]
Group = tuple[int, ...]
"""Parts of recordings (indices) that share a number."""
Span = tuple[float | None, float | None]
"""From when and until when, s; None for the beginning and the end of a recording."""

STEP = 1e-4
"""m by which a place is moved for a derivative: inertias are squares of it, of which the difference is exact."""
QUIET = 0.3
"""Standard deviations of a further column that it may vary within a second."""
STATES = 4
"""Recordings that are needed where a column only differs from one to the other: of fewer, any column may go with what
differs.
"""


def grouped(state: State) -> list[tuple[Claimed, Group]]:
    """Each claim with each of its groups, in the order of their numbers (C,)."""
    return [(held, group) for held in state for group in held.groups]


def of_part(state: State, numbers: Float, j: int) -> list[tuple[Claimed, float]]:
    """Claims that hold of a part (index), each with its number among `numbers` (C,)."""
    return [(held, x) for (held, group), x in zip(grouped(state), numbers.tolist(), strict=True) if j in group]


def state_columns(now: FittedModel) -> tuple[StateColumn, ...]:
    """Further columns that all recordings have and that say in what state the machine was: they change, and slowly."""
    first, *others = [item.logged for item in now.prepared.all]
    out = []
    for name in (name for name in first if all(name in logged for logged in others)):
        every = [logged[name] for logged in (first, *others)]
        if len({item.unit for item in every}) > 1:
            continue
        values = np.concatenate([item.values for item in every])
        low, high = float(values.min()), float(values.max())
        within = max(float(np.ptp(item.values)) for item in every)
        noise = float(np.median([item.noise for item in every]))
        if not noise < QUIET * values.std() or (within < QUIET * (high - low) and len(every) < STATES):
            continue
        named = joints_of(name, now.model.joints)
        joint = min(named) - 1 if len(named) == 1 else None
        out.append(StateColumn(name, first[name].unit, 0.5 * (low + high), 0.5 * (high - low), joint))
    return tuple(out)


@dataclass(frozen=True)
class Part:
    """The kept samples `start` to `stop` of a recording (index): the whole of it, or what is before or after a cut,
    which is at the time `cut` s where that is known better than to a kept sample. Its motion may be another one than
    was recorded, by numbers that are `known` {claim's key: number}.
    """

    recording: int
    start: int
    stop: int
    samples: int
    cut: float | None = None
    known: Mapping[tuple[str, str | None, str, bool], float] = field(default_factory=dict, compare=False)

    @property
    def kept(self) -> slice:
        """The kept samples of the recording that belong to it."""
        return slice(self.start, self.stop)

    @property
    def whole(self) -> bool:
        """True if it is all of the recording."""
        return self.stop - self.start == self.samples

    def span(self, prepared: Prepared) -> Span:
        """From when and until when it lasts, in s of the recording's own time; None for its beginning and end."""
        times = prepared.all[self.recording].t
        start, stop = (
            (float(times[k]) if self.cut is None else self.cut) if 0 < k < self.samples else None
            for k in (self.start, self.stop)
        )
        return start, stop

    def share(self, t: Float, prepared: Prepared) -> Float:
        """Part (N,) of each sample at times `t` that lies in it: 0 or 1, but where it begins or ends."""
        start, stop = self.span(prepared)
        step = (t[-1] - t[0]) / max(1, len(t) - 1)
        since, left = (0.5 if end is None else sign * (t - end) / step for sign, end in ((1, start), (-1, stop)))
        return np.clip(since + 0.5, 0.0, 1.0) * np.clip(left + 0.5, 0.0, 1.0) * np.ones(len(t))


def parts_of(blocks: Sequence[RecordingEvidence], cuts: Cuts) -> tuple[Part, ...]:
    """Parts of all recordings, in order: two of those that are cut."""
    samples = [block.residual.shape[1] for block in blocks]
    ends = [(0, cuts[k], many) if k in cuts else (0, many) for k, many in enumerate(samples)]
    return tuple(Part(k, a, b, many) for k, many in enumerate(samples) for a, b in pairwise(ends[k]))
