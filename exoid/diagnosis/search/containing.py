"""Can one candidate be all that another one is? What is new in both, beside the present model, is held side by side."""

from __future__ import annotations

from collections.abc import Sequence
from weakref import WeakKeyDictionary

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.look_alikes import columns_at
from exoid.diagnosis.evidence.score import Score
from exoid.diagnosis.search.context import SearchContext
from exoid.diagnosis.search.state import Extension
from exoid.symbolic.motion import Float

EXACT = 1e-8
"""Share of a squared torque up to which two are the same but for rounding."""
UNCLEAR = 1e-6
"""Share by which sums of products may be wrong where columns are distinguished: so near to a limit samples decide."""
TOLD = 1e-7
"""Smallest eigenvalue of what is new in columns of length one, from which sums of products distinguish them."""


class _Beside:
    """New part of columns beside the present model, on fitted recordings, `every` of them by its index."""

    def __init__(self, evidence: Evidence, every: Sequence[int]) -> None:
        blocks, self._every = evidence.blocks, every
        self._uses = [blocks[k].use for k in self._every]
        known = np.concatenate([blocks[k].columns[use] for k, use in zip(self._every, self._uses, strict=True)])
        self._basis, _ = np.linalg.qr(known / np.maximum(np.linalg.norm(known, axis=0), 1e-300))

    def samples(self, parts: Sequence[Columns], node: int) -> tuple[Float, Float]:
        """Return columns at a node as they are and what is new in them, (samples, m)."""
        count = len(self._uses[0])
        pairs = zip(self._every, self._uses, strict=True)
        whole = np.concatenate([parts[k].full(node, count)[use] for k, use in pairs])
        return whole, whole - self._basis @ (self._basis.T @ whole)

    def left_of(self, torque: Float, parts: Sequence[Columns], nodes: np.ndarray | slice) -> Float:
        """Return the square (V,) that columns leave of a `torque` (samples,) in which all is new, at `nodes` (V,), to
        `UNCLEAR` of it; zero where they are too alike to tell.
        """
        gram = onto = slope = np.zeros(())
        ends = np.cumsum([np.count_nonzero(use) for use in self._uses])
        for k, use, end in zip(self._every, self._uses, ends, strict=True):
            some = slice(end - np.count_nonzero(use), end)
            table = np.zeros((*use.shape, self._basis.shape[1] + 1))
            table[use] = np.column_stack([self._basis[some], torque[some]])
            rows = list(parts[k].joints)
            both, square = parts[k].some(nodes).products(use[rows].astype(float), table[rows])
            onto, slope, gram = onto + both[:, :, :-1], slope + both[:, :, -1], gram + square
        length = np.sqrt(np.maximum(np.einsum("vmm->vm", gram), 0.0))
        scale = 1.0 / np.where(length > 0.0, length, np.inf)
        size, axes = np.linalg.eigh((gram - onto @ np.swapaxes(onto, 1, 2)) * scale[:, :, None] * scale[:, None, :])
        told = size > TOLD
        along = np.einsum("vmk,vm->vk", axes, slope * scale)
        left = torque @ torque - np.sum(np.where(told, along**2 / np.where(told, size, 1.0), 0.0), axis=1)
        return np.where(told.all(axis=1), left, 0.0)


_KEPT: WeakKeyDictionary[Evidence, tuple[_Beside, _Beside]] = WeakKeyDictionary()
"""Of evidence that is still in use: one candidate after the other is held beside the same model."""


def _beside(evidence: Evidence) -> tuple[_Beside, _Beside]:
    """New parts on the first recording that shows anything, which says quickly what cannot be, and on all."""
    if evidence not in _KEPT:
        every = [k for k in range(len(evidence.train)) if evidence.blocks[k].use.any()]
        _KEPT[evidence] = _Beside(evidence, every[:1]), _Beside(evidence, every)
    return _KEPT[evidence]


def is_within(context: SearchContext, extension: Extension, evidence: Evidence, rival: Candidate, plain: Score) -> bool:
    """True if a rival with more numbers can be nothing else than `plain` beside the present model, whatever its shape:
    the other numbers show on no motion of this machine.
    """
    (_, beside), columns = _beside(evidence), context.library.columns(rival, extension.fitted)
    _, own = beside.samples(columns_at(plain.candidate, plain.shape, extension.fitted), 0)
    for node in range(rival.nodes.shape[1]):
        whole, new = beside.samples(columns, node)
        rest = new - own @ np.linalg.lstsq(own, new, rcond=1e-9)[0]
        if np.any(np.sum(rest**2, axis=0) > EXACT * np.sum(whole**2, axis=0).max()):
            return False
    return True


def contains(
    context: SearchContext,
    extension: Extension,
    evidence: Evidence,
    rival: Candidate,
    plain: Score,
    limit: float | None = None,
) -> bool:
    """True if a rival can be all that a plainer candidate is here: beside the present model it makes the torque of that
    one, exactly or, at a limit of its shape, but for `limit` (default `negligible`) of what is new in it.

    Two effects that merely resemble each other on this motion do not contain each other.
    """
    limit = evidence.rules.negligible if limit is None else limit
    rival = context.library.find(rival.name)  # with all its nodes, also where one of them was refined
    (first, beside), columns = _beside(evidence), context.library.columns(rival, extension.fitted)
    wanted, numbers = columns_at(plain.candidate, plain.shape, extension.fitted), np.asarray(plain.coefficients)
    torque = beside.samples(wanted, 0)[1] @ numbers
    nodes, whole = rival.nodes, np.sum(torque**2)
    ends = (nodes == nodes.min(axis=1, keepdims=True)) | (nodes == nodes.max(axis=1, keepdims=True))
    limits = np.where(ends.any(axis=(0, 2)), limit, EXACT) * whole
    new = first.samples(wanted, 0)[1] @ numbers
    near = np.flatnonzero(first.left_of(new, columns, slice(None)) <= limits + UNCLEAR * whole)
    if near.size:
        near = near[beside.left_of(torque, columns, near) <= limits[near] + UNCLEAR * whole]
    for node in near:
        _, own = beside.samples(columns, int(node))
        rest = torque - own @ np.linalg.lstsq(own, torque, rcond=1e-9)[0]
        if np.sum(rest**2) <= limits[node]:
            return True
    return False
