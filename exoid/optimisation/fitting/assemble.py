"""From a model and prepared recordings to the linear data of a fit.

The regressor is filtered exactly like the torque, so that filtering cannot bend the parameters. A model whose
effects act on a torque of the model itself (load friction) needs parameters to compute its columns; these are
found as a fixed point: columns from the last parameters, parameters from the columns, until nothing changes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from exoid.optimisation.linear.factor import RANK_TOLERANCE, Factors, factorise
from exoid.optimisation.linear.problem import LinearData
from exoid.symbolic.evaluation import carrying
from exoid.symbolic.language.torque import uses_feedback
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

if TYPE_CHECKING:
    from exoid.optimisation.preparation.filtering import PreparedRecording

FIXED_POINT_ROUNDS = 60
FIXED_POINT_TOLERANCE = 1e-9
EXTRAPOLATED, CLOSER = 4, 0.7
"""Rounds before the last from which a fixed point is extrapolated, and how much smaller a round's change must be than
that of the round before for these to count."""
TRIED = 3
"""Shape values of an effect whose columns are kept: where a descent stands, and one step to either side."""
TOGETHER = 2_000_000
"""Values of columns that are computed at once, at most."""


class Assembly:
    """Builds the linear data of one model and its recordings again and again, for other shapes.

    Filtering costs more than evaluating, and most columns do not depend on the shapes: only those of effects whose own
    shapes or fed-back torques have changed are computed again, and a column that comes out as it did last time is not
    filtered again.
    """

    def __init__(self, model: Model, prepared: Sequence[PreparedRecording]) -> None:
        self.model = model
        self.prepared = tuple(prepared)
        self._raw: list[Float | None] = [None] * len(self.prepared)
        self._smooth: list[Float | None] = [None] * len(self.prepared)
        self._at = [b""] * len(self.prepared)
        self._terms = _followers(model)
        self._tried: dict[tuple[int, int], dict[bytes, Float]] = {}
        self._written: dict[tuple[int, int], bytes] = {}
        self._factors = Factors()
        self.weight = np.ones(len(model.joints))
        """Weight (J,) of each joint's torque in what is handed out."""
        self._tau = np.concatenate([recording.torque for recording in self.prepared], axis=1)
        self._use = np.concatenate([recording.used for recording in self.prepared], axis=1)
        self._groups = np.repeat(np.arange(len(self.prepared)), [len(recording.kept) for recording in self.prepared])

    def data(self, shape: Float | None = None, reference: Float | None = None) -> LinearData:
        """Return the linear data for shape values ((S,), or (R, S) one row per recording) and `reference` (P,)."""
        columns = [self._columns(index, shape, reference) for index in range(len(self.prepared))]
        return LinearData(
            columns=np.concatenate(columns, axis=1)[:, :, : len(self.model.parameters)],
            owned=True,
            tau=self._torque(columns),
            groups=self._groups,
            names=tuple(p.name for p in self.model.parameters),
            units=tuple(p.unit for p in self.model.parameters),
            use=self._use,
            factoriser=self._factors,
        ).weighted(self.weight)

    def _torque(self, columns: Sequence[Float]) -> Float:
        """Return the torque (J, K) that is left to explain: without that of known payloads and of measured forces whose
        place is known, filtered as the columns.
        """
        motions = [recording.motion for recording in self.prepared]
        if not self.model.forces and all(motion.payload is None for motion in motions):
            return self._tau
        none = np.zeros(len(self.model.parameters))
        known = [part @ carrying(self.model, motion, none) for part, motion in zip(columns, motions, strict=True)]
        return np.asarray(self._tau - np.concatenate(known, axis=1))

    def _columns(self, index: int, shape: Float | None, reference: Float | None) -> Float:
        recording, before, smooth = self.prepared[index], self._raw[index], self._smooth[index]
        own = shape[index] if shape is not None and np.ndim(shape) == 2 else shape
        places = list(self.model.following_places)
        at = b"" if own is None else np.concatenate([own, () if reference is None else reference]).tobytes()
        if places and smooth is not None and own is not None:
            if at != self._at[index]:
                for number, (term, shapes, fed_back) in enumerate(self._terms):
                    heard = reference if fed_back and reference is not None else ()
                    key = np.concatenate([own[shapes], heard]).tobytes()
                    if self._written.get((index, number)) == key:
                        continue
                    kept = self._tried.setdefault((index, number), {})
                    if (found := kept.pop(key, None)) is None:
                        found = self._following(recording, term, np.asarray(own)[None], reference)[0]
                    kept[key] = found  # the last that was asked for
                    if len(kept) > TRIED:
                        del kept[next(iter(kept))]
                    smooth[:, :, term] = found  # what was handed out is a copy
                    self._written[index, number] = key
                self._smooth[index], self._at[index] = smooth, at
            return smooth
        raw = self.model.whole_columns(recording.motion, own, reference)
        self._written = {key: value for key, value in self._written.items() if key[0] != index}
        if before is None or smooth is None:
            smooth = recording.smooth_columns(raw)
        else:
            changed = np.flatnonzero((raw != before).any(axis=(0, 1)))
            if changed.size:
                smooth = smooth.copy()
                smooth[:, :, changed] = recording.smooth_columns(raw[:, :, changed])
        self._raw[index], self._smooth[index], self._at[index] = raw, smooth, at
        return smooth

    def _following(
        self, recording: PreparedRecording, places: Sequence[int], nodes: Float, reference: Float | None
    ) -> Float:
        """Return the filtered columns (V, J, K, m) at `places` (m,) that follow the shapes, at `nodes` (V, S)."""
        raw = self.model.following_columns(recording.motion, places, nodes, reference)
        joints = np.flatnonzero(raw.any(axis=(0, 2, 3))).tolist()
        out = np.zeros((*raw.shape[:2], len(recording.kept), raw.shape[2]))
        if not joints:  # zero at all nodes, as of a stop that is never met
            return out
        out[:, joints] = np.swapaxes(recording.smooth_rows(raw[:, joints], joints, 1), 2, 3)
        return out

    def sse_at(self, nodes: Float, reference: Float | None = None) -> Float | None:
        """Return the smallest sum of squares (V,) at `nodes` (V, S), all at once; parameters that columns depend on are
        held at `reference` (P,). None where more columns follow the shapes than `following_places`, or `held_places`.

        What stays is projected out once (Golub, Pereyra 1973).
        """
        places = list(self.model.following_places if reference is None else self.model.held_places)
        if not places:
            return None
        data = self.data(nodes[0], reference)
        if reference is not None:
            moved = (self.data(nodes[-1], reference).columns != data.columns).any(axis=(0, 1))
            if np.delete(moved, places).any():
                return None
        basis = factorise(np.delete(data.matrix, places, axis=1)).basis
        rest = data.vector - basis @ (basis.T @ data.vector)
        out = []
        many = max(1, TOGETHER // (data.columns[:, :, places].size * max(1, round(self._thinned))))
        for some in np.array_split(nodes, -(-len(nodes) // many)):
            parts = [self._following(recording, places, some, reference) for recording in self.prepared]
            columns = np.concatenate(parts, axis=2) * (data.use * self.weight[:, None])[:, :, None]
            columns = columns.reshape(len(some), -1, len(places))
            rows = np.ascontiguousarray(np.swapaxes(columns, 1, 2))
            onto, slope = rows @ basis, rows @ rest
            length = np.sqrt(np.sum(rows**2, axis=2))
            scale = 1.0 / np.where(length > 0.0, length, 1.0)
            gram = (rows @ columns - onto @ np.swapaxes(onto, 1, 2)) * scale[:, :, None] * scale[:, None, :]
            size, axes = np.linalg.eigh(gram)
            along = np.einsum("vmk,vm->vk", axes, slope * scale)
            told = size > RANK_TOLERANCE
            out.append(rest @ rest - np.sum(np.where(told, along**2 / np.where(told, size, 1.0), 0.0), axis=1))
        return np.concatenate(out)

    @property
    def _thinned(self) -> float:
        """Samples of the motion for each that is kept."""
        return float(np.mean([len(recording.motion) / max(1, len(recording.kept)) for recording in self.prepared]))


def _followers(model: Model) -> list[tuple[list[int], list[int], bool]]:
    """Return for every effect with columns at `following_places` these, its shapes, and whether it is fed back."""
    places, found = set(model.following_places), []
    for term in model.terms if places else ():
        own = [k for k, parameter in enumerate(model.parameters) if parameter.term == term.name and k in places]
        if own:
            shapes = [k for k, entry in enumerate(model.shapes) if entry.term == term.name]
            found.append((own, shapes, uses_feedback(term)))
    return found


def assemble(model: Model, prepared: Sequence[PreparedRecording]) -> LinearData:
    """Return the linear data of all `prepared` recordings at typical shapes."""
    return Assembly(model, prepared).data()


@dataclass(frozen=True, eq=False)
class Settled:
    """Linear data, the parameters (P,) that solve it, and how many `rounds` the fixed point took."""

    data: LinearData
    linear: Float
    rounds: int
    converged: bool


def settle(
    assembly: Assembly,
    shape: Float | None,
    solve: Callable[[LinearData], Float],
    reference: Float | None = None,
) -> Settled:
    """Solve the linear parameters; a model that needs reference parameters is iterated to their fixed point.

    The first reference is `reference` (P,) or zero, which makes the fed-back columns vanish in round one. The next one
    is extrapolated from the last rounds (Anderson, Iterative procedures for nonlinear integral equations, 1965).
    """
    model = assembly.model
    if not model.needs_reference:
        data = assembly.data(shape)
        return Settled(data, solve(data), 1, True)
    last = np.zeros(len(model.parameters)) if reference is None else np.asarray(reference, dtype=float)
    tried: list[tuple[Float, Float]] = []
    before = np.inf
    for count in range(1, FIXED_POINT_ROUNDS + 1):
        data = assembly.data(shape, last)
        linear = solve(data)
        forward = data.factor.forward
        change = float(np.linalg.norm(forward @ (linear - last)))
        size = float(np.linalg.norm(forward @ linear))
        if change <= FIXED_POINT_TOLERANCE * max(size, np.finfo(float).tiny):
            return Settled(data, linear, count, True)
        # Rounds from far away say little of where it ends, and an extrapolation that led away less than nothing.
        tried = [*tried[-EXTRAPOLATED:], (last, linear)] if change < CLOSER * before else [(last, linear)]
        before, last = change, _extrapolated(tried, forward)
    return Settled(data, linear, FIXED_POINT_ROUNDS, False)


def _extrapolated(tried: Sequence[tuple[Float, Float]], forward: Float) -> Float:
    """Fixed point (P,) of a map, judged by rounds of it (P,) -> (P,), the last of them the nearest; distances
    are measured by the torques that `forward` makes of parameters.
    """
    start, end = tried[-1]
    if len(tried) == 1:
        return end
    starts, ends = (np.stack([pair[k] for pair in tried[:-1]], axis=1) for k in (0, 1))
    steps = (end - start)[:, None] - (ends - starts)
    share = np.linalg.lstsq(forward @ steps, forward @ (end - start), rcond=1e-10)[0]
    return np.asarray(end - (end[:, None] - ends) @ share)
