"""Figures of the models on the way to an answer, so that a number is the same wherever the page shows it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from exoid.diagnosis.report.sections.verdict import term

if TYPE_CHECKING:
    from exoid.apps.page.workspace import Names, Workspace
    from exoid.diagnosis.evidence.fitted import FittedModel
    from exoid.diagnosis.results import Diagnosis


def found(workspace: Workspace, names: Names) -> Diagnosis | None:
    """Return the answer that came to exactly these effects, in this order; None where none did."""
    answers = (workspace.diagnoses.get(frozenset(names)), workspace.judging.answer(workspace.session))
    ends = ((item, [term.name for term in item.model.terms][-len(names) :]) for item in answers if item is not None)
    return next((entry for entry, end in ends if end == list(names)), None)


def told(workspace: Workspace, names: Names) -> dict[str, Any] | None:
    """Return the step of an answer (as JSON) at which the model has these effects, of the answer that ends there where
    there is one; None where no answer came by it.
    """
    wanted = frozenset(names)
    answers = [*workspace.verdicts.items()]
    judged = workspace.judging.told(workspace.session)
    if judged is not None:
        answers.append((frozenset(map(term, judged["accepted"])), judged))
    for end, answer in sorted(answers, key=lambda pair: pair[0] != wanted):
        accepted = [term(effect) for effect in answer["accepted"]]
        given = end - set(accepted)
        first, *steps = answer["steps"]
        # Before the effects comes what belongs to recordings: the model as given is told without it.
        for count, step in enumerate((first, *steps[len(steps) - len(accepted) :])):
            if given | set(accepted[:count]) == wanted:
                return dict(step)
    return None


def error(workspace: Workspace, names: Names) -> list[float] | None:
    """Return the error (J,) N·m with these effects: as an answer says it, fitted, foreseen by the ranking, or None."""
    said = told(workspace, names)
    if said is not None:
        return list(said["verify_rms"] or said["train_rms"])
    session = workspace.opened()
    now = session.known(names)
    if now is not None:
        return [float(x) for x in now.evaluation_rms]
    foreseen = trial(workspace, names)
    before = None if foreseen is None else error(workspace, names[:-1])
    if foreseen is None or before is None:
        return None
    fall = foreseen.evaluation_rms / session.ranking(names[:-1]).fitted.evaluation_rms  # of the samples of the ranking
    return [item * float(ratio) for item, ratio in zip(before, fall, strict=True)]


def trial(workspace: Workspace, names: Names) -> FittedModel | None:
    """Return the ranking's forecast of the last of these effects; None where it has not weighed it."""
    session = workspace.session
    if session is None or not names or session.known(names[:-1]) is None:
        return None
    return session.ranking(names[:-1]).trial(names[-1])
