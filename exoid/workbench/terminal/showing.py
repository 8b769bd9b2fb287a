"""Results as they look in the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from exoid.diagnosis.report.material import NOTHING_HELD_OUT
from exoid.diagnosis.report.sections.verdict import term
from exoid.diagnosis.report.wording import error_sizes
from exoid.diagnosis.sureness import meanings_of
from exoid.ground.text import digits
from exoid.symbolic.wording import added_said, the_joint
from exoid.workbench.terminal.screen import Screen, bar

SPIKES = "torque_outliers"
MOST_SUSPECTS = 8
MOST_PLACES = 6
VERDICT_STYLES: Mapping[str, str] = {"adequate": "good", "missing": "good", "check_channels": "bad"}
MOST_BESIDE = 2


def show_fit(screen: Screen, fit: Any) -> None:
    """Show parameters with intervals, the proof, the optimisers and what to be careful about."""
    rows = [(e.name, number(e.value, 5), e.unit, number(e.low), number(e.high)) for e in fit.estimates]
    screen.table("Parameters", ("name", "value", "unit", "95 % from", "to"), rows)
    errors = ", ".join(f"{joint} {number(x)}" for joint, x in zip(fit.model.joint_names, fit.rms, strict=True))
    screen.say(f"error (RMS) on the fitted motion: {errors} {fit.model.torque_unit}")
    screen.say(str(fit.certificate))
    if fit.shapes_known:
        screen.say(fit.shapes_known)
    if fit.runs:
        gaps = [(name, f"{run.gap:.1e}", f"{run.seconds:.2f}") for name, run in fit.runs.items()]
        if fit.reference is not None:
            gaps.append(("IPOPT", f"{fit.reference.gap:.1e}", f"{fit.reference.seconds:.2f}"))
        screen.table("Distance to the certified optimum", ("method", "relative gap", "s"), gaps)
    for finding in fit.plausibility:
        screen.say(f"careful: {finding}", "warn")


def show_by_recording(screen: Screen, found: Any) -> None:
    """Show every parameter from every recording alone, whether they agree, and what to record where they do not."""
    side = ["unit", "together", *found.recordings, "verdict"]
    for first in range(0, len(found.rows), MOST_BESIDE):
        part = found.rows[first : first + MOST_BESIDE]
        columns = [side, *([row.unit, *found.cells(row)[2:]] for row in part)]
        title = "" if first else "Which numbers can I trust? Each recording alone"
        screen.table(title, ("recording", *(row.name for row in part)), list(zip(*columns, strict=True)))
    for row in found.rows:
        if row.advice:
            screen.say(f"{row.name}: {row.verdict}; {row.advice}", "warn")


def of_the_set(audit: Iterable[Any]) -> list[Any]:
    """Return the findings of an audit about recordings together, which reading one by one could not tell."""
    checks = ("overlap", "thigh_length", "channels", "forces", SPIKES)
    told = [finding for finding in audit if finding.check in checks]
    return [finding for finding in told if finding.severity == "warning" or "cannot tell" in finding.what]


def show_findings(screen: Screen, audit: Sequence[Any], misread: Sequence[Any] = (), style: str = "warn") -> None:
    """Show what an audit says of recordings together, and what share of the torques was hidden as spikes."""
    for finding in (*misread, *of_the_set(audit)):
        screen.say(f"careful: {finding}", "warn" if finding.check == SPIKES else style)
    for finding in audit:
        if finding.check == SPIKES and finding.severity == "repaired":
            screen.say(str(finding), "faint")


def show_comparison(screen: Screen, found: Any) -> None:
    """Show how large the error is per joint, and where it sits."""
    from exoid.diagnosis.report.sections.where import words as variable_words

    head, rows = error_sizes(found)
    shown = [[joint, *("" if x is None else number(x) for x in values)] for joint, *values in rows]
    screen.table("How large the error is (RMS)", head, shown)
    for force in found.forces:
        screen.say(f"measured force: {force.sentence}")
    if found.strides is not None:
        screen.say(found.strides.sentence)
    if found.verify_rms is None:
        screen.say(NOTHING_HELD_OUT, "warn")
    show_findings(screen, found.audit, found.misread, "bad")
    if not found.where:
        if not found.misread:  # of channels that are in doubt nobody asks what their error depends on
            screen.say("The error depends on nothing that was looked at.")
        return
    places = [
        (w.joint, variable_words(w.variable, found.joints), percent(w.share), w.sentence.removeprefix(f"{w.joint}: "),
         w.caution)
        for w in found.where[:MOST_PLACES]
    ]  # fmt: skip
    screen.table("Where it sits", ("joint", "depends on", "share", "what that means", "caution"), places)


def show_differences(screen: Screen, found: Any) -> None:
    """Show what differs between before and after, with intervals and what looks like it."""
    screen.say(found.sentence, "bad" if found.differs else "good")
    rows = [
        (d.name, a.name, f"{number(a.value)} [{number(a.low)}, {number(a.high)}]",
         f"{number(b.value)} [{number(b.low)}, {number(b.high)}]", "" if b.unit == "1" else b.unit,
         ", ".join(d.look_alikes))
        for d in found.found
        for a, b in zip(d.before, d.after, strict=True)
    ]  # fmt: skip
    if rows:
        head = ("what differs", "number", "before [95 %]", "after [95 %]", "unit", "look-alikes in these data")
        screen.table("Before and after", head, rows)
    for name in found.old:
        screen.say(f"no change, but missing in the model before and after: {name}", "warn")
    errors = zip(found.joints, found.units, found.rms_before, found.rms_after, found.rms_named, strict=True)
    for joint, unit, *values in errors:
        before, after, named = map(number, values)
        screen.say(f"error of {the_joint(joint)}: {before} {unit} before, {after} after, {named} with what is named")
    show_findings(screen, found.audit)


def show_diagnosis(screen: Screen, found: Any) -> None:
    """Show verdict, reason, what was accepted, the suspects and what to measure next."""
    from exoid.diagnosis.report.sections.where import words as variable_words

    result = found.to_json()
    screen.say()
    screen.say(f"{found.headline}.", VERDICT_STYLES.get(found.verdict, "warn"))
    screen.say(str(found.further))
    screen.say(f"why: {found.rule}", "faint")
    show_findings(screen, found.audit)
    for force in result.get("forces", ()):
        screen.say(f"measured force: {force['sentence']}", "faint")
    for item in result["accepted"]:
        likes, never = (", ".join(map(found.called, item.get(key) or ())) for key in ("look_alikes", "never_separable"))
        said = [f"these data cannot distinguish it from {likes}"] if likes else []
        said += [f"no motion can distinguish it from {never}"] if never else []
        screen.say(f"  + {found.called(term(item))}: {'; '.join([item['sureness'], *said])}")
        if item.get("stability"):
            screen.say(f"    {item['stability']}", "faint")
    for entry in result.get("possible", ()):
        screen.say(f"  possible: {found.called(term(entry))}: {entry['reason']}  [{term(entry)}]")
    suspects = result["suspects"][:MOST_SUSPECTS]
    if suspects:
        rows = [
            (found.called(term(s)), percent(s["explained_share"]), s["sureness"] or "–",
             ", ".join(map(found.called, s["look_alikes"])), term(s))
            for s in suspects
        ]  # fmt: skip
        head = ("suspect", "explains", "how sure", "look-alikes in these data", "id")
        words = meanings_of(s["sureness"] for s in suspects)
        screen.table("Suspects", head, rows, ". ".join(words) and f"{'. '.join(words)}.")
    left = result.get("unexplained") or {}
    if left.get("significant") and left["variables"]:
        depends = ", ".join(f"the {variable_words(name, found.joints)}" for name in left["variables"])
        screen.say(f"left over: {left['joint']}, depends on {depends}", "warn")
        for text in left.get("suggested_terms", ()):
            screen.say(f"  worth trying as an effect of your own: torque = {text!r}")
    if found.stopped_because:
        screen.say(f"stopped: {found.stopped_because}", "faint")
    if found.next_experiment:
        screen.say(f"measure next: {found.next_experiment}")


def show_steps(screen: Screen, fall: Any) -> None:
    """Show the falling error of a Diagnosis or a Waterfall: one bar per step, of the unseen motion where there is some.
    """
    for j, joint in enumerate(fall.joints):
        shown = [(added_said(step.label), float(step.evaluation_rms[j])) for step in fall.steps]
        longest = max((x for _, x in shown if math.isfinite(x)), default=0.0) or 1.0
        width = max(len(name) for name, _ in shown)
        screen.say(f"error of {the_joint(joint)}, {fall.steps[0].judged} motion [{fall.unit}]", "head")
        for name, x in shown:
            screen.say(f"  {name:<{width}}  {number(x):>7}  {bar(x / longest if math.isfinite(x) else 1.0)}")
        floor = float(fall.noise_floor[j])
        screen.say(f"  {'noise floor':<{width}}  {number(floor):>7}  {bar(floor / longest)}", "faint")


def number(value: float | None, count: int = 3) -> str:
    """Return a number with `count` significant digits, or a dash where there is none."""
    if value is None or not math.isfinite(value):
        return "-"
    return digits(value, count)


def percent(share: float | None) -> str:
    """Return a share as per cent."""
    return "-" if share is None or not math.isfinite(share) else f"{100 * share:.0f} %"


def show_limit(screen: Screen, limit: Sequence[float] | None, rms: Iterable[float], unit: str) -> bool:
    """Say and return whether an error asked to stay at or below `limit`, (1,) or (J,), is above it at any joint (or not
    a number).
    """
    if limit is None or all(x <= limit[j % len(limit)] for j, x in enumerate(rms)):
        return False
    screen.say(f"the error is above the limit of {' / '.join(f'{x:g}' for x in limit)} {unit}", "bad")
    return True


def truth_sentence(truth: Any) -> str:
    """Return the effects that a seal says were hidden, as a sentence."""
    if not truth.effects:
        return "nothing was hidden."
    parts = []
    for effect in truth.effects:
        sizes = ", ".join(f"{name} = {number(value)}" for name, value in effect.values.items())
        parts.append(f"{effect.term} ({sizes})" if sizes else effect.term)
    return " and ".join(parts) + (" was hidden." if len(parts) == 1 else " were hidden.")
