"""From evidence to a sentence that a technician understands, the rule behind it, and what to do next."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from exoid.diagnosis.evidence.channel_doubt import Doubt
from exoid.diagnosis.evidence.enough_motion import little_motion
from exoid.diagnosis.evidence.intermittent import ADVICE, Intermittent
from exoid.diagnosis.evidence.model_error import ModelError, beside_floor, model_error, sensor_noise
from exoid.diagnosis.evidence.remainder import Remainder
from exoid.diagnosis.evidence.soft_drive import SoftDrive
from exoid.diagnosis.evidence.swinging import Swing, swinging
from exoid.diagnosis.results import Accepted, Conclusion, Possible
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.text import digits
from exoid.ground.ties import ascending
from exoid.measurement.auditing.masses import MASSES
from exoid.measurement.finding import Finding
from exoid.optimisation.fitting.fit import Fit
from exoid.symbolic.effect import Effect
from exoid.symbolic.effect_catalogue import every_effect, find_effect
from exoid.symbolic.joints import Joint
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate
from exoid.symbolic.term import Term
from exoid.symbolic.wording import called, number_called, number_said, the_joint, title_of

if TYPE_CHECKING:
    from exoid.diagnosis.evidence.fitted import FittedModel


def conclude(
    accepted: Sequence[Accepted],
    left: Remainder | None,
    first: FittedModel,
    last: FittedModel,
    verified: bool,
    recordings: int,
    rules: Rules = RULES,
    possible: Sequence[Possible] = (),
    leading: Possible | None = None,
) -> Conclusion:
    """Return the conclusion; `first` and `last` are the models at both ends, `possible` helps and was not accepted,
    `leading` what leads the candidates where nothing was accepted.
    """
    most = rules.most_terms
    where = "on recordings never fitted" if verified else "on held-out recordings"
    if not verified and recordings == 1:
        where = "on held-out blocks of the only recording"
    stopped = "one step was asked for; `exoid discover` goes on" if most == 1 else f"{most} effects are the limit"
    if len(accepted) < most:
        stopped = "no further entry of the catalogue lowers the error of unseen motion more than its own placebos do"
    error = model_error(last, rules)
    swing = None if error is None else swinging(last)
    end = _End(left, first, last, possible, leading, rules, error, swing, where, stopped)
    advice = _advice(verified, recordings)
    return _of_accepted(accepted, end, advice) if accepted else _of_nothing(end, advice)


@dataclass(frozen=True, eq=False)
class _End:
    """End of a search: what is `left`, the models at both ends, what is `possible`, the `error` of the last model
    with what `swing`s in it, `where` it was looked at, and why it `stopped`; `leading` explains most alone.
    """

    left: Remainder | None
    first: FittedModel
    last: FittedModel
    possible: Sequence[Possible]
    leading: Possible | None
    rules: Rules
    error: ModelError | None
    swing: Swing | None
    where: str
    stopped: str

    @property
    def oscillation(self) -> str:
        """The swing, as a sentence that follows others; "" without one."""
        return "" if self.swing is None else f" And {self.swing.sentence}"

    @property
    def dead(self) -> str:
        """Joints whose angle never changes although their torque does, as a sentence that follows others."""
        every, names = self.last.prepared.all, self.last.model.joint_names
        stands = np.all([item.standing & (np.ptp(item.torque, axis=1) > 0.0) for item in every], axis=0)
        still = " and ".join(name for name, stood in zip(names, stands, strict=True) if stood)
        return f" The angle of the {still} never changes: if it was not locked, this channel is dead." if still else ""

    @property
    def nearest(self) -> str:
        """Nearest of the candidates that were not accepted, as sentences that follow others; "" without any."""
        told = {} if self.leading is None else {self.leading.name: self.leading}
        for best in ascending(self.possible, lambda item: -item.explained_share, 1.0)[:1]:
            if best.explained_share >= self.rules.worth_telling:
                told[best.name] = best
        return "".join(
            f" {'Also near' if k else 'Nearest in the catalogue'}: {called(item.name, self.find)}, "
            f"{100 * item.explained_share:.0f} % of the error; {item.reason}."
            for k, item in enumerate(told.values())
        )

    @property
    def find(self) -> Callable[[str], Effect]:
        """Function that finds an effect by its id, the user's own among them."""
        return self.last.model.find_effect


def _of_nothing(end: _End, advice: str) -> Conclusion:
    """Return the conclusion where nothing was accepted."""
    left, error, swing, where, verdict = end.left, end.error, end.swing, end.where, "unexplained"
    if left is not None:
        rule = f"no catalogue entry fits, but a smooth curve lowers the error {where} (p = {left.p_value:.3g})"
        text = f"Something is missing that the catalogue does not know: {left.sentence}{_size(error)}."
        text += end.dead + end.oscillation + end.nearest
        advice = (
            "repeat slow motion through that range with and without load, then write the effect as "
            "[[custom_effects]] (a suggestion is in the report) and test it with `exoid add`"
        )
        if swing is not None:
            advice = swing.advice
    elif error is not None:
        rule = (
            f"the error {where} is {error.beside}, and no catalogue entry or smooth curve that can "
            "be accepted lowers it"
        )
        text = f"The model is not as good as the sensors: {error.sentence}.{end.dead}{end.oscillation}{end.nearest}"
        advice = error.advice if swing is None else swing.advice
    elif (early := next((item for item in end.possible if item.early), None)) is not None:
        name = called(early.name, end.find)
        rule = f"{name} lowers the error {where} more than its placebos do, but {early.reason}"
        text = (
            "Something is missing that the catalogue does not describe; the error is "
            f"{beside_floor(end.first)}. "
            f"Nearest is {name}, {100 * early.explained_share:.0f} % of the error, but {early.reason}."
        )
        advice = (
            "a link that swings behind a compliant drive looks so: measure its angle behind the drive, or clamp the "
            "link, load the drive and see whether the encoder moves; and compare the clocks of angles and torques at a "
            "knock against the leg"
        )
    elif names := _far_where_fitted(end.last, end.rules):
        rule = f"the error {where} is near the noise, that on fitted ones is not"
        text = f"More than noise is left in {', '.join(names)} that the recordings held out do not show.{end.nearest}"
        advice = _look_at(names)
    else:
        verdict = "adequate"
        rule = (
            f"no catalogue entry and no smooth curve lowers the error {where} more than its placebos do, and it is "
            f"{beside_floor(end.last)}"
        )
        text = "The model explains these recordings; nothing is missing that can be distinguished from noise."
    short = little_motion(end.last.prepared, end.rules)
    if short and short not in text:
        text += f" These recordings could not show much: {short}.{end.nearest if verdict == 'adequate' else ''}"
        advice = advice or "record more motion of this kind: small effects show only in the mean of much"
    return Conclusion(verdict, rule, text, end.stopped, advice, error=error)


def _of_accepted(accepted: Sequence[Accepted], end: _End, advice: str) -> Conclusion:
    """Return the conclusion where something was accepted."""
    left, error, where = end.left, end.error, end.where
    if error is not None and left is None:
        advice = error.advice
    alike = [a for a in accepted if a.look_alikes]
    names = " and ".join(called(a.name, end.find) for a in accepted)
    kind = "unseen" if end.first.verified else "fitted"
    falls = _told_falls(end.first.evaluation_rms, end.last.evaluation_rms, end.last.model.joints)
    text = f"Missing: {'; '.join(a.sentence for a in accepted)}. Error on {kind} motion: {falls}."
    if left is not None:
        text += f" Still unexplained: {left.sentence}{_size(error)}."
    elif error is not None:
        text += f" Beyond that, {error.sentence}."
    elif far := _far_where_fitted(end.last, end.rules):
        text += f" Beyond that, more than noise is left in {', '.join(far)} that those held out do not show."
        advice = advice or _look_at(far)
    text += end.oscillation
    if end.last.verified and (own := [(e.term, e.name) for e in end.last.model.shapes if e.shape.per_recording]):
        named = {term.name: term.effect for term in end.last.model.terms}
        numbers = " and ".join(number_called(named[term], name.removeprefix(f"{term}.")) for term, name in own)
        text += f" What a held-out recording has to itself ({numbers}) was found in one half and judged on the other."
    losing = [a for a in accepted if a.fall < 0.0 and a.agreement.repeats(end.rules)]
    if lost := " and ".join(called(a.name, end.find) for a in losing):
        text += f" The recordings held out here lose a little by {lost}; in nearly all other splits they gain by it."
        where = "in nearly all splits of the recordings, though not on those held out here"
    rule = f"{names}: significant against placebos (p ≤ {max(a.p_value for a in accepted):.3g}) and better {where}"
    if alike:
        texts = [f"{called(a.name, end.find)} from {_list(a.look_alikes, end.find)}" for a in alike]
        rule += f"; these data cannot distinguish {'; '.join(texts)}"
        advice = _deciding(alike, end.find) or advice
        which = f" These recordings cannot distinguish {'; '.join(texts)}; the others they can."
        text += which if len(alike) < len(accepted) else " Which of the look-alikes it is, these recordings cannot say."
    # What is ambiguous of several effects is told of that one; the others are missing for certain.
    verdict = "ambiguous" if len(alike) == len(accepted) else "missing"
    return Conclusion(verdict, rule, text, end.stopped, advice, error=error)


def _far_where_fitted(last: FittedModel, rules: Rules) -> list[str]:
    """Return the fitted recordings far from the noise where all unseen ones are near it and the fitted ones are not."""
    near = rules.near_noise * sensor_noise(last.prepared)
    if not last.verified or np.any(last.evaluation_rms > near) or np.all(last.train_rms <= near):
        return []
    return [name for name, rms in last.per_recording if np.any(rms > near)]


def _look_at(names: Sequence[str]) -> str:
    """Advice where only fitted recordings, the `names`, are far from the noise."""
    return (
        f"look at {' and '.join(names)} (what touched the machine, a load, a sensor) and leave out what is not of "
        "the machine; otherwise hold out a recording that shows it too: what is met in no recording held out "
        "cannot be verified"
    )


def doubted(doubt: Doubt) -> Conclusion:
    """Return the conclusion where the channels cannot be what they say."""
    stopped = "no effect is named on top of channels that cannot be what they say"
    return Conclusion("check_channels", doubt.rule, f"Check the channels. {doubt.sentence}", stopped, doubt.remedy)


def behind(soft: SoftDrive, joints: Sequence[Joint]) -> Conclusion:
    """Return the conclusion where a drive is too soft for its encoder to say where the link is."""
    falls = _told_falls(soft.before, soft.after, joints)
    angle, torque = next((item.unit("q"), item.unit("tau")) for item in joints if item.name == soft.joint)
    whose, unsure = f"the encoder of the {soft.joint}", ""
    if not soft.sure:
        whose = "an encoder"
        unsure = f" Which drive it is, is not sure: where only that of the {soft.joint} gave way, less would be left."
    return Conclusion(
        "unexplained",
        f"a soft drive, its twist found from the measured torque, leaves {100 * soft.share:.0f} % of the squared error "
        "beyond the noise that all accepted entries together leave",
        f"The link does not stand where {whose} says: the torques fit a drive of the {soft.joint} of about "
        f"{1.0 / soft.compliance:.2g} {torque}/{angle} with its encoder at the motor ({falls}). The link swings behind "
        f"it at about {soft.hertz:.2g} Hz, and no model of the encoder's motion alone predicts that: nothing is "
        f"accepted. Nearest in the catalogue: {soft.name}, c about {soft.compliance:.2g} {angle}/({torque}).{unsure}",
        "what is accepted in place of a soft drive would only take up part of it",
        f"measure the angle of the {soft.joint} behind its drive; to make sure, clamp the link and load the drive: "
        f"{soft.name} is the angle at the encoder per torque" + ("" if soft.sure else "; then the other drives"),
    )


def pushed(outside: Intermittent, joints: Sequence[Joint]) -> Conclusion:
    """Return the conclusion where something that was not measured pushes the machine in part of the time."""
    return Conclusion(
        "unexplained",
        f"fitted to the other {100 * (1.0 - outside.share):.0f} % of the time alone, the model leaves little there, "
        f"and what is left otherwise comes and goes in every recording, {outside.likeness}",
        outside.sentence(joints),
        "no effect, sign, convention or delay is looked for in a torque that comes from outside the machine",
        ADVICE,
        outside=True,
    )


def within_filter_error(base: FittedModel) -> Conclusion:
    """Return the conclusion where a model leaves no more than filter and derivatives get wrong."""
    errors = ", ".join(
        f"{joint.name} {1e3 * e:.2g} of {1e3 * f:.2g} m{joint.unit('tau')}"
        for joint, e, f in zip(base.model.joints, base.evaluation_rms, base.prepared.filter_error, strict=True)
    )
    return Conclusion(
        "adequate",
        f"the error is what filter and derivatives get wrong by themselves ({errors})",
        "The model explains these recordings as exactly as angles can be filtered and differentiated.",
        "what is left is the error of the filter, of which nothing can be learnt",
        "",
    )


def _size(error: ModelError | None) -> str:
    """Error that is left beside the structure that was found, in words; "" without one."""
    return "" if error is None else f"; the error of {the_joint(error.joint)} is {error.beside}"


def check_channels(misread: Sequence[Finding]) -> Conclusion:
    """Return the conclusion where physics says that the recordings keep another convention than exoid's."""
    far = any(finding.check == MASSES for finding in misread)
    return Conclusion(
        "check_channels",
        "the torques are far smaller than the masses in the robot file ask for"
        if far
        else "another reading of the channels explains the torques far better than the one they were given in",
        "The channels cannot be what they say. " + " ".join(f"{f.where}: {f.what}." for f in misread),
        "no effect is looked for in recordings whose channels are in doubt",
        "nothing yet; first " + "; ".join(dict.fromkeys(f.remedy.removeprefix("if so, ") for f in misread)),
    )


def _advice(verified: bool, recordings: int) -> str:
    if recordings == 1 and not verified:
        return "record at least two more motions: with one recording nothing is tested on a motion of its own"
    if not verified:
        return "hold one recording out with --verify: no step of the search then sees it"
    return ""


def _list(names: Sequence[str], find: Callable[[str], Effect]) -> str:
    return ", ".join(called(name, find) for name in names)


def _deciding(alike: Sequence[Accepted], find: Callable[[str], Effect] = find_effect) -> str:
    """Return the experiments that distinguish look-alikes, from the catalogue; and say where none can."""
    parts = []
    for item in alike:
        if item.never_separable:
            others = _list(item.never_separable, find)
            parts.append(f"no motion can distinguish {called(item.name, find)} from {others}: inspect the hardware")
        apart = [name for name in item.look_alikes if name not in (*item.never_separable, *item.outside)]
        if apart:
            parts.append(f"exoid design --separate {','.join([item.name, *apart[:2]])} finds the motion that decides")
        known = every_effect().get(item.effect)
        if known is not None and known.tells_apart:
            parts.append(known.tells_apart.rstrip("."))
    return "; ".join(dict.fromkeys(parts))


def _told_falls(before: Float, after: Float, joints: Sequence[Joint]) -> str:
    falls = zip(joints, before, after, strict=True)
    return ", ".join(f"{joint.name} {digits(b)} to {digits(a)} {joint.unit('tau')}" for joint, b, a in falls)


def sentence_of(term: Term, numbers: Mapping[str, Estimate], unknown: Collection[str] = ()) -> str:
    """Return e.g. "Stribeck friction at the knee (extra friction at creeping speed 2.2 ± 0.1 N·m, ...)"; `unknown` are
    the numbers, by their names in full, that are known only together with others, as are values of a shape whose
    interval is wider than all that they can be.
    """
    parts = []
    own = {n for n, s in term.placed_shape.items() if s.per_recording and (s.turns or s.spacing == "position")}
    for name, e in numbers.items():
        if name in own:
            what = number_called(term.effect, name)
            parts.append(f"{what} {e.low:.3g} to {e.high:.3g} {e.unit}, another in every recording")
            continue
        half, shape = 0.5 * (e.high - e.low), term.placed_shape.get(name)
        known = half if 0.0 < half < math.inf else None
        if e.name in unknown or (shape is not None and shape.max - shape.min < half < math.inf):
            known = math.inf
        parts.append(number_said(term.effect, name, e.value, e.unit, known))
    return f"{title_of(term.effect, term.joint)} ({', '.join(parts)})"


def biased_parameters(before: Fit, after: Fit) -> tuple[str, ...]:
    """Return, in words, which old parameters the missing effects had pulled off, and what became plausible."""
    new = {e.name: e for e in after.estimates}
    labels = {parameter.name: parameter.label for parameter in before.model.parameters}
    out = []
    for old in before.estimates:
        now = new.get(old.name)
        if now is None or not np.isfinite([now.low, now.high]).all() or now.low <= old.value <= now.high:
            continue
        text = f"{labels.get(old.name) or old.name} was {old.value:.4g}, is {now.value:.4g} {now.unit}".rstrip()
        friction = old.name.startswith(("coulomb", "viscous"))
        if friction and old.value < 0.0 <= now.value:
            text += " (a friction that was negative, which is impossible, has become positive)"
        out.append(text)
    return tuple(out)
