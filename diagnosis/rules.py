"""Every threshold that decides in a diagnosis, in one record: what it is, and what it prevents.

The table of docs/statistics.md and that of the report are written from this record. Numerical steps (of a derivative,
of a grid) are not here: they decide nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from typing import Any

from exoid.ground.thresholds import Rule


def _rule(group: str, value: Any, prevents: str) -> Any:
    return field(default=value, metadata={"group": group, "prevents": prevents})


EVIDENCE = "evidence on unseen motion"
ACCEPTANCE = "from candidate to suspect"
STABILITY = "stability over splits of the recordings"
PLACEBO = "placebos"
ALIKE = "look-alikes"
SEARCH = "the search"
REMAINDER = "what is left"
CHANNELS = "channels and error"
CONSISTENCY = "consistency between recordings"
LENGTH = "long recordings"


@dataclass(frozen=True)
class Rules:
    """The thresholds of one diagnosis. `Rules()` are those in use; `dataclasses.replace` varies one of them."""

    blocks: int = _rule(EVIDENCE, 4, "parts of a recording that is alone; with none, nothing would be unseen")
    most_folds: int = _rule(EVIDENCE, 8, "splits at most; more units are held out several at a time, for speed")
    robust: float = _rule(
        EVIDENCE,
        2.0,
        "robust deviations beyond which a residual counts linearly: bursts and reversals would outvote all",
    )
    least_scale: float = _rule(
        EVIDENCE, 0.3, "scale of a column for the ridge, of the largest: a column hardly seen would escape the ridge"
    )
    hold: float = _rule(
        EVIDENCE, 2.0, "deviations a split may move a shape value: a split that hardly shows it would run off along it"
    )

    least_share: float = _rule(
        ACCEPTANCE, 0.01, "least share of the weighted unseen loss: errors of the filter pass for small effects below"
    )
    harmless: float = _rule(
        ACCEPTANCE,
        0.3,
        "part of what some recordings gain that others may lose, where splits cannot tell: one that helps one file",
    )
    false_discovery_rate: float = _rule(ACCEPTANCE, 0.05, "entries named by chance, over the catalogue at every step")
    nearest: float = _rule(
        ACCEPTANCE, 0.05, "share from which an entry that was not accepted is named as the nearest: chance"
    )
    leading: float = _rule(
        ACCEPTANCE,
        0.5,
        "part of what is more than noise that a torque before its motion, or a base that sways with its own phase in "
        "every recording, must explain: what swings behind a soft drive is called early",
    )
    beyond_standstill: float = _rule(
        ACCEPTANCE,
        0.2,
        "part of what a term gains that must be further than 0.05 s from standstill, where it follows the model's own "
        "torque: friction at low speed is called an elastic drive",
    )
    at_bound: float = _rule(
        ACCEPTANCE,
        1e-3,
        "distance from a bound, of the range, at which a parameter says it is another effect",
    )
    beyond_null: float = _rule(
        ACCEPTANCE,
        2.0,
        "times what a term gains on recordings that the model without it made itself: noise of the angles named",
    )
    least_novelty: float = _rule(ACCEPTANCE, 1e-6, "share of a column new to the model: the rest its parameters absorb")
    least_active: float = _rule(ACCEPTANCE, 0.003, "share of samples on which a column is not zero: a lucky burst")
    least_seen: float = _rule(
        ACCEPTANCE,
        0.01,
        "share of a column on fitted samples: a peak inside the sticking speeds is credited with its edge",
    )
    least_seconds: float = _rule(
        ACCEPTANCE, 15.0, "seconds of fitted motion below which nothing is accepted: what is not there looks real"
    )
    tangent_reach: float = _rule(
        ACCEPTANCE, 2.0, "times a bound that a tangent may reach: of a large delay it shows only direction and size"
    )

    most_splits: int = _rule(STABILITY, 100, "splits of the recordings at most; random ones where there are more")
    least_possible: float = _rule(STABILITY, 0.2, "share of splits from which a term is listed as possible: noise")
    most_possible: int = _rule(STABILITY, 6, "terms listed as possible at most")
    least_splits: float = _rule(STABILITY, 0.8, "share of splits that must agree: a verdict that depends on the split")
    nearly_all: float = _rule(
        STABILITY,
        0.9,
        "share of the splits of many recordings that outvotes quiet ones held out: they lose next to nothing and veto",
    )
    many_recordings: int = _rule(
        STABILITY, 6, "recordings of which nearly all splits outvote those held out: a few can agree by chance"
    )
    split_keeps: float = _rule(
        STABILITY, 0.3, "part of the expected gain that a split must show to agree: terms that only absorb model error"
    )
    split_shows: float = _rule(
        STABILITY,
        0.1,
        "part of the average information with which a split can tell: a stop met in few files is lost",
    )

    placebos: int = _rule(PLACEBO, 1499, "least placebos; no p-value is below one over one more, many entries get more")
    placebo_for: int = _rule(PLACEBO, 12, "candidates that get placebos, the best ones; the others count with p = 1")
    placebo_nodes: int = _rule(PLACEBO, 100, "nodes in the search of a placebo; neighbours resemble each other")
    telegraph: float = _rule(PLACEBO, 3.0, "seconds between changes of sign in the placebo of a constant")
    min_shift: float = _rule(PLACEBO, 1.0, "shortest shift in s: a placebo that is nearly the candidate")
    repeats: float = _rule(
        PLACEBO,
        0.5,
        "autocorrelation of the motion above which a shift is not used: a periodic motion shifted by a period",
    )

    block_seconds: float = _rule(
        ALIKE, 2.0, "blocks in s in which losses are compared, longer than a residual remembers"
    )
    clear: float = _rule(ALIKE, 2.5, "standard errors by which the better candidate leads: a choice made by chance")
    tied: float = _rule(ALIKE, 1.0, "standard errors within which the simpler candidate is taken: needless numbers")
    practically: float = _rule(
        ALIKE, 0.98, "part of the gain with which a simpler rival ties: what linearising loses would decide"
    )
    close: float = _rule(ALIKE, 0.5, "part of the best gain from which a candidate is compared at all, for speed")
    another: float = _rule(ALIKE, 0.5, "part of its gain kept beside the best: another effect called a look-alike")
    contained: float = _rule(
        ALIKE,
        2e-3,
        "share of a plain effect's torque that another, at a limit of its shape, may miss and still contain it: an "
        "offset would be ambiguous beside a drift that began long ago",
    )
    refinements: int = _rule(ALIKE, 3, "rounds of refinement of a shape value: a coarse grid decides nothing")

    most_terms: int = _rule(SEARCH, 6, "terms added at most; a model that needs more has another problem")
    near: float = _rule(
        SEARCH, 0.8, "part of the best gain from which a candidate is refitted: a grid missed its place"
    )
    refitted: int = _rule(SEARCH, 5, "rivals at most that a refit compares, for speed")
    sure: float = _rule(SEARCH, 0.01, "p-value an accepted term keeps beside the others: a superfluous term")
    many_numbers: int = _rule(SEARCH, 4, "a term with so many numbers is compared with plainer ones in its place")
    rounds: int = _rule(SEARCH, 4, "times the search goes on after it took back a proxy")

    knots: int = _rule(REMAINDER, 12, "spline functions of a curve: fewer miss a bump, more follow noise")
    curve_ridge: float = _rule(
        REMAINDER, 3e-2, "relative ridge of a curve: parts that the model nearly contains run wild"
    )
    curve_share: float = _rule(REMAINDER, 0.02, "least share of the unseen loss that a curve explains to be reported")
    curve_level: float = _rule(REMAINDER, 0.005, "p-value of a curve; a few dozen are tried")
    own_handicap: float = _rule(REMAINDER, 0.85, "factor on the share of a curve per recording: freedom must be earned")
    beaten: float = _rule(REMAINDER, 3.0, "standard errors by which a curve leads to reveal a proxy: a true term lost")
    spared: float = _rule(
        REMAINDER, 0.85, "part of what a curve explains with which a term stays: a true one beside errors of the model"
    )
    superseded: float = _rule(REMAINDER, 0.5, "part of its gain a proxy adds to the curve that replaces it")

    near_noise: float = _rule(
        CHANNELS, 3.0, "times the floor up to which an error is near the noise; beyond, a model is not called adequate"
    )
    unexplained_share: float = _rule(
        CHANNELS, 1 / 3, "share of a torque's variance that the best model leaves: effects named for wrong channels"
    )
    base_share: float = _rule(
        CHANNELS, 0.6, "the same of a rigid leg that could not exist: effects that make up for a wrong sign or zero"
    )
    late_least: float = _rule(CHANNELS, 0.003, "share of a torque's variance left from which its timing is questioned")
    late_gain: float = _rule(
        CHANNELS, 0.2, "part of the squared error left at another timing: a late torque passes for friction"
    )
    late_delay: float = _rule(CHANNELS, 0.08, "delay in s up to which it is an effect: wrong channels called an effect")
    by_angle: float = _rule(
        CHANNELS,
        1e-3,
        "share of the torques' variance that the angles alone leave: effects named where a hand moves the machine",
    )
    filtered: float = _rule(
        CHANNELS,
        0.9,
        "part of what delays leave that a filter on the torque leaves, from which it is the filter: filters are called "
        "delays",
    )
    as_late: float = _rule(
        CHANNELS, 1.25, "the same up to which either may be the case: a filter is ruled out by next to nothing"
    )
    angle_noise: float = _rule(
        CHANNELS, 0.15, "share of noise in the accelerations: inertias pulled to zero are reported with small intervals"
    )
    another_machine: float = _rule(
        CHANNELS, 5.0, "times the fitted error that the held-out one is: a model called right for another machine"
    )
    own_machine: float = _rule(
        CHANNELS,
        0.25,
        "part of the held-out squared error left by a fit of its own: an error of the model called a change",
    )
    soft_asked: float = _rule(
        CHANNELS, 1.5, "times the noise from which it is asked whether a drive is too soft for its encoder: noise"
    )
    soft_left: float = _rule(
        CHANNELS,
        0.4,
        "part of the squared error beyond the noise that one such drive leaves of what all accepted effects leave, of "
        "fitted and of unseen motion each: effects named for it",
    )
    soft_beside: float = _rule(
        CHANNELS, 0.9, "the same where the drive is among several accepted: the others make up for its approximation"
    )
    soft_plain: float = _rule(
        CHANNELS,
        0.2,
        "part of the squared error beyond the noise that such a drive leaves of what its entry leaves, at which "
        "nothing else is looked for: minutes of search for what is not accepted",
    )
    filter_error: float = _rule(
        CHANNELS, 2.0, "times the error of filter and derivatives: that error passes for a flexible drive"
    )

    differing_share: float = _rule(CONSISTENCY, 0.05, "share of a recording's error that a difference explains")
    differing_change: float = _rule(CONSISTENCY, 0.25, "relative change of an effect's parameter that is named")
    differing_new: float = _rule(CONSISTENCY, 1e-3, "share of a column of one recording that nothing else takes over")
    differing_named: int = _rule(CONSISTENCY, 8, "differences named at most")
    differing_recordings: int = _rule(CONSISTENCY, 24, "recordings at most; beyond, a single one no longer matters")

    whole_seconds: float = _rule(LENGTH, 900.0, "seconds that are searched as a whole; beyond, memory runs out")
    stretch_seconds: float = _rule(LENGTH, 30.0, "length of a stretch of a longer recording, s")
    searched_seconds: float = _rule(LENGTH, 600.0, "seconds searched of longer recordings; half as much to verify")

    def table(self) -> Iterator[Rule]:
        """Yield every threshold in the order of the groups."""
        for one in fields(self):
            yield Rule(one.metadata["group"], one.name, getattr(self, one.name), one.metadata["prevents"])


RULES = Rules()
"""The thresholds in use."""
