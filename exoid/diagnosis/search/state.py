"""State of a search: models, each with one term more than the one before, and what is ruled out."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.remainder import Remainder
from exoid.diagnosis.evidence.score import Score, above_noise, harmless
from exoid.diagnosis.rules import RULES, Rules


@dataclass(frozen=True, eq=False)
class Extension:
    """A fitted model, and the evidence for the term `added` last (None: the model the search began with).

    `alike` are the candidates that these data cannot distinguish from it, `never` those that no motion can.
    """

    fitted: FittedModel
    added: Score | None = None
    alike: tuple[str, ...] = ()
    never: tuple[str, ...] = ()

    @property
    def score(self) -> Score:
        """The evidence for the term added last, of a model to which one was added."""
        assert self.added is not None
        return self.added

    def unseen_gain(self, later: Extension, rules: Rules = RULES) -> float:
        """Return the fall of the Huber loss on unseen recordings from here to `later`, as a share of it here.

        Without verification recordings it is the loss on the fitted ones.
        """
        scale = self.fitted.unseen_scale
        return 1.0 - later.fitted.unseen_loss(scale, rules) / max(self.fitted.unseen_loss(scale, rules), 1e-300)

    def explained(self, later: Extension, rules: Rules = RULES) -> float:
        """Return by what share of itself the squared error falls at the joints where what `later` adds shows.

        On the motion that a reader is shown; what repeats over many recordings may lose on those held out here.
        """
        before, after, at = self.fitted, later.fitted, list(later.score.candidate.joints)
        share = above_noise(before.evaluation_rms[at], after.evaluation_rms[at])
        fitted = above_noise(before.train_rms[at], after.train_rms[at]) if later.score.repeats(rules) else 0.0
        return max(share, fitted)

    def outvotes(self, later: Extension, rules: Rules = RULES) -> bool:
        """True if what `later` adds repeats over many recordings, and those held out lose little beside what it gains.

        In units of torque: quiet recordings that happen to be held out lose next to nothing.
        """
        if not later.score.repeats(rules):
            return False
        scale = self.fitted.scale
        unseen = self.fitted.unseen_loss(scale, rules) - later.fitted.unseen_loss(scale, rules)
        blocks = self.fitted.block_losses(scale, rules) - later.fitted.block_losses(scale, rules)
        return harmless(rules, np.array([float(blocks.sum()) - unseen, unseen]))


@dataclass(frozen=True, eq=False)
class State:
    """State of a search. Moves return another one.

    `extensions` begin with the model that was given. `banned` candidates turned out to be proxies and are not tried
    again; `dropped` ones became superfluous beside others, `unsteady` ones too few splits support. `left` is what the
    last model leaves, once that is known.
    """

    extensions: tuple[Extension, ...]
    banned: frozenset[str] = frozenset()
    dropped: frozenset[str] = frozenset()
    unsteady: frozenset[str] = frozenset()
    left: Remainder | None = None

    @property
    def last(self) -> Extension:
        """The extension with all accepted terms."""
        return self.extensions[-1]

    @property
    def accepted(self) -> tuple[Score, ...]:
        """The evidence for every accepted term, in the order of acceptance."""
        return tuple(e.added for e in self.extensions if e.added is not None)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the accepted terms."""
        return tuple(score.name for score in self.accepted)

    @property
    def numbers(self) -> int:
        """Number of parameters of all accepted terms."""
        return sum(score.candidate.numbers for score in self.accepted)

    def grown(self, *extensions: Extension) -> State:
        """Return the state with these extensions instead."""
        return replace(self, extensions=extensions)
