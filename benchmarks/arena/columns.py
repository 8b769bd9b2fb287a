"""What rivals that work with columns are given: those that exoid weighs, on the samples that it weighs, by name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from benchmarks.arena.task import Task
from exoid.diagnosis.evidence.candidates import candidate_columns
from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model
from exoid.diagnosis.evidence.library import build_library
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

NODES = 10
"""Trial values of each entry's shape, evenly among those that exoid tries."""


@dataclass(frozen=True, eq=False)
class Table:
    """The recordings of a task as a regression: numbered columns, those of the model as it is first, and the torque.

    Torques are divided by what the model leaves at their joint. Sums of products say all that least squares need.
    """

    task: Task

    @cached_property
    def fitted(self) -> FittedModel:
        """The model as it is, fitted to all recordings."""
        prepared = prepare(self.task.model, self.task.recordings, ())
        return fitted_model(identify(self.task.model, prepared.train, optimisers=()), prepared)

    @cached_property
    def base(self) -> list[int]:
        """Numbers of the columns of the model as it is."""
        return list(range(self.task.model.base_count))

    @cached_property
    def _made(self) -> tuple[dict[str, list[list[int]]], Float, int]:
        fitted, sigma = self.fitted, self.fitted.train_rms[:, None, None]
        runs = fitted.prepared.train
        parts = [[(fitted.block_of(one).columns / sigma)[one.used]] for one in runs]
        nodes: dict[str, list[list[int]]] = {}
        count = parts[0][0].shape[1]
        for candidate in build_library(self.task.model, runs).candidates:
            some = np.unique(np.linspace(0, candidate.nodes.shape[1] - 1, NODES).astype(int))
            few = replace(candidate, nodes=candidate.nodes[:, some])
            made = [candidate_columns(few, rows, one, fitted) for rows, one in zip(few.nodes, runs, strict=True)]
            nodes[candidate.name] = []
            for v in range(len(some)):
                for rows, one, columns in zip(parts, runs, made, strict=True):
                    rows.append((columns.full(v, len(sigma)) / sigma)[one.used])
                width = parts[0][-1].shape[1]
                nodes[candidate.name].append(list(range(count, count + width)))
                count += width
        gram = []
        for rows, one in zip(parts, runs, strict=True):
            x = np.hstack([*rows, (one.torque / sigma[:, :, 0])[one.used][:, None]])
            gram.append(x.T @ x)
        return nodes, np.array(gram), sum(int(one.used.sum()) for one in runs)

    @property
    def nodes(self) -> dict[str, list[list[int]]]:
        """Name of every catalogue entry -> numbers of its columns at every trial value of its shape."""
        return self._made[0]

    @property
    def gram(self) -> Float:
        """Sums of products (R, Q + 1, Q + 1) over each recording, the torque last."""
        return self._made[1]

    @property
    def samples(self) -> int:
        """How many torques there are."""
        return self._made[2]

    @cached_property
    def best(self) -> dict[str, list[int]]:
        """Name -> its columns at the trial value that alone lowers the error most."""
        return {name: min(each, key=lambda node: self.rest([*self.base, *node])) for name, each in self.nodes.items()}

    def rest(self, columns: Sequence[int]) -> float:
        """Return the sum of squares that a regression on these columns leaves."""
        total = self.gram.sum(axis=0)
        return _left(total, columns, _solved(total, columns))

    def unseen(self, columns: Sequence[int]) -> Float:
        """Return the squared error (R,) on every recording of a regression on these columns fitted to the others."""
        total = self.gram.sum(axis=0)
        return np.array([_left(one, columns, _solved(total - one, columns)) for one in self.gram])


def _solved(gram: Float, columns: Sequence[int]) -> Float:
    index = list(columns)
    scale = 1.0 / np.sqrt(np.maximum(gram.diagonal()[index], 1e-30))
    inner = gram[np.ix_(index, index)] * scale[:, None] * scale
    return np.asarray(np.linalg.lstsq(inner, gram[index, -1] * scale, rcond=1e-10)[0] * scale)


def _left(gram: Float, columns: Sequence[int], beta: Float) -> float:
    index = list(columns)
    square = beta @ gram[np.ix_(index, index)] @ beta
    return max(float(gram[-1, -1] - 2.0 * beta @ gram[index, -1] + square), 0.0)


def torque_of(task: Task, names: Sequence[str]) -> Float:
    """Return the torque asked of a task, from exoid's fit of the model with these entries of the catalogue."""
    model: Model = task.model
    for name in names:
        effect, _, joint = name.partition(":")
        model = model.with_effect(effect, joint or None)
    fit = identify(model, prepare(task.model, task.recordings, ()).train, optimisers=())
    return model.torque(task.motion, fit.linear, fit.shape)


def residuals(fitted: FittedModel, every: int) -> tuple[Float, Float, np.ndarray]:
    """Return angles, velocities and accelerations (n, 3 J) of every so many samples, what a model leaves there (n, J)
    in N·m, 0 where it is not used, and the index (n,) of the recording.
    """
    state, left, run = [], [], []
    for k, (one, rest) in enumerate(zip(fitted.prepared.train, fitted.residuals, strict=True)):
        motion = one.motion
        state.append(np.hstack([motion.q, motion.dq, motion.ddq])[one.kept][::every])
        left.append((rest * one.used).T[::every])
        run.append(np.full(len(state[-1]), k))
    return np.concatenate(state), np.concatenate(left), np.concatenate(run)
