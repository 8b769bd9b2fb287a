"""Choice of the candidate to add: the significant ones are compared after a refit of everything.

What noise of the angles makes is no effect.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from statistics import NormalDist

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate
from exoid.diagnosis.evidence.columns import Columns, stacked
from exoid.diagnosis.evidence.fitted import lag
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.look_alikes import leaves_joints, look_alikes, refine
from exoid.diagnosis.evidence.score import Score
from exoid.diagnosis.evidence.simulated import evidence_on, needed_beyond_noise, noise_share
from exoid.diagnosis.hypotheses.readings import is_reading, reading_objection
from exoid.diagnosis.search.containing import EXACT, contains, is_within
from exoid.diagnosis.search.context import FEW, LEADING, SearchContext
from exoid.diagnosis.search.doubt import on_bound, undetermined
from exoid.diagnosis.search.state import Extension
from exoid.ground.ties import ascending, least_of

Refined = tuple[Score, list[Columns]]
"""A score at refined shape values, and its columns there."""
OVER_NOISE = 2.0
"""Times the loss that noise makes, the most that a candidate may gain from it: all of it, and as much again where a fit
is worse."""


def choose(
    context: SearchContext, extension: Extension, evidence: Evidence, scores: Sequence[Score], banned: frozenset[str]
) -> tuple[Extension | None, frozenset[str]]:
    """Return the model with the best candidate that helps after a refit, or None, and who led in vain."""
    failed: frozenset[str] = frozenset()
    known: dict[str, Refined] = {}
    banned = banned | plainer_together(context, extension, evidence, scores)
    while good := [s for s in scores if s.significant and s.name not in banned | failed]:
        # That something is missing is certain, the question is what; whatever is chosen must beat its own placebos too.
        # What does not may resemble itself when it is shifted, as what hardly varies does: it stays a look-alike.
        rivals = [s for s in scores if s.eligible and s.name not in banned and _is_compared(s, good[0])]
        wanted = [good[0], *(s for s in rivals if s.share >= context.rules.half * good[0].share)]
        near, alike = shortlist(context, extension, evidence, wanted, known)
        if failed.issuperset(s.name for s in near):  # what comes near them does not come near what is left
            rest = [s for s in wanted if s.name not in failed]
            near, alike = shortlist(context, extension, evidence, rest, known)
        found = refitted(context, extension, evidence, near, alike, failed)
        chosen = next(s for s in near if s.name not in failed) if found is None else found.score
        if good[0].candidate.reads_torque and chosen.name != good[0].name:
            chosen = good[0]  # effects are compared among themselves
        elif found is not None and (chosen.significant or context.sure(context.tested(extension, chosen))):
            return found, failed
        failed |= {chosen.name}
    return None, failed


def _is_compared(rival: Score, best: Score) -> bool:
    """True if a rival is compared with the best candidate: a torque read otherwise with one, or with an effect that
    changes the same torque as a whole, too; it takes no place from other effects.
    """
    alike = best.candidate.change and rival.candidate.joints == best.candidate.joints
    return rival is not best and (alike or not rival.candidate.reads_torque)


def plainer_together(
    context: SearchContext, extension: Extension, evidence: Evidence, scores: Sequence[Score]
) -> frozenset[str]:
    """Names of the candidates of several numbers on several joints whose gain is nearly all that of plain ones, of one
    number at each of these joints: those come first, and what more there is in the others is weighed beside them.
    """
    sure, found = [s for s in scores if s.significant], set()
    plain = {s.candidate.joints: s for s in reversed(sure) if s.candidate.numbers == 1}  # the best at each joint
    for score in sure:
        joints = score.candidate.joints
        parts = [plain[joint,] for joint in joints if (joint,) in plain]
        if len(joints) < 2 or len(parts) < len(joints) or len(parts) > score.candidate.numbers:
            continue
        columns = [(context.library.columns(s.candidate, extension.fitted), s.nodes) for s in parts]
        nodes = [[c.node(int(n)) for c, n in zip(each, chosen, strict=True)] for each, chosen in columns]
        together = evidence.gain(evidence.plain(stacked(nodes, len(evidence.sigma))))
        if float(together.total[0]) >= context.rules.most * score.share * float(evidence.fold_losses.sum()):
            found.add(score.name)
    return frozenset(found)


def shortlist(
    context: SearchContext,
    extension: Extension,
    evidence: Evidence,
    scores: Sequence[Score],
    known: dict[str, Refined],
) -> tuple[list[Score], Collection[str]]:
    """Refine the shape values of `scores`; return those worth a refit, best first, and the look-alikes of the best.

    `known` are those refined before, and are added to.
    """
    known |= {s.name: refine(evidence, s, extension.fitted) for s in scores if s.name not in known}
    refined = [known[s.name] for s in scores]
    # Of two with the same torque the plainer comes first.
    refined = ascending(sorted(refined, key=lambda pair: _plainness(pair[0])), lambda pair: -pair[0].share, 1.0)
    alike = look_alikes(evidence, refined[0], refined[1:])
    best = refined[0][0].share
    least = min(best, context.rules.most * best)
    return [p[0] for p in refined if p[0].name in alike or p[0].share >= least], alike


def refitted(
    context: SearchContext,
    extension: Extension,
    evidence: Evidence,
    rivals: Sequence[Score],
    alike: Collection[str],
    failed: Collection[str] = (),
) -> Extension | None:
    """Return the extension with the best of `rivals` (best first), each compared after a refit of everything.

    Linearised and on a grid they were too close to call; those in `alike` stay look-alikes unless a refit
    distinguishes them. What has `failed` is compared, and not chosen. None where none of them helps unseen recordings,
    or where what they gain is made by the noise of the angles, or something speaks against each (`doubt`).
    """
    rules, scale = context.rules, extension.fitted.scale
    most = rules.refitted if len(extension.fitted.model.terms) <= FEW else LEADING
    able = [s for s in rivals if s.name not in failed][:most]
    tried, elsewhere = _refits(context, extension, [*able, *[s for s in rivals if s.name in failed][:most]])
    by_joint = {score.name: found.fitted.joint_losses(scale, rules) for score, found in tried}
    losses = {name: loss.sum(axis=0) for name, loss in by_joint.items()}
    tried = [p for p in tried if p[0].name not in failed]
    if not tried:
        return None
    least = least_of(losses.values(), np.sum)
    behind_best = {name: lag(loss, least) for name, loss in losses.items()}
    leader = least_of(tried, lambda p: losses[p[0].name].sum())[0].name
    own_loss = extension.fitted.joint_losses(scale, rules)
    gains = {name: own_loss.sum() - loss.sum() for name, loss in losses.items()}
    # A torque that is read otherwise has to explain more than an effect by a part worth telling.
    least_gain = (1.0 - rules.worth_telling) * gains[leader] if is_reading(leader) else np.inf

    def is_tied(name: str) -> bool:
        effect = gains[name] >= least_gain and not is_reading(name)
        return bool(effect or lag(losses[name], losses[leader]) < rules.tied)

    score, found = min(
        ((s, f) for s, f in tried if is_tied(s.name)),
        key=lambda p: (is_reading(p[0].name), *_plainness(p[0]), p[0].candidate.tangent),
    )

    def no_more(rival: Score, than: Score) -> bool:
        """True if a rival can be the plainer `than`, and what else it can be explains no more than by chance."""
        known = rival.name in losses and than.name in losses
        chance = NormalDist().inv_cdf(1.0 - rules.level)
        tied = not known or lag(losses[than.name], losses[rival.name]) < chance
        return tied and contains(context, extension, evidence, rival.candidate, than)

    plainer = [p for p in tried if _bends(score, p[0]) and no_more(score, p[0])]
    score, found = min(plainer, key=lambda p: _plainness(p[0]), default=(score, found))
    # Of what no motion here distinguishes the plainest is told, whichever the last digits of a refit prefer.
    score, found = min([(score, found), *(p for p in tried if _same(p[0], score))], key=lambda p: _plainness(p[0]))
    if not outlives_noise(context, extension, evidence, score):
        return None
    wanted = {*behind_best, *alike} - elsewhere
    others = [s for s in rivals if s is not score and behind_best.get(s.name, 0.0) < rules.clear and s.name in wanted]
    own = by_joint[score.name]
    others = [s for s in others if not leaves_joints(by_joint.get(s.name, own), own, own_loss, score.candidate, rules)]
    # A backlash without a gap is a spring, and a drift that began long ago an offset: what needs a number besides and
    # explains no more is no rival. Nor is what is the same with more numbers; with as many it is a look-alike.
    behind = {name: lag(loss, losses[score.name]) for name, loss in losses.items()}
    more = {s.name for s in others if s.candidate.numbers > score.candidate.numbers}
    others = [
        s
        for s in others
        if not (s.name in more and (_same(s, score) or behind.get(s.name, 0.0) >= rules.tied))
        and not (_bends(s, score) and no_more(s, score))
    ]
    never = [s.name for s in others if _same(s, score)]
    for candidate in _twins(context, extension, evidence, score, {score.name, *(s.name for s in others)}):
        twin = context.weighed(extension, evidence, candidate)
        lost = context.with_term(extension, twin).fitted.block_losses(scale, rules) if candidate.tangent else least
        if not candidate.tangent or lag(lost, losses[score.name]) < rules.clear:
            never.append(twin.name)
    alike = dict.fromkeys([*(s.name for s in others), *never])
    return replace(found, alike=tuple(alike), never=tuple(never))


def _refits(
    context: SearchContext, extension: Extension, rivals: Sequence[Score]
) -> tuple[list[tuple[Score, Extension]], set[str]]:
    """Return the rivals that help after a refit and are not in doubt, and the names of those that are no look-alikes.

    What fits only with its shape on a bound is something else; a number that is a size alone may be merely large. What
    the interval of every number says may be absent explains nothing in its place, nor does a reading that is refused.
    """
    rules = context.rules
    refits = [(score, context.with_term(extension, score)) for score in rivals]
    elsewhere = {
        score.name
        for score, found in refits
        if (not score.candidate.tangent and on_bound(found.fitted, score.name, rules))
        or undetermined(found.fitted, score.name)
        or reading_objection(found.fitted.fit, score.name, extension.explained(found, rules), rules)
    }
    helping = [
        (score, found)
        for score, found in refits
        if not context.doubt(extension, found)  # first: what speaks against it is told
        and (extension.unseen_gain(found, rules) >= rules.least_share or extension.outvotes(found, rules))
    ]
    return helping, elsewhere


def _twins(
    context: SearchContext, extension: Extension, evidence: Evidence, score: Score, known: Collection[str]
) -> list[Candidate]:
    """Return the changes of the mechanism besides those `known` that make exactly the torque of `score`, on any motion.

    A joint's wrong zero, weighed by its slope or refitted to the end of its range, may be refused where the mass that
    it takes off the axis is accepted: what it refuses is its size, and only where that costs something. Of a force at
    the cuff of a single joint all numbers but one show on no motion.
    """
    present = {*known, *extension.fitted.model.effects}
    out = []
    for candidate in context.library.candidates:
        if candidate.term.effect.derive is None or candidate.name in present:
            continue
        same = contains(context, extension, evidence, candidate, score, EXACT)
        fewer = candidate.numbers <= score.candidate.numbers
        if same and (fewer or is_within(context, extension, evidence, candidate, score)):
            out.append(candidate)
    return out


def outlives_noise(context: SearchContext, extension: Extension, evidence: Evidence, score: Score) -> bool:
    """True if a candidate gains clearly more than on recordings that the present model made itself, noise added.

    Where all that noise makes is far less than the candidate gains, none are made: they would take two fits.
    """
    beyond = score.share - context.rules.least_share
    if context.rules.artefact * OVER_NOISE * noise_share(evidence, context.prepared.noise_floor) < beyond:
        return True
    simulated = evidence_on(context.simulated(extension), evidence)
    needed = needed_beyond_noise(score.candidate, score.shape, evidence, simulated)
    return score.share - needed >= context.rules.least_share


def _plainness(score: Score) -> tuple[int, int]:
    """Count of a candidate's numbers, and of its shape parameters: the fewer, the plainer."""
    return score.candidate.numbers, len(score.candidate.term.effect.shape)


def _bends(rival: Score, plain: Score) -> bool:
    """True if a rival has more numbers, or as many of which a shape bends its torque (a tangent is its only number)."""
    bent = bool(rival.candidate.term.effect.coefficients) and _plainness(rival) > _plainness(plain)
    return bent or rival.candidate.numbers > plain.candidate.numbers


def _same(one: Score, other: Score) -> bool:
    """True if two candidates gain the same to rounding, on every held-out recording: no motion here differs."""
    return bool(np.allclose(one.folds, other.folds, rtol=1e-4, atol=1e-6))
