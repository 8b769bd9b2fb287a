"""Numbers that belong to recordings: told with their intervals, and taken out of recordings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from exoid.diagnosis.evidence.apart import Apart
from exoid.diagnosis.evidence.fitted import FittedModel, refitted
from exoid.diagnosis.evidence.gain import pooled_scale
from exoid.diagnosis.hypotheses.recordings import OTHERS, Claim, Node, Seen, sentence_on
from exoid.diagnosis.own_numbers.fits import Fits, seen_before_filter
from exoid.diagnosis.own_numbers.state import Claimed, Cuts, Part, Span, State, grouped, of_part
from exoid.diagnosis.rules import Rules
from exoid.ground.minimum import minimum
from exoid.ground.plain import AsJson
from exoid.ground.ties import least_of
from exoid.measurement.signals.conditioning import response_seconds
from exoid.optimisation.linear.loss import huber_terms
from exoid.optimisation.linear.uncertainty import covariance, critical_value
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.optimisation.preparation.prepare import Prepared
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate
from exoid.symbolic.wording import called, number_of

FEW, LIKE = 1 / 3, 0.1
"""Part of the recordings that may differ from the others where these are told together, and of the largest difference
that these may have.
"""
TIME = 1e-3
"""Part of the time between kept samples to which the moment of a change is found."""


@dataclass(frozen=True, eq=False)
class Belonging(AsJson):
    """Numbers that belong to recordings: `values` {recording: its own} in `unit`, at a joint or link, as a `sentence`.

    Those that are not named are as usual. `place` is where a load is, m; None where it has none or nobody can tell.
    `spans` {recording: (from, until)} in s are those of recordings of which it holds in one part only; `claim` is the
    key of what is claimed, `tell` makes the sentence of such values.
    """

    what: str
    joint: str | None
    unit: str
    values: Mapping[str, Estimate]
    sentence: str
    place: Estimate | None
    spans: Mapping[str, Span]
    claim: tuple[Any, ...]
    tell: Callable[[Mapping[str, Estimate]], str] = field(repr=False)

    def _json(self) -> dict[str, Any]:
        values = {name: {"value": e.value, "low": e.low, "high": e.high} for name, e in self.values.items()}
        out: dict[str, Any] = {
            "what": self.what, "joint": self.joint, "unit": self.unit, "values": values, "sentence": self.sentence,
        }  # fmt: skip
        if self.place is not None:
            out["place"] = self.place
        if self.spans:
            out["spans"] = {name: {"from": start, "until": stop} for name, (start, stop) in self.spans.items()}
        return out


@dataclass(frozen=True, eq=False)
class OwnNumbers:
    """Numbers that belong to recordings beside the model `now`: the claims that are `held` of `parts` of them, their
    `numbers` (C,) with the half-`widths` (C,) of their intervals, and for each part those (2, C) by which its two
    halves are judged; statements `of_each` claim. Factors are those of the model's torque at its `linear` numbers (P,).
    `needless` are terms of the model that do no more than what each recording has.
    """

    now: FittedModel
    linear: Float
    parts: tuple[Part, ...]
    held: State
    numbers: Float
    widths: Float
    judged: Float
    needless: tuple[str, ...] = ()
    of_each: tuple[tuple[Belonging, ...], ...] = ()

    @property
    def told(self) -> tuple[Belonging, ...]:
        """All statements."""
        return tuple(statement for some in self.of_each for statement in some)

    @property
    def cuts(self) -> Cuts:
        """Samples at which recordings are cut."""
        return {part.recording: part.start for part in self.parts if part.start > 0}

    @property
    def clear(self) -> State:
        """The claims of which some recording's number is not the usual one, without recordings of which it may be; what
        each recording has is known of all.
        """
        out, names = [], [item.name for item in self.now.prepared.all]
        for held, some, mine in zip(self.held, self.of_each, _slices(self.held), strict=True):
            sure = np.abs(self.numbers[mine]) > self.widths[mine]
            if len(held.claim.nodes) > 1:  # of a load another number may be told
                every = [entry for statement in some for entry in statement.values.items()]
                known = {name for name, value in every if not value.low <= held.claim.usual <= value.high}
                sure = np.array([any(names[self.parts[j].recording] in known for j in group) for group in held.groups])
            if held.claim.everyone and sure.any():
                sure[:] = True
            groups = tuple(group for group, clear in zip(held.groups, sure, strict=True) if clear)
            if groups:
                out.append(held if groups == held.groups else replace(held, groups=groups))
        return tuple(out)

    def of_a_machine(self, recordings: Sequence[Apart]) -> bool:
        """True if some of the recordings needs as many numbers of its own as the model has."""
        model, names = self.now.model, [item.name for item in self.now.prepared.all]
        many = dict.fromkeys(names, 0)
        for held in self.held:
            for name in {names[self.parts[j].recording] for group in held.groups for j in group}:
                many[name] += held.count
        return any(many[item.recording] >= model.friction.stop for item in recordings)

    @property
    def ways(self) -> State:
        """The claims in which recordings differ, zeros not among them."""
        return tuple(held for held in self.held if not held.claim.everyone)

    def as_many_as(self, part: float) -> bool:
        """True if recordings differ in several ways, as many as `part` of a machine's numbers."""
        return len(self.ways) > 1 and sum(held.count for held in self.ways) >= part * self.now.model.friction.stop

    def beside(self, known: FittedModel, prepared: Prepared) -> FittedModel:
        """A model on the recordings without the torque that belongs to them alone, fitted to these."""
        return refitted(known.model, known, self.applied(prepared))

    @property
    def moved(self) -> tuple[Part, ...]:
        """The parts with the numbers by which their motion is another one; () where it is the recorded one."""
        each = [(part, of_part(self.held, self.numbers, j)) for j, part in enumerate(self.parts)]
        known = [(part, {held.claim.key: x for held, x in own if held.claim.of_motion}) for part, own in each]
        late = any(held.claim.bends for held in self.held)
        return tuple(replace(part, known=own) for part, own in known) if late else ()

    def on_motion(self, prepared: Prepared) -> Prepared:
        """The recordings with the motion that their torques are of, and what stands out of these as spikes there: a
        friction that reverses late looks like one.
        """
        found = replace(self.now, fit=replace(self.now.fit, linear=self.linear))
        pairs = zip(prepared.all, found.on(self.applied(prepared)).judged_anew().all, strict=True)
        every = [self._moved(item, unseen=False).with_spikes(other.spikes) for item, other in pairs]
        return prepared.with_recordings(every)

    def applied(self, prepared: Prepared) -> Prepared:
        """The recordings without the torque that belongs to them alone; of held-out ones each half without what the
        other half says.
        """
        train = tuple(self._applied(recording, unseen=False) for recording in prepared.train)
        verify = tuple(self._applied(recording, unseen=True) for recording in prepared.verify)
        names, everyone = self.now.model.joint_names, {held.claim.place for held in self.held if held.claim.everyone}
        zeroed = tuple(k for k, name in enumerate(names) if name in everyone)
        return replace(prepared, train=train, verify=verify, zeroed=zeroed)

    def carried(self, prepared: Prepared) -> Prepared:
        """The recordings as they are, with the loads that they carry felt by friction."""
        train = tuple(self._carrying(recording, unseen=False) for recording in prepared.train)
        verify = tuple(self._carrying(recording, unseen=True) for recording in prepared.verify)
        return replace(prepared, train=train, verify=verify)

    def _carrying(self, one: PreparedRecording, *, unseen: bool) -> PreparedRecording:
        return one.carrying(self._own(one, unseen=unseen, borne=True))

    def _applied(self, one: PreparedRecording, *, unseen: bool) -> PreparedRecording:
        carrying = self._carrying(self._moved(one, unseen=unseen), unseen=unseen)
        return carrying.beside_own(self._own(carrying, unseen=unseen))

    def _moved(self, one: PreparedRecording, *, unseen: bool) -> PreparedRecording:
        """Return a recording with the motion that its torques are of: that of other times, or at other angles, which
        about the moment of a change nobody knows; where that of one joint comes late it shows later that this sticks.
        """
        times, angles, late = one.motion.t.copy(), np.zeros(one.motion.q.shape), []
        unknown, reach = np.zeros(len(times), dtype=bool), 0.5 * response_seconds(one.cutoff)
        for j, half, numbers in self._halves(one, unseen=unseen):
            for held, number in of_part(self.held, numbers, j):
                for moment in filter(None, self.parts[j].span(self.now.prepared) if held.claim.of_motion else ()):
                    unknown |= np.abs(one.motion.t - moment) <= reach
                if held.claim.turns is not None:
                    angles[:, held.claim.turns] += half * number
                elif held.claim.moves:
                    later = held.claim.moves(replace(self._seen(one, j), number=number)) - one.motion.t
                    if held.claim.of_motion:
                        times += half * later
                    else:
                        late.append((self.now.model.joint_names.index(str(held.claim.place)), -float(later.mean())))
        timed = one if np.array_equal(times, one.motion.t) else one.at_times(times)
        turned = timed.changed(motion=replace(timed.motion, q=timed.motion.q + angles)) if angles.any() else timed
        return (turned.lacking(unknown) if unknown.any() else turned).shown_later(late)

    def _own(self, one: PreparedRecording, *, unseen: bool, borne: bool = False) -> Float:
        """Torque (N, J) of a recording alone, its motion at the times of its torques; or what drives bear of it."""
        known = np.zeros(one.wide_tau.shape)
        for j, half, numbers in self._halves(one, unseen=unseen):
            own = (entry for entry in of_part(self.held, numbers, j) if not entry[0].claim.of_motion)
            if some := [(held, x) for held, x in own if held.claim.borne or not borne]:
                known += half[:, None] * _added(self._seen(one, j), some).T
        return known

    def _halves(self, one: PreparedRecording, *, unseen: bool) -> Iterator[tuple[int, Float, Float]]:
        """Yield halves of the parts (index) of a recording: how much (N,) of each sample is there, and numbers (C,)."""
        t = one.motion.t
        for j, part in enumerate(self.parts):
            whole = self.now.prepared.all[part.recording]
            if whole.name == one.name and any(j in group for _, group in grouped(self.held)):
                inside = part.share(t, self.now.prepared)
                early = t < whole.t[(part.start + part.stop) // 2]
                for half, within in enumerate((early, ~early)):
                    yield j, inside * within, self.judged[j, half] if unseen else self.numbers

    def torque(self, one: PreparedRecording, j: int) -> Float:
        """Torque (J, N) that belongs to a part of a recording, before the filter."""
        return _added(self._seen(one, j), of_part(self.held, self.numbers, j))

    def _seen(self, one: PreparedRecording, j: int) -> Seen:
        return seen_before_filter(self.now, one, self.linear, self.now.shapes[self.parts[j].recording])

    def agrees(self, other: OwnNumbers) -> bool:
        """True if another look finds the same in the same recordings, and loads at the same place, within its
        intervals; where that multiplies or moves the model's torque, beside a model of the same terms.
        """
        if any(held.claim.factor for held in self.held) and self.now.model.effects != other.now.model.effects:
            return False
        first, new = self.by_recording, other.by_recording
        at, there = ({b.claim: b.place for b in own.told if b.place is not None} for own in (self, other))
        pairs = [(e, new.get(k, e)) for k, e in first.items()] + [(e, there.get(k, e)) for k, e in at.items()]
        return first.keys() == new.keys() and all(e.low <= old.value <= e.high for old, e in pairs)

    @property
    def by_recording(self) -> dict[tuple[Any, ...], Estimate]:
        """The numbers that are told, by the claim, the recording, and whether they hold from its beginning."""
        entries = ((b, name, b.spans.get(name, (None, None))[0] is None) for b in self.told for name in b.values)
        return {(*b.claim, name, early): b.values[name] for b, name, early in entries}

    def mixed_with(self, fitted: FittedModel, rules: Rules) -> frozenset[str]:
        """Names of the numbers of a model that do what each recording has: of either only their sum is known."""
        everyone = [held.claim for held in self.held if held.claim.everyone]
        fits = Fits(fitted, rules, {}) if everyone else None
        return frozenset(name for claim in everyone if fits for name in fits.mixed_with(claim))

    def without(self, names: Sequence[str]) -> tuple[Belonging, ...]:
        """Statements about the recordings that are not among `names`."""
        kept = ((b, {name: e for name, e in b.values.items() if name not in names}) for b in self.told)
        return tuple(replace(b, values=some, sentence=b.tell(some)) for b, some in kept if some)


def _added(seen: Seen, some: Iterable[tuple[Claimed, float]]) -> Float:
    """Torque (J, N) of claims with their numbers."""
    added = np.zeros(seen.torque.shape)
    for held, number in some:
        pieces = held.claim.pieces(replace(seen, number=number))
        added += number * (pieces @ held.claim.mix(held.node))
        added += pieces[:, :, -1] if held.claim.moves else 0.0
    return added


def with_numbers(fits: Fits, state: State) -> OwnNumbers:
    """The claims that are held with their numbers and intervals."""
    step = fits.together(state)
    judged = np.zeros((len(fits.rows), 2, len(step) - fits.count))
    for j, half in np.ndindex(len(fits.rows), 2):
        if any(j in group for _, group in grouped(state)):
            judged[j, half] = fits.together(state, (j, half))[fits.count :]
    numbers, spread = step[fits.count :], spread_of(fits, state, step)
    widths = spread.width[fits.count : len(step)]
    own = OwnNumbers(fits.now, fits.linear, fits.parts, state, numbers, widths, judged, fits.needless(state))
    if any(part.known for part in fits.parts):  # there, the numbers are what is left of them
        groups = [(held.claim, fits.parts[group[0]].known) for held, group in grouped(state)]
        known = np.array([before.get(claim.key, 0.0) if claim.of_motion else 0.0 for claim, before in groups])
        own = replace(own, numbers=numbers + known, judged=judged + known)
    else:
        own = replace(own, parts=tuple(replace(part, cut=_cut(fits, own, step, part)) for part in fits.parts))
    each = zip(state, _slices(state), strict=True)
    return replace(own, of_each=tuple(tuple(_told(fits, own, held, spread, mine)) for held, mine in each))


def _slices(state: State) -> list[slice]:
    """The places of each claim's numbers among all (C,)."""
    ends = np.cumsum([0, *(len(held.groups) for held in state)]).tolist()
    return [slice(*both) for both in pairwise(ends)]


def _cut(fits: Fits, own: OwnNumbers, step: Float, part: Part) -> float | None:
    """Time in s at which a recording changes, between the kept samples next to its cut; None where it is whole."""
    if part.whole:
        return None
    recording, before, after = fits.now.prepared.all[part.recording], *fits.everyone[part.recording]
    rows = np.concatenate([fits.rows[before], fits.rows[after]], axis=1)
    use = np.concatenate([fits.use[before], fits.use[after]], axis=1)
    left = rows @ fits.chosen(own.held)[before] @ np.append(-step, 1.0)
    change = own.torque(recording, after) - own.torque(recording, before)
    late, t = own.parts[after], recording.motion.t

    def loss(at: float) -> float:
        then = recording.smooth(replace(late, cut=at).share(t, fits.now.prepared)[:, None] * change.T) * use
        return float(huber_terms(np.abs(left - then) / fits.sigma[:, None], fits.rules.robust).sum())

    low, middle, high = (float(recording.t[late.start + k]) for k in (-1, 0, 1))
    return minimum(loss, low, high, TIME * (high - low))[0] if change.any() else middle


@dataclass(frozen=True, eq=False)
class Spread:
    """The covariance of all numbers, of which the first `count` are the model's; `places` {claim: its place's}."""

    matrix: Float
    critical: float
    width: Float
    count: int
    places: Mapping[Claim, slice]

    def place(self, claim: Claim, node: Node) -> tuple[Estimate, Float]:
        """Distance of a load from its joint, m, and the direction (D,) there, without what no motion shows of it."""
        rows = self.places[claim]
        known = np.where(np.isfinite(self.width[rows]), node, 0.0)
        far = float(np.linalg.norm(known))
        toward = known / max(far, 1e-300)
        square = max(float(toward @ self.matrix[rows, rows] @ toward), 0.0)
        half = self.critical * float(np.sqrt(square)) if far else np.inf
        return Estimate("place", far, "m", max(0.0, far - half), far + half), toward

    def load(
        self, claim: Claim, node: Node, numbers: Float, mine: slice, rules: Rules
    ) -> tuple[Float, Float, str, Estimate | None]:
        """Values (C,), half-widths (C,) and unit of loads, whose `numbers` are `mine`, and their place where that is
        known; where nobody can tell a mass, of first moments or inertias, without a place.
        """
        place, toward = self.place(claim, node)
        each = np.arange(self.count, len(self.width))[mine]
        if not place.value or np.all(self.width[each] <= rules.half * numbers):
            known = place.high - place.value <= rules.half * place.value
            return numbers, self.width[each], claim.unit, place if known else None
        far, told = place.value, []
        for power, unit in ((1, "kg·m"), (2, "kg·m²")):
            halves = []
            for at, number in zip(each, numbers, strict=True):
                rows, slope = np.r_[at, self.places[claim]], np.append(1.0, power * number / far * toward) * far**power
                square = float(slope @ self.matrix[np.ix_(rows, rows)] @ slope)
                halves.append(self.critical * np.sqrt(max(square, 0.0)))
            told.append((numbers * far**power, np.array(halves), unit))
        values, widths, unit = least_of(told, lambda one: float(np.max(one[1] / one[0])), 1.0)
        return values, widths, unit, None


def spread_of(fits: Fits, state: State, step: Float) -> Spread:
    """Uncertainty of numbers and places, valid under autocorrelation."""
    left = fits.left_by(state, [step, step])
    sigma = pooled_scale(list(zip(left, fits.use, strict=True)))
    groups, numbers = grouped(state), step[fits.count :]
    placed = [held for held in state if len(held.claim.nodes) > 1]
    columns, each = [], zip(fits.rows, fits.chosen(state), fits.slopes(state, numbers), strict=True)
    for j, (rows, chosen, by_model) in enumerate(each):
        both = rows @ chosen[:, :-1]
        both[:, :, : by_model.shape[2]] += by_model
        here = dict(of_part(state, numbers, j))
        own = [rows[:, :, fits.place[held.claim]] @ held.turn * here.get(held, 0.0) for held in placed]
        columns.append(np.concatenate([both, *own], axis=2))
    recordings = np.repeat([part.recording for part in fits.parts], [column.shape[1] for column in columns])
    found = covariance(
        np.concatenate(columns, axis=1), np.concatenate(left, axis=1), fits.rules.robust * sigma, recordings
    )
    first = fits.count + len(groups)
    ends = first + np.cumsum([0, *(len(held.node) for held in placed)])
    places = {held.claim: slice(*both) for held, both in zip(placed, pairwise(ends), strict=True)}
    widths = found.half_widths()
    for c, (_, group) in enumerate(groups, fits.count):  # only some of the samples tell of it
        samples = sum(fits.rows[j].shape[1] for j in group)
        widths[c] *= critical_value(found.lag, samples) / found.critical
    return Spread(found.matrix, found.critical, widths, fits.count, places)


def _told(fits: Fits, own: OwnNumbers, held: Claimed, spread: Spread, mine: slice) -> list[Belonging]:
    """Statements of a claim, whose numbers are `mine`, on whole recordings, before a change and after one: one each.

    What a recording has beyond what all have is told as one number, the sum, and that recording left out of the others.
    """
    claim, prepared = held.claim, fits.now.prepared
    numbers, widths, unit, place = own.numbers[mine], own.widths[mine], claim.unit, None
    every = zip(own.held, _slices(own.held), strict=True)
    twins = [(rest, some) for rest, some in every if rest is not held and rest.claim.subject == claim.subject]
    elsewhere = {j for rest, _ in twins if claim.common for group in rest.groups for j in group}
    for _, some in twins if not claim.common else ():
        numbers, widths = numbers + own.numbers[some], np.hypot(widths, own.widths[some])
    if len(claim.nodes) > 1:
        numbers, widths, unit, place = spread.load(claim, held.node, numbers, mine, fits.rules)
    told: dict[str, tuple[dict[str, Estimate], dict[str, Span]]] = {}
    for group, x, w in zip(held.groups, claim.usual + numbers, widths, strict=True):
        for j in (k for k in group if k not in elsewhere):
            part = own.parts[j]
            halved = not part.whole and not all(i in group for i in fits.everyone[part.recording])
            kind = "whole" if not halved else "until" if part.start == 0 else "from"
            values, spans = told.setdefault(kind, ({}, {}))
            name = prepared.all[part.recording].name
            values[name] = Estimate(claim.what, x, unit, x - w, x + w)
            if halved:
                spans[name] = part.span(prepared)
    out, mixed = [], fits.mixed_with(claim) if claim.everyone else ()
    for values, spans in told.values():
        where = "" if place is None else f" at {_said(place)}{_in_space(held.node, spread.width[spread.places[claim]])}"
        words, when = {name: _said(values[name], claim.shown) for name in sorted(values)}, _when(spans)
        tell = partial(_sentence, claim, words, where, when, mixed)
        ordered = {name: values[name] for name in words}
        if mixed:
            ordered = {name: replace(value, low=-np.inf, high=np.inf) for name, value in ordered.items()}
        out.append(Belonging(claim.what, claim.place, unit, ordered, tell(ordered), place, spans, claim.key, tell))
    return out


def _sentence(
    claim: Claim, words: Mapping[str, str], where: str, when: str, mixed: Sequence[str], values: Mapping[str, Estimate]
) -> str:
    """Sentence on some of the `values` of a claim, each told in `words`."""
    told = {name: words[name] for name in values}
    sentence = sentence_on(claim, _unlike_others(told, values) if claim.everyone else told, where, when)
    if not mixed:
        return sentence
    others = " and ".join(f"{number_of(name)} ({called(name.rpartition('.')[0])})" for name in mixed)
    return f"{sentence}; only how they differ is known: {others} would do the same"


def _unlike_others(words: dict[str, str], values: Mapping[str, Estimate]) -> dict[str, str]:
    """Words on numbers that each recording has: of few that differ from the middle, and of the others together."""
    numbers = {name: value.value for name, value in values.items()}
    away = np.abs(np.array([*numbers.values()]) - np.median([*numbers.values()]))
    unlike = [name for name, far in zip(numbers, away, strict=True) if far > LIKE * away.max()]
    if not 0 < len(unlike) <= FEW * len(values):
        return words
    others = [x for name, x in numbers.items() if name not in unlike]
    (unit,) = {value.unit for value in values.values()}
    return {name: words[name] for name in unlike} | {OTHERS: f"{min(others):.2g} to {max(others):.2g} {unit}"}


def _in_space(node: Node, width: Float) -> str:
    """Words such as " from its joint (0.002, 0, -0.251; no motion shows its y)", as `--payload` takes a place, known to
    within a `width` (D,) m; "" for one along a link.
    """
    if len(node) < 2:
        return ""
    hidden = [name for name, half in zip("xyz", width, strict=True) if not np.isfinite(half)]
    also = f"; no motion shows its {' and '.join(hidden)}" if hidden else ""
    return f" from its joint ({', '.join(f'{x:.3g}' for x in node)}{also})"


def _when(spans: Mapping[str, Span]) -> str:
    """Words such as "From 12.0 s on" or "Until 3.1 to 4.0 s"; "" for whole recordings."""
    if not spans:
        return ""
    late = all(start is not None for start, _ in spans.values())
    times = sorted(time for span in spans.values() for time in span if time is not None)
    ends = list(dict.fromkeys(f"{time:.1f}" for time in (times[0], times[-1])))
    return f"From {' to '.join(ends)} s on" if late else f"Until {' to '.join(ends)} s"


def _said(one: Estimate, shown: tuple[float, str] | None = None) -> str:
    """Words such as "0.91 ± 0.02 N·m"; in the unit that is `shown`, of which one of its own is so many."""
    times, called = shown or (1.0, one.unit)
    value, half = times * one.value, 0.5 * times * (one.high - one.low)
    digits = max(0, 1 - int(np.floor(np.log10(half)))) if half > 0.0 and np.isfinite(half) else 3
    unit = "" if called == "1" else f" {called}"
    return f"{value:.{digits}f} ± {half:.{digits}f}{unit}"
