"""Can one candidate be all that another one is? What is new in both, beside the present model, is held side by side."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

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
THIN = 4
"""Samples of which one is looked at where it is asked whether a node can be the other candidate at all."""


def _on_fitted(
    evidence: Evidence, parts: Sequence[Columns], nodes: Sequence[int] | None = None
) -> Iterator[tuple[Float, Float]]:
    """Yield at every node, or some, the columns (samples, m) on fitted recordings as they are, and what is new in them
    beside the present model.
    """
    basis = evidence.basis
    for node in range(len(parts[0].values)) if nodes is None else nodes:
        whole = np.concatenate([c.full(node, len(b.use))[b.use] for c, b in zip(parts, evidence.train, strict=False)])
        yield whole, whole - basis @ (basis.T @ whole)


def is_within(context: SearchContext, extension: Extension, evidence: Evidence, rival: Candidate, plain: Score) -> bool:
    """True if a rival with more numbers can be nothing else than `plain` beside the present model, whatever its shape:
    the other numbers show on no motion of this machine.
    """
    [(_, own)] = _on_fitted(evidence, columns_at(plain.candidate, plain.shape, extension.fitted))
    for whole, new in _on_fitted(evidence, context.library.columns(rival, extension.fitted)):
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
    [(_, wanted)] = _on_fitted(evidence, columns_at(plain.candidate, plain.shape, extension.fitted))
    torque, nodes = wanted @ np.asarray(plain.coefficients), rival.nodes
    ends = (nodes == nodes.min(axis=1, keepdims=True)) | (nodes == nodes.max(axis=1, keepdims=True))
    limits = np.where(ends.any(axis=(0, 2)), limit, EXACT) * np.sum(torque**2)
    parts = context.library.columns(rival, extension.fitted)
    near = np.flatnonzero(_least_left(evidence, parts[0], torque) <= limits).tolist()
    return any(
        np.sum((torque - own @ np.linalg.lstsq(own, torque, rcond=1e-9)[0]) ** 2) <= limits[node]
        for node, (_, own) in zip(near, _on_fitted(evidence, parts, near), strict=True)
    )


def _least_left(evidence: Evidence, parts: Columns, torque: Float) -> Float:
    """Square (V,) that the columns of each node leave of a torque at least: what they leave of some samples of the
    first recording, with numbers of their own.
    """
    use, found = evidence.train[0].use, []
    some = np.arange(0, np.count_nonzero(use), THIN)
    basis, at = np.linalg.qr(evidence.basis[some])[0], np.flatnonzero(use)[some]
    wanted = torque[some] - basis @ (basis.T @ torque[some])
    for piece in parts.pieces:
        values = parts.some(piece).values
        whole = np.zeros((len(values), *use.shape, values.shape[3]))
        whole[:, list(parts.joints)] = values
        few = whole.reshape(len(values), use.size, -1)[:, at]
        own = few - basis @ (basis.T @ few)
        taken = np.swapaxes(np.linalg.qr(own)[0], 1, 2) @ wanted
        found.append(wanted @ wanted - np.sum(taken**2, axis=1))
    return np.concatenate(found)
