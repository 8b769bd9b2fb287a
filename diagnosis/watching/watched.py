"""The columns of all that is watched: of every candidate at few values of its shapes, on one block after the other.

What does not depend on the block is prepared once, and all texts together are one list of steps.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from exoid.diagnosis.against.questions import PLACES, Asked, Questions
from exoid.diagnosis.evidence.candidates import fed_back, tangent_nodes, unfiltered_columns
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.watching.window import Window
from exoid.symbolic.columns import torque_words
from exoid.symbolic.evaluation import carrying, motion_words, signs
from exoid.symbolic.language.plan import TextPlan
from exoid.symbolic.language.torque import Torque, is_transform, part_of, torques
from exoid.symbolic.language.words import FEEDBACK
from exoid.symbolic.motion import Float
from exoid.symbolic.term import Term

NODES = 1
"""Values of the shapes of an effect that are watched: an alarm only has to see it, a name is searched finely."""


@dataclass(eq=False)
class _Texts:
    """Texts of several terms as one plan; `rows` say for what joint each value, or the slope between two values that
    are `apart`, is a column.
    """

    terms: list[Term] = field(default_factory=list)
    plan: TextPlan = field(default_factory=TextPlan)
    rows: list[tuple[int, int, tuple[int, ...], float]] = field(default_factory=list)

    def place(self, term: Term, torque: Torque, node: Float) -> int:
        velocities = [f"dtheta{j + 1}" for j in range(len(term.among))]
        return self.plan.add(torque.node, dict(zip(term.effect.shape, map(float, node), strict=True)), velocities)

    def write(self, words: Mapping[str, Float], window: Window, out: Float) -> None:
        """Add the columns of a window to `out` (C, J, N)."""
        values = self.plan.values({**motion_words(window.motion), **words}, signs(window.motion))
        for column, joint, places, apart in self.rows:
            first, *second = (values[place] for place in places)
            out[column, joint] += (first - second[0]) / apart if second else first


class Watched:
    """Every change of `questions`, beside the model as it is `now`: effects, then numbers, then loads."""

    def __init__(self, questions: Questions, now: FittedModel) -> None:
        self.now, self.count = now, 0
        self.numbers: list[int] = []
        self.loads: list[Asked] = []
        self.texts, self.transforms = _Texts(), _Texts()
        self.others: list[tuple[slice, Asked, Float]] = []
        self.together: list[slice] = []
        for one in questions.candidates:
            if not isinstance(one, Asked) or one.always:
                continue
            if one.number is not None:
                self.numbers.append(one.number)
            elif one.link is not None:
                self.loads.append(one)
            else:
                self._add(one)

    def _add(self, one: Asked) -> None:
        nodes = one.nodes[0]
        nodes = nodes[np.unique(np.linspace(0, len(nodes) - 1, NODES + 2).round().astype(int)[1:-1])]
        for node in nodes:
            own = slice(self.count, self.count + one.width)
            self.count = own.stop
            self.together.append(own)
            if one.term.effect.derive is not None:
                self.others.append((own, one, node[None]))
            elif one.term.effect.coefficients:
                self._add_text(one.term, node, own.start)
            else:
                self._add_transform(one, node, own.start)

    def _add_text(self, term: Term, node: Float, first: int) -> None:
        keys = tuple(term.effect.coefficients)
        self.texts.terms.append(term)
        for torque in torques(term):
            for m, key in enumerate(keys):
                if key in torque.names:
                    place = self.texts.place(term, part_of(torque, key, keys), node)
                    self.texts.rows.append((first + m, torque.joint, (place,), 1.0))

    def _add_transform(self, one: Asked, node: Float, column: int) -> None:
        assert is_transform(one.term)
        nodes, apart = tangent_nodes(one.term) if one.tangent else (node[None], 1.0)
        self.transforms.terms.append(one.term)
        for torque in torques(one.term):
            places = tuple(self.transforms.place(one.term, torque, each) for each in nodes)
            self.transforms.rows.append((column, torque.joint, places, apart))

    def columns(self, window: Window, base: Float) -> Float:
        """Return the columns (C, J, K) on a window, on which those of the model are `base` (J, K, P)."""
        now, joints = self.now, base.shape[0]
        out = np.zeros((self.count, joints, len(window.motion)))
        fed = fed_back(self.texts.terms, window, now) if self.texts.plan.names.keys() & FEEDBACK else {}
        self.texts.write(fed, window, out)
        if self.transforms.rows:
            linear = carrying(now.model, window.motion, now.linear)
            self.transforms.write(torque_words(now.model, window.motion, linear, now.shape), window, out)
        for own, asked, nodes in self.others:
            found = unfiltered_columns(asked, nodes, window, now)(nodes)[0]  # (A, m, N)
            out[own, list(asked.joints)] = np.swapaxes(found, 0, 1)
        for own in self.together:  # zero, so that what has no value is never chosen
            if not np.isfinite(out[own]).all():
                out[own] = 0.0
        filtered = np.empty((self.count, joints, len(window.kept)))
        for j in range(joints):
            acts = out[:, j].any(axis=1)
            filtered[~acts, j] = 0.0
            filtered[acts, j] = window.smooth_rows(out[acts, j, None], [j], 1)[:, 0]
        numbers = np.moveaxis(base[:, :, self.numbers], 2, 0)
        loads = [one.load(now.model, base, PLACES[len(PLACES) // 2 :][:1]) for one in self.loads]
        return np.concatenate([filtered, numbers, *loads])
