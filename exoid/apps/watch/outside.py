"""Channels of what acts from outside, which come with every sample: measured forces, and whether a foot is on the
ground.

As everywhere else columns of forces that the model says nothing of mean the usual ones (`exoid.measurement.forces`),
and where a foot's contact is known and the ground's force is not, torques of stance count for nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exoid.apps.watch.blocks import Blocks
from exoid.apps.watch.settings import Settings
from exoid.apps.watch.window import Window
from exoid.ground.errors import ExoidError
from exoid.measurement.forces import force_signals, pushed_model, usual_forces
from exoid.measurement.reading.columns import required
from exoid.measurement.reading.outside import CONTACT, GROUND, force_columns
from exoid.measurement.recording import Recording
from exoid.measurement.stance import LOADED
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

UNSEEN = "unseen"
"""Column behind all others that is 1 where the torque says nothing of the machine."""
ASSUMED = 0.25
"""m along its link at which a force is taken to act that has never acted yet."""


def outside_names(joints: Sequence[Joint]) -> tuple[str, ...]:
    """Return the columns that may stand behind the torques of a sample."""
    return (*force_columns(joints), CONTACT)


@dataclass(eq=False)
class Outside:
    """The columns `names` (C,) behind the torques of a sample, in their order; `model` is the one that knows them.

    `usual` says that nobody but the columns told of these forces.
    """

    model: Model
    names: tuple[str, ...]
    usual: bool
    low: float = np.inf
    high: float = -np.inf
    switch: bool = True
    """Whether the contact has been nothing but 0 and 1 so far."""

    @classmethod
    def of(cls, model: Model, names: Sequence[str] | None = None) -> Outside:
        """Return the columns `names` as a model knows them, those of its own forces where none are named; ExoidError
        where one of its forces is not among them.
        """
        if names is None:
            return cls(model, model.channels, False)
        lacking = [name for name in model.channels if name not in names]
        if lacking:
            raise ExoidError(
                f"there is no column {lacking[0]}, and the model has a force of it", where=model.name,
                remedy=f"--map {lacking[0]}=COLUMN, or leave the force out of the model file",
            )  # fmt: skip
        if UNSEEN not in names and any(force.delay for force in model.forces):
            raise ExoidError(
                "a force that is logged later than the torque cannot be put right while it is watched",
                where=model.name, remedy="log it in time (delay = 0), or watch the recording afterwards",
            )  # fmt: skip
        if model.forces:
            return cls(model, tuple(names), False)
        forces = usual_forces(names, model.joints)
        return cls(model.with_forces(*forces) if forces else model, tuple(names), bool(forces))

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of all numbers of a sample as it is pushed."""
        return (*required(self.model.joints), *self.names)

    @property
    def passed(self) -> tuple[str, ...]:
        """The names of all numbers of a sample as the filters take it."""
        return (*required(self.model.joints), *((*self.model.channels, UNSEEN) if self.names else ()))

    def blocks(self, settings: Settings) -> Blocks:
        """Return the blocks, which filter samples and cut them into windows."""
        return Blocks(self.passed, len(self.model.joints), settings.block, settings.cutoff)

    def arranged(self, rows: Float) -> Float:
        """Return samples (N, 1 + 2 J + C) as the filters take them: behind the torques the model's channels, and 1
        where the torque says nothing of the machine. ExoidError where a sample has another number of numbers.
        """
        wanted = self.columns
        if rows.shape[1] != len(wanted):
            what = f"a sample has {rows.shape[1]} numbers; this machine has {len(wanted)}: {', '.join(wanted)}"
            raise ExoidError(what, remedy="give rows t, q1, ..., tau1, ..., and what acts from outside behind them")
        if not self.names:
            return rows
        first = len(required(self.model.joints))
        behind = dict(zip(self.names, rows[:, first:].T, strict=True))
        unseen = behind.get(UNSEEN, np.zeros(len(rows)))
        if CONTACT in behind and behind.keys().isdisjoint(GROUND):
            unseen = self._stance(behind[CONTACT])
        return np.column_stack([rows[:, :first], *(behind[name] for name in self.model.channels), unseen])

    def _stance(self, contact: Float) -> Float:
        """Return 1 where the foot carries load (N,), judged by all that its contact has been."""
        finite = contact[np.isfinite(contact)]
        if finite.size:
            self.low, self.high = min(self.low, float(finite.min())), max(self.high, float(finite.max()))
            self.switch = self.switch and bool(np.isin(finite, (0.0, 1.0)).all())
        if self.switch:
            return contact
        level = self.low + LOADED * (self.high - self.low)
        return np.where(np.isfinite(contact), np.where(contact > level, 1.0, 0.0), contact)

    def learnt_from(self, kept: Sequence[Window]) -> Model:
        """Return the model to be learnt from windows `kept`: a usual force that never acts in them has no place there,
        and none is looked for.
        """
        still = self._still(kept)
        return self.model.with_forces(*(
            replace(force, at=ASSUMED) if force.at is None and still >= {*force.columns} else force
            for force in self.model.forces
        )) if self.usual and still else self.model  # fmt: skip

    def awake(self, learnt: Model, one: Window) -> bool:
        """True if a force acts in a window that never did where `learnt` was learnt: its place is to be learnt now."""
        if not self.usual or learnt is self.model:
            return False
        still = self._still([one])
        pairs = zip(self.model.forces, learnt.forces, strict=True)
        return any(now.at != was.at and not still >= {*now.columns} for now, was in pairs)

    def _still(self, some: Sequence[Window]) -> set[str]:
        """Return the channels that do not change in windows."""
        parts = [item.motion.force for item in some if item.motion.force is not None]
        if not parts:
            return set()
        whole = np.concatenate(parts)
        return {name for name, column in zip(self.model.channels, whole.T, strict=True) if np.ptp(column) == 0.0}


def stream_of(model: Model, recording: Recording) -> tuple[Float, tuple[str, ...]]:
    """Return the samples of a recording, its forces in time with its torques, and the names of the columns behind
    these.

    A row without a torque says nothing of the machine, as one of stance; one without an angle is left out.
    """
    model = pushed_model(model, [recording])
    signals = force_signals(model, recording)
    unseen = np.asarray(~recording.torque_valid.all(axis=1))
    parts = [recording.t, recording.q, np.where(unseen[:, None], 0.0, recording.tau)]
    parts += [unseen] if signals is None else [signals, unseen]
    rows = np.column_stack(parts)
    use = np.asarray(recording.valid & recording.angle_valid.all(axis=1) & np.isfinite(rows).all(axis=1))
    return rows[use], (*model.channels, UNSEEN)
