"""Sentences of a watch: the event of each thing that it reports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from exoid.apps.watch.alarm import Deviation
from exoid.apps.watch.course import Onset, onset
from exoid.apps.watch.events import Event, clock
from exoid.apps.watch.front import FrontEnd
from exoid.apps.watch.window import Window
from exoid.diagnosis.against.result import Differences
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.intermittent import TIMES
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate

SILENT = 5.0
"""s without a sample from which that is said."""


def start_event(front: FrontEnd, joints: Sequence[str], needed: float) -> Event:
    """Return that the rate is known, or the clock has jumped; the first `needed` s will say what is usual."""
    filters = front.filters
    assert filters is not None
    text = f"{filters.rate:.5g} Hz, cut-off {filters.cutoff:g} Hz, answers {filters.delay:.2g} s late"
    if front.restarts:
        text = f"the clock jumped to {clock(float(front.begin))}; the filters start anew: {text}"
    else:
        text += f"; the first {needed:g} s say what is usual"
    more = {"rate": filters.rate, "cutoff": filters.cutoff, "delay": filters.delay, "joints": joints}
    return Event("start", float(front.begin), text, more=more)


def reference_event(
    t: float, now: FittedModel, numbers: Sequence[Estimate], limit: float, blocks: int, changed: Sequence[str] = (),
    *, restored: bool = False,
) -> Event:  # fmt: skip
    """Return that what is usual is known: the model `now`, of so many `blocks`, its `numbers` as they are followed, and
    the detector's `limit`; where that is from an earlier watch (`restored`), what had `changed` since.
    """
    # What is followed knows of the encoders' noise; what a fit does not know of its shapes is in its own intervals.
    estimates = now.fit.estimates if now.model.shapes else tuple(numbers[: len(now.model.parameters)])
    said = ", ".join(f"{e.name} {e.value:.3g} [{e.low:.3g}, {e.high:.3g}]" for e in estimates)
    rms = zip(now.model.joints, now.train_rms, strict=True)
    errors = ", ".join(f"{joint.name} {x:.3g} {joint.unit('tau')}" for joint, x in rms)
    more: dict[str, object] = {"rms": now.train_rms, "limit": limit, "blocks": blocks}
    known = "known"
    if restored:
        more |= {"restored": True, "changed": list(changed)}
        known += " from before" + (f", and changed since: {', '.join(changed)}" if changed else "")
    return Event("reference", t, f"what is usual is {known}: {said}; error {errors}", tuple(estimates), more=more)


def change_event(t: float, answer: Differences, found: Deviation | None, state: str, since: Onset | None) -> Event:
    """Return that `answer` names what differs `since` then."""
    first = answer.found[0]
    kind = {"load": "payload", "sensor": "sensor"}.get(first.kind, "drift" if since and since.slow else "abrupt")
    when = "" if since is None else f"since {clock(since.t)} ({clock(since.low)} to {clock(since.high)}) "
    more: dict[str, object] = {"state": state, "rms_before": answer.rms_before, "rms_after": answer.rms_after}
    if found is not None:
        more |= {"deviation": found.size, "limit": found.limit}
    text = f"{when}{'slowly ' if kind == 'drift' else ''}{'; '.join(d.sentence for d in answer.found)}"
    return Event("change", t, text, (), answer, since, kind, more)


def onset_of(answer: Differences, last: Sequence[Window], begun: float = -np.inf) -> Onset | None:
    """Return the onset of what was found, where the windows `last` were taken for after; None where that is unknown.

    What began before a watch that has `begun` with what another one had learnt, did so while nobody watched.
    """
    course = answer.found[0].course
    if course is None:
        return None
    block = float(last[0].t[-1] - last[0].t[0])
    found = onset(course, float(last[0].t[0]) - 2.0 * block)  # the block before may hold both
    return Onset(begun, begun, begun, False) if found.low < begun else found


def estimates_event(t: float, estimates: tuple[Estimate, ...]) -> Event:
    """Return the numbers as they are now."""
    return Event("estimates", t, ", ".join(f"{e.name} {e.value:.3g}" for e in estimates), estimates)


def over_event(t: float, name: str, answer: Differences | None = None) -> Event:
    """Return that what had changed is as it was before."""
    return Event("change", t, f"over again: {name} is as it was before", (), answer, None, "over", {"state": "over"})


def heartbeat_event(
    t: float, blocks: int, known: bool, changed: Sequence[str], silent: float, lost: Mapping[str, int]
) -> Event:
    """Return that the watch is alive, whether it is `known` what is usual, what has `changed`, and what was `lost`;
    `silent` s have passed since the last sample.
    """
    text = f"alive, {blocks} blocks" + ("" if known else ", what is usual is not known yet")
    text += f"; no sample for {silent:.0f} s" if silent >= SILENT else ""
    more = {"blocks": blocks, "known": known, "changed": list(changed), "silent": round(silent, 1)}
    return Event("heartbeat", t, text, more=more | dict(lost))


def suspected_event(t: float, joints: Sequence[str], grown: Float, found: Deviation) -> Event:
    """Return that something may have changed, at the joint whose error has `grown` (J,) most; a question follows."""
    joint = joints[int(np.argmax(grown))]
    text = f"something may have changed at {joint}, and is looked into"
    more = {"state": "first", "joint": joint, "deviation": found.size, "limit": found.limit}
    return Event("suspected", t, text, more=more)


def calm_event(t: float, answer: Differences | None = None) -> Event:
    """Return that a question confirmed nothing: another motion showed an old error, or it was a burst."""
    if answer is not None and answer.old:
        text = f"nothing changed; this motion shows what the model has missed all along: {', '.join(answer.old)}"
        return Event("motion", t, text, differences=answer)
    return Event("suspected", t, "nothing changed that lasts: what was suspected is over", more={"state": "over"})


def nameless_event(
    t: float, joints: Sequence[str], answer: Differences, grown: Float, small: float, pushes: int = 0
) -> Event:
    """Return that the error has `grown` (J,) times without a name; where by less than `small`, that it is too small,
    and where it comes and goes, as so many `pushes`, whose it may be.
    """
    joint = int(np.argmax(grown))
    at = f"at {joints[joint]}"
    text = f"something changed {at}, too small to name yet"
    if grown[joint] > small:
        text = f"the error {at} is {grown[joint]:.2g} times what it was, and nothing known explains it"
    nearest = [d.name for d in answer.found]
    text += f"; nearest: {', '.join(nearest)}" if nearest else ""
    if pushes >= TIMES:
        text += f"; it has come and gone {pushes} times: a person, or the ground? Measure it: columns f1, f2, grf_x, "
        text += "grf_z, or contact"
    more = {"rms": answer.rms_after, "joint": joints[joint], "nearest": nearest, "pushes": pushes}
    return Event("unexplained", t, text, differences=replace(answer, found=()), more=more)


LOST = {
    "not_finite": "samples passed over that are not finite",
    "not_credible": "samples passed over that no sensor can have measured",
    "not_later": "samples passed over that are not later than those before",
    "restarts": "jumps of the clock",
}
"""What is counted beside the blocks -> in words."""


def summary_event(
    t: float, seconds: float, blocks: int, known: bool, found: int, counts: Mapping[str, int],
    lost: Mapping[str, int], estimates: tuple[Estimate, ...],
) -> Event:  # fmt: skip
    """Return the end: how long was watched, whether it was `known` what is usual, how many changes were `found`, the
    `counts` of events, what was `lost`, and the last `estimates`.
    """
    nameless = counts.get("unexplained", 0)
    text = f"{clock(seconds)} watched, {blocks} blocks"
    if not known:
        text += ": too little to say what is usual, so nothing was looked for"
    else:
        text += f", changes named: {found}" if found else "" if nameless else ", no change"
        text += f", changes without a name: {nameless}" if nameless else ""
    passed = [f"{LOST[name]}: {count}" for name, count in lost.items() if count]
    text += f"; {', '.join(passed)}" if passed else ""
    more = {"seconds": seconds, "blocks": blocks, "changes": found, "unexplained": nameless, "events": dict(counts)}
    return Event("summary", t, text, estimates, more=more | dict(lost))
