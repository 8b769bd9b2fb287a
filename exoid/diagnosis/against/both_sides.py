"""Recordings from before and after as one body of evidence, and a model with further columns fitted to all of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gain import Evidence, RecordingEvidence, pooled_scale, robust_weight
from exoid.diagnosis.evidence.gram import weighted_fit
from exoid.diagnosis.rules import Rules
from exoid.optimisation.linear.uncertainty import covariance
from exoid.symbolic.motion import Float

PARTS = 4
"""Parts at least into which each side is cut, so that some can be held out."""
ROUNDS = 3
"""Times a fit is weighted anew."""


def cut_evidence(now: FittedModel, before: int, seed: int, rules: Rules) -> Evidence:
    """Return the evidence on all recordings, each cut so that either side has `PARTS` parts."""
    whole = now.evidence(seed=seed, draws=0, rules=rules)
    blocks = []
    for k, block in enumerate(whole.blocks):
        side = before if k < before else len(whole.blocks) - before
        parts = -(-PARTS // side)
        samples = block.residual.shape[1]
        blocks.append(replace(block, fold=np.arange(samples) * parts // samples))
    # A large change is no outlier: where samples count less because of it, what shows least of it would lead.
    left = [(block.residual, block.use) for block in blocks]
    scale = np.maximum(pooled_scale(left[:before]), pooled_scale(left[before:]))
    return Evidence(blocks, [], seed=seed, draws=0, sigma=scale, prior=whole.prior, rules=rules)


def replace_blocks(evidence: Evidence, blocks: Sequence[RecordingEvidence], seed: int, rules: Rules) -> Evidence:
    """Return the evidence on other blocks, with the placebos of `rules`; columns beyond those it holds are free."""
    prior = np.zeros(blocks[0].columns.shape[2])
    prior[: evidence.prior.size] = evidence.prior
    return Evidence(list(blocks), [], seed=seed, sigma=evidence.sigma, prior=prior, rules=rules)


def with_columns(evidence: Evidence, columns: Sequence[Float], seed: int, rules: Rules) -> Evidence:
    """Return the evidence with further columns (J, K, m) in the model."""
    blocks = [
        replace(b, columns=np.concatenate([b.columns, own], axis=2))
        for b, own in zip(evidence.blocks, columns, strict=True)
    ]
    return replace_blocks(evidence, blocks, seed, rules)


class CommonFit:
    """The model with further columns, fitted to all recordings at once by weighted least squares."""

    def __init__(self, evidence: Evidence, further: Sequence[Sequence[Float]]) -> None:
        self.blocks = evidence.blocks
        self.sigma = evidence.sigma
        self.weights = [robust_weight(b, self.sigma, evidence.rules) / self.sigma[:, None] ** 2 for b in self.blocks]
        self.columns = [
            np.concatenate([b.columns, *(own[k] for own in further)], axis=2) for k, b in enumerate(self.blocks)
        ]
        self.prior = np.zeros(self.columns[0].shape[2])
        self.prior[: evidence.prior.size] = evidence.prior

    def solve(self) -> Float:
        """Return the step (P + m,) from the model's numbers; each round weighs by what the last one leaves."""
        step = self._solved()
        for _ in range(ROUNDS):
            self.weights = [
                robust_weight(replace(b, residual=self.left(k, step)), self.sigma) / self.sigma[:, None] ** 2
                for k, b in enumerate(self.blocks)
            ]
            step = self._solved()
        return step

    def _solved(self) -> Float:
        return weighted_fit(self.columns, self.weights, [b.residual for b in self.blocks], self.prior)[1]

    def left(self, index: int, step: Float) -> Float:
        """Return the residual (J, K) of one recording after `step`, N·m."""
        return np.asarray(self.blocks[index].residual - self.columns[index] @ step)

    def spread(self, step: Float) -> tuple[Float, float]:
        """Return the covariance (P + m, P + m) of the step, valid under autocorrelation, and the critical value."""
        use = np.concatenate([b.use for b in self.blocks], axis=1) / self.sigma[:, None]
        jacobian = np.concatenate(self.columns, axis=1) * use[:, :, None]
        residual = np.concatenate([self.left(k, step) for k in range(len(self.blocks))], axis=1) * use
        groups = np.repeat(np.arange(len(self.blocks)), [b.residual.shape[1] for b in self.blocks])
        limit = np.full(len(self.sigma), 3.0)
        found = covariance(jacobian, residual, limit, groups)
        return found.matrix, found.critical
