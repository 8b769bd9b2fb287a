"""The decision repeated over splits of the recordings, each searched from scratch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from exoid.diagnosis.evidence.score import Agreement, Score
from exoid.diagnosis.evidence.stability import splits_of
from exoid.diagnosis.question import Question
from exoid.diagnosis.results import Possible
from exoid.diagnosis.write_up import estimates_in
from exoid.ground.errors import NotEnoughDataError
from exoid.ground.progress import Progress, silent
from exoid.ground.ties import ascending
from exoid.measurement.recording import Recording
from exoid.symbolic.quantity import Estimate


def from_scratch(
    question: Question,
    recordings: Sequence[Recording],
    verify: Sequence[Recording],
    accepted: Sequence[str],
    tick: Progress,
) -> tuple[dict[str, Agreement], tuple[Possible, ...]]:
    """Search anew in every split; return how often each of the `accepted` was, and what else some splits accept."""
    everything = [*recordings, *verify]
    found: dict[str, list[tuple[Score, dict[str, Estimate]]]] = {}
    lost: dict[str, list[int]] = {}
    count = 0
    splits = splits_of(len(everything), len(verify), question.rules, question.asked.seed)
    for number, held_out in enumerate(splits):
        tick(number / len(splits), f"split {number + 1} of {len(splits)}, from scratch")
        fitted = [r for k, r in enumerate(everything) if k not in held_out]
        try:
            base = question.fitted(fitted, [everything[k] for k in held_out], silent)
            state = question.search(base, silent).found.state
        except NotEnoughDataError:  # these recordings alone do not determine the model: this split cannot tell
            continue
        count += 1
        for score in state.accepted:
            found.setdefault(score.name, []).append((score, estimates_in(state.last.fitted.fit, score.name)))
        for name in set(accepted) - set(state.names):
            lost.setdefault(name, []).extend(held_out)
    agreements = {}
    for name, entries in found.items():
        values = [numbers for _, numbers in entries]
        ranges = {key: (min(v[key].value for v in values), max(v[key].value for v in values)) for key in values[0]}
        against = tuple(dict.fromkeys(lost.get(name, ())))
        agreements[name] = Agreement(len(entries), count, ranges, against, len(splits), len(everything))
    possible = [
        Possible(
            score.candidate.term.effect.id,
            score.candidate.term.joint,
            agreements[name],
            {
                k: replace(e, low=agreements[name].ranges[k][0], high=agreements[name].ranges[k][1])
                for k, e in own.items()
            },
            score.share,
            f"accepted in {len(entries)} of {count} splits of the recordings, each searched from scratch",
        )
        for name, entries in found.items()
        for score, own in entries[:1]
        if name not in accepted
    ]
    never = {name: Agreement(0, count, {}, tuple(dict.fromkeys(lost[name]))) for name in accepted if name not in found}
    return agreements | never, tuple(ascending(possible, lambda p: -(p.agreement.share or 0.0), 1.0))
