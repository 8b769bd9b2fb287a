"""The answer beside numbers that belong to recordings, a zero or a load of their own: a rival of the answer without."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from exoid.diagnosis.evidence.fitted import FittedModel, fitted_on
from exoid.diagnosis.machine_answer import Asking, answer_of_machine
from exoid.diagnosis.own_numbers.compared import explained_by, predicts_better
from exoid.diagnosis.own_numbers.found import belonging_to
from exoid.diagnosis.own_numbers.numbers import OwnNumbers
from exoid.diagnosis.question import Question
from exoid.diagnosis.results import Diagnosis
from exoid.diagnosis.rules import Rules
from exoid.diagnosis.write_up import with_own
from exoid.ground.ties import ascending
from exoid.measurement.recording import Recording
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import Prepared

ROUNDS = 2
"""Times that what belongs to recordings is looked for beside what was found with it."""
NEAREST = 3
"""Entries of the catalogue, those that explain most alone, that are compared with what belongs to recordings."""
OTHERS_TOO = " So many differences at once may also be those of another machine."
MORE_TOO = " More than noise is left beside that: such numbers may also stand for what the model lacks."


def answer_beside_recordings(
    asking: Asking, base: FittedModel, answer: Diagnosis, recordings: Sequence[Recording], verify: Sequence[Recording]
) -> Diagnosis | None:
    """Return an answer beside what belongs to recordings; None where that does not predict clearly better."""
    question, given, rules = asking.question, base.prepared, asking.question.rules
    whole = fitted_on(answer.fit, given)
    # An effect that was found and of which each recording has a number, as a delay, may be what belongs to some.
    own_too = [effect.name for effect in answer.accepted if answer.model.find_effect(effect.effect).has_own_numbers]
    last = fitted_on(identify(answer.model.without(*own_too), given.train, optimisers=()), given) if own_too else whole
    found = _belonging_beside(last, rules)
    if found is None:
        return None
    machines = [(explained_by(last, machine), machine) for machine in _plain_models(question, answer, last)]

    def is_worth(own: OwnNumbers, beside: FittedModel) -> bool:
        """True if they predict clearly better, beside an effect of the machine that explains nearly as much, too."""
        if own_too and explained_by(last, beside) < rules.practically * explained_by(last, whole):
            return False
        least = rules.most * explained_by(last, beside)
        return predicts_better(last, beside, rules, own.cuts) and all(
            share < least or predicts_better(machine, own.beside(machine.model, given), rules, own.cuts)
            for share, machine in machines
        )

    # What belongs to recordings beside the model as given may be what an effect took the place of, or its trace.
    alone = found if last.fit is base.fit else belonging_to(base, rules)
    asked = [own for own in dict.fromkeys((alone, found)) if own is not None]
    own = next((own for own in asked if is_worth(own, own.beside(last.model, given))), None)
    if own is None:
        return None
    rival, explained, own = _with_own(asking, given, own, recordings, verify)
    told = own.without([entry.recording for entry in rival.left_out])
    main = explained_by(last, explained) >= rules.half
    if not told or not _may_replace(answer, rival, own, main=main) or not is_worth(own, explained):
        return None
    caution = OTHERS_TOO if own.as_many_as(rules.half) else ""
    caution += MORE_TOO if rival.error is not None else ""
    return with_own(rival, told, base, caution)


def _may_replace(answer: Diagnosis, rival: Diagnosis, own: OwnNumbers, *, main: bool) -> bool:
    """True if a `rival` beside numbers of recordings may stand in place of an answer without; where more than noise is
    left beside these, only of one that leaves more, too, and with its effects unless they are the `main` explanation.
    """
    if rival.verdict == "check_channels" or rival.outside:
        return False
    if _leaves_more(rival):
        kept = {effect.name for effect in answer.accepted} <= {effect.name for effect in rival.accepted}
        return _leaves_more(answer) and (main or kept)
    # What is another machine's is explained by as many numbers as a machine has.
    return answer.error is not None or not own.of_a_machine(answer.left_out)


def _leaves_more(answer: Diagnosis) -> bool:
    """True if a machine's answer leaves more than noise, or what follows a variable."""
    return not answer.outside and (answer.error is not None or answer.verdict == "unexplained")


def _with_own(
    asking: Asking, given: Prepared, own: OwnNumbers, recordings: Sequence[Recording], verify: Sequence[Recording]
) -> tuple[Diagnosis, FittedModel, OwnNumbers]:
    """Return the answer beside numbers that belong to recordings, its model there, and these as they are beside it."""
    kept = None
    for _ in range(ROUNDS):
        again, without = replace(asking.question, own=own), own.applied(given)
        fitted = again.fitted(recordings, verify, asking.tick, without)
        rival = answer_of_machine(replace(asking, question=again), fitted, recordings, verify)
        if kept is not None and kept[0].verdict == "adequate" and rival.verdict != "adequate":
            break
        kept = rival, fitted_on(rival.fit, without), own
        own = _belonging_beside(fitted_on(rival.fit, given), again.rules) or own
        if own.agrees(kept[2]) and not own.needless:
            return *kept[:2], own
    assert kept is not None
    return kept


def _belonging_beside(last: FittedModel, rules: Rules) -> OwnNumbers | None:
    """Numbers that belong to recordings beside a model that was found, without its effects that do no more than these,
    which stay `needless`.
    """
    own = belonging_to(last, rules)
    if own is None or not own.needless:
        return own
    model, prepared = last.model.without(*own.needless), last.prepared
    without = belonging_to(fitted_on(identify(model, prepared.train, optimisers=()), prepared), rules)
    return without and replace(without, needless=own.needless)


def _plain_models(question: Question, answer: Diagnosis, last: FittedModel) -> Iterator[FittedModel]:
    """Yield the `last` model, that of an answer, then with each of the entries that come nearest to what it leaves,
    fitted to all recordings: a number of a recording's own has seen a part of that recording, too, held out or not.
    What has such numbers itself, as a drift that began at another time in each, is no plainer.
    """
    found, given, least = last.model, last.prepared, question.rules.worth_telling
    names = [term.name for term in found.terms]
    own = {effect.id: effect for effect in question.entries(given)}  # the model alone does not know these
    near = [
        (suspect, own.get(suspect.effect) or found.find_effect(suspect.effect))
        for suspect in answer.suspects
        if suspect.name not in names and suspect.explained_share >= least
    ]
    plain = [pair for pair in near if not pair[1].has_own_numbers]
    nearest = ascending(plain, lambda pair: -pair[0].explained_share, 1.0)[:NEAREST]
    for model in (found, *(found.with_effect(effect, suspect.joint) for suspect, effect in nearest)):
        yield fitted_on(identify(model, given.all, optimisers=()), given)
