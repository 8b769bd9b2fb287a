"""The standards by which a diagnosis decides, in one record: what each is, and what it prevents.

A decision is a comparison with one of few standards: what chance does, what noise or the filter does, half, most or a
little of something else, so many standard errors. Where two questions are of the same kind they are answered by the
same number, whatever they are about. What a search spends (placebos, splits, rounds) stands below: it decides nothing
but how finely is looked. The documentation's page of thresholds is written from this record. Numerical
steps (of a derivative, of a grid) are not here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from functools import partial
from typing import Any

from exoid.ground.thresholds import Rule


def _rule(group: str, value: Any, prevents: str) -> Any:
    return field(default=value, metadata={"group": group, "prevents": prevents})


_chance = partial(_rule, "against chance")
_parts = partial(_rule, "parts of a whole")
_noise = partial(_rule, "against noise")
_data = partial(_rule, "what recordings must hold")
_effort = partial(_rule, "what a search spends")


@dataclass(frozen=True)
class Rules:
    """The standards of one diagnosis. `Rules()` are those in use; `dataclasses.replace` varies one of them."""

    level: float = _chance(
        0.05,
        "false discovery rate over the catalogue, at every step, and share of the splits of many recordings that may "
        "disagree: entries named by chance",
    )
    strict_level: float = _chance(
        0.01,
        "p-value of what is asked beside others: an accepted term tested anew, the best of a few dozen curves: "
        "superfluous terms",
    )
    clear: float = _chance(
        2.5, "standard errors of losses in blocks by which one is better than another: a choice made by chance"
    )
    tied: float = _chance(1.0, "standard errors within which the plainer is taken: needless numbers")
    robust: float = _chance(
        2.0,
        "deviations beyond which a residual counts linearly, and that a split may move a shape value: bursts outvote "
        "all, and splits that hardly show a shape run off along it",
    )

    negligible: float = _parts(
        2e-3,
        "part that is nothing: of a range beside its bound, of the samples on which a column is not zero, of a torque "
        "that another may miss and still contain it, of the variance that angles alone leave: a lucky burst is an "
        "effect, one at its bound is another effect, a hand is a drive",
    )
    least_share: float = _parts(
        0.01,
        "share of a loss, or of a column that a fit sees, from which it counts: errors of the filter pass for effects",
    )
    worth_telling: float = _parts(
        0.05, "share from which what was not accepted is told as the nearest, or as a difference: chance"
    )
    little: float = _parts(
        0.2,
        "part that is little beside the rest: what some recordings lose beside what others gain, what a split keeps or "
        "shows of a gain, what another reading of a torque or a fit of its own leaves: one file decides for all, "
        "effects are named for a late torque or another machine",
    )
    half: float = _parts(
        0.5,
        "part that the main explanation has: of what the best gains for its rivals, of its own gain for what is "
        "something else beside it, of a torque's variance for a machine that cannot be, of the error for a swaying "
        "base, a soft drive or an early torque, of the splits for those that can tell: the nearest entry stands in "
        "for what the catalogue lacks",
    )
    unexplained_share: float = _parts(
        1 / 3, "share of a torque's variance that the best model leaves: effects named for wrong channels"
    )
    most: float = _parts(
        0.8,
        "part that is nearly all: of the splits for one that agrees, of a curve for the term that it does not replace, "
        "of an error for a torque misread in little motion: a verdict that depends on the split, a true term lost "
        "beside errors of the model",
    )
    practically: float = _parts(
        0.98, "part of the gain with which a simpler rival ties: what linearising loses would decide"
    )

    near_noise: float = _noise(
        3.0,
        "times the floor up to which an error is near it, and of fitted motion for the held-out one: a model is called "
        "adequate beside what is missing, or right for another machine",
    )
    artefact: float = _noise(
        2.0,
        "times what noise of the angles, filter and derivatives, or linearising make by themselves: these pass for "
        "flexible drives",
    )
    angle_noise: float = _noise(
        0.15, "share of noise in the accelerations: inertias pulled to zero are reported with small intervals"
    )
    late_delay: float = _noise(0.08, "delay in s up to which it is an effect: wrong channels called an effect")

    least_periods: float = _data(
        75.0, "periods of the band in fitted motion below which nothing is accepted: what is not there looks real"
    )
    least_strokes: int = _data(
        5, "strokes of a joint in fitted motion below which nothing is accepted there: what came once counts"
    )
    many_recordings: int = _data(
        6, "recordings of which nearly all splits outvote those held out: a few can agree by chance"
    )
    blocks: int = _data(4, "parts of a recording that is alone; with none, nothing would be unseen")
    block_seconds: float = _data(2.0, "blocks in s in which losses are compared, longer than a residual remembers")
    min_shift: float = _data(1.0, "shortest shift of a placebo in s: one that is nearly the candidate")

    most_terms: int = _effort(6, "terms added at most to few joints; a model that needs more has another problem")
    most_per_joint: int = _effort(2, "terms for each joint added at most to many: six joints have more than six")
    most_possible: int = _effort(6, "terms listed as possible at most")
    most_folds: int = _effort(8, "splits at most; more units are held out several at a time, for speed")
    most_splits: int = _effort(100, "splits of the recordings at most; random ones where there are more")
    placebos: int = _effort(1499, "least placebos; no p-value is below one over one more, many entries get more")
    placebo_for: int = _effort(12, "candidates that get placebos, the best ones; the others count with p = 1")
    placebo_nodes: int = _effort(100, "nodes in the search of a placebo; neighbours resemble each other")
    telegraph: float = _effort(3.0, "seconds between changes of sign in the placebo of a constant")
    refinements: int = _effort(3, "rounds of refinement of a shape value: a coarse grid decides nothing")
    refitted: int = _effort(5, "rivals at most that a refit compares, for speed")
    many_numbers: int = _effort(4, "a term with so many numbers is compared with plainer ones in its place")
    rounds: int = _effort(4, "times the search goes on after it took back a proxy")
    knots: int = _effort(12, "spline functions of a curve: fewer miss a bump, more follow noise")
    curve_ridge: float = _effort(3e-2, "relative ridge of a curve: parts that the model nearly contains run wild")
    own_recordings: int = _effort(
        24, "recordings at most of which numbers of their own are asked; beyond, a single one no longer matters"
    )
    whole_seconds: float = _effort(900.0, "seconds that are searched as a whole; beyond, memory runs out")
    few_joints: int = _effort(2, "joints up to which so much is searched; of more, less, for time and memory")
    least_searched: float = _effort(80.0, "seconds searched at least, of however many joints")
    stretch_seconds: float = _effort(30.0, "length of a stretch of a longer recording, s")
    searched_seconds: float = _effort(600.0, "seconds searched of longer recordings; half as much to verify")

    def table(self) -> Iterator[Rule]:
        """Yield every standard in the order of the groups."""
        for item in fields(self):
            yield Rule(item.metadata["group"], item.name, getattr(self, item.name), item.metadata["prevents"])


RULES = Rules()
"""The standards in use."""
