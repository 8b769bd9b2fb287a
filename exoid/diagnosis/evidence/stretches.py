"""Long recordings are searched in stretches: an hour says no more about which effect is missing than ten minutes spread
over it, and the columns of a whole catalogue over an hour would not fit into memory.

Only the search sees stretches. Errors, parameters and intervals are of the whole recordings, every sample counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from exoid.diagnosis.rules import RULES, Rules
from exoid.measurement.finding import EVERY, Finding
from exoid.measurement.signals.conditioning import response_seconds
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.optimisation.preparation.prepare import Prepared


def searched_stretches(prepared: Prepared, rules: Rules = RULES) -> Prepared:
    """Return `prepared` itself, or, where it is too long to be searched, stretches as recordings of their own."""
    if sum(_seconds(item) for item in prepared.all) <= rules.whole_seconds:
        return prepared
    train = _spread(prepared.train, rules.searched_seconds, rules.stretch_seconds)
    verify = _spread(prepared.verify, 0.5 * rules.searched_seconds, rules.stretch_seconds)
    return replace(prepared, train=train, verify=verify)


def origins(prepared: Prepared, part: Prepared) -> tuple[int, ...]:
    """Return of which of the recordings `prepared` each one of `part` is, or is a stretch of."""
    out: list[int] = []
    for number, (whole, cut) in enumerate(((prepared.train, part.train), (prepared.verify, part.verify))):
        offset, k = number * len(prepared.train), 0
        for item in cut:
            while whole[k] is not item and not item.name.startswith(f"{whole[k].name} from "):
                k += 1
            out.append(offset + k)
    return tuple(out)


def searched(prepared: Prepared, part: Prepared, rules: Rules = RULES) -> tuple[Finding, ...]:
    """Finding that only stretches of the recordings were searched; () where everything was."""
    if part is prepared:
        return ()
    whole, seen = (sum(_seconds(item) for item in p.all) for p in (prepared, part))
    what = f"suspects were searched in {len(part.all)} stretches, {seen / 60:.0f} min of {whole / 60:.0f} min"
    remedy = "nothing to do: errors, parameters and intervals are of the whole recordings"
    return (Finding("stretches", "info", what, EVERY, seen, rules.whole_seconds, remedy),)


def _seconds(one: PreparedRecording) -> float:
    return float(one.t[-1] - one.t[0])


def _spread(recordings: Sequence[PreparedRecording], total: float, stretch: float) -> tuple[PreparedRecording, ...]:
    """Return stretches of `recordings`, about `total` seconds, each recording with its share; short ones stay whole."""
    length = sum(_seconds(item) for item in recordings)
    if length <= total:
        return tuple(recordings)
    out: list[PreparedRecording] = []
    for recording in recordings:
        count = max(1, round(total / stretch * _seconds(recording) / length))
        if count * stretch >= _seconds(recording):
            out.append(recording)
            continue
        starts = recording.t[0] + np.linspace(0.0, _seconds(recording) - stretch, count)
        out += [_cut(recording, start, stretch, f"{recording.name} from {start:.0f} s") for start in starts]
    return tuple(out)


def _cut(one: PreparedRecording, start: float, stretch: float, name: str) -> PreparedRecording:
    """Return one stretch, with as much motion around it as the filter reaches."""
    inside = np.flatnonzero((one.t >= start) & (one.t <= start + stretch))
    kept = one.kept[inside]
    reach = int(np.ceil(response_seconds(one.cutoff) * one.rate)) + 1
    first, last = max(0, int(kept[0]) - reach), min(len(one.motion), int(kept[-1]) + reach + 1)
    whole = {key: getattr(one.motion, key) for key in ("t", "q", "dq", "ddq", "sign", "base", "force", "load")}
    parts: dict[str, Any] = {key: None if x is None else x[first:last] for key, x in whole.items()}
    rows = {key: getattr(one, key)[first:last] for key in ("wide_tau", "stuck", "hidden")}
    rows |= {key: getattr(one, key)[:, inside] for key in ("torque", "used")}
    direction = one.direction and replace(one.direction, velocity=one.direction.velocity[first:last])
    motion = replace(one.motion, **parts)
    return replace(one, name=name, motion=motion, kept=kept - first, read=None, direction=direction, **rows)
