"""Dates and clock times, as spreadsheets, loggers and ROS write them, in seconds since the first.

Only differences count, so it does not matter whether 03/01 is in January or in March; a date is only asked whether it
changed, and a clock that falls by half a day has passed midnight.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np

from exoid.symbolic.motion import Float

DAY = 86400.0
ISO = re.compile(
    r"(?P<day>\d{4}-\d\d-\d\d)[T ](?P<clock>\d\d:\d\d(?::\d\d)?)(?:[.,](?P<part>\d{1,12}))?"
    r"\s*(?P<zone>Z|[+-]\d\d(?::?\d\d)?)?$",
    re.ASCII,
)
CLOCK = re.compile(
    r"(?:(?P<date>\d{1,4}[./-]\d{1,2}[./-]\d{1,4})[ T,]+)?(?P<h>\d{1,2}):(?P<m>\d\d):(?P<s>\d\d(?:[.,:]\d{1,9})?)"
    r"(?:\s*(?P<half>[AaPp])\.?[Mm]\.?)?",
    re.ASCII,
)
SHORT_CLOCK = re.compile(r"(?P<m>\d{1,3}):(?P<s>\d\d(?:[.,]\d{1,9})?)", re.ASCII)
"""What a spreadsheet shows of a time when nobody tells it how: minutes, seconds and one decimal."""


def seconds(texts: Sequence[str]) -> Float | None:
    """Return seconds (N,) since the first stamp, NaN where a text is none; None when they are no stamps at all."""
    first = next((text for text in texts if text), "")
    if ISO.match(first):
        return since_first(np.array([_iso(text) for text in texts], dtype="datetime64[ns]"))
    pattern = CLOCK if CLOCK.fullmatch(first) else SHORT_CLOCK if SHORT_CLOCK.fullmatch(first) else None
    if pattern is None:
        return None
    out = np.full(len(texts), np.nan)
    days: dict[str | None, int] = {}
    for i, text in enumerate(texts):
        found = pattern.fullmatch(text)
        if found:
            out[i] = _clock(found.groupdict(), days)
    return _past_midnight(out, DAY if pattern is CLOCK else 3600.0) - first_of(out)


def since_first(stamps: Any) -> Float:
    """Return seconds since the first stamp of an array (N,) of dates or durations, NaN where there is none."""
    if stamps.dtype.kind == "O":
        first = next(stamp for stamp in stamps if stamp is not None and stamp == stamp)
        since = [None if stamp is None or stamp != stamp else stamp - first for stamp in stamps]
        stamps = np.array(since, "timedelta64[ns]")
    there = stamps[~np.isnat(stamps)]
    return np.asarray((stamps - (there if there.size else stamps)[:1]) / np.timedelta64(1, "s"), dtype=float)


def _iso(text: str) -> np.datetime64:
    """Return the instant, in UTC, of a date and time as ISO 8601 writes it; NaT for any other text."""
    found = ISO.match(text)
    if not found:
        return np.datetime64("NaT", "ns")
    try:
        moment = datetime.fromisoformat(f"{found['day']}T{found['clock']}{found['zone'] or ''}")
    except ValueError:
        return np.datetime64("NaT", "ns")
    moment = moment.astimezone(UTC).replace(tzinfo=None) if found["zone"] else moment
    return np.datetime64(moment, "ns") + np.timedelta64(int((found["part"] or "0").ljust(9, "0")[:9]), "ns")


def _clock(found: dict[str, str | None], days: dict[str | None, int]) -> float:
    """Return seconds of one stamp; each new date in `days` is taken for the day after the last."""
    hour = int(found.get("h") or 0)
    half = found.get("half")
    if half:
        hour = hour % 12 + (12 if half.lower() == "p" else 0)
    day = days.setdefault(found.get("date"), len(days))
    second = re.sub(r"[,:]", ".", found["s"] or "0")
    return DAY * day + 3600.0 * hour + 60.0 * int(found["m"] or 0) + float(second)


def _past_midnight(t: Float, turn: float) -> Float:
    """Return stamps (N,) that go on where the clock starts again after a whole `turn` in s."""
    finite = np.flatnonzero(np.isfinite(t))
    back = np.diff(t[finite]) < -0.5 * turn
    t = t.copy()
    t[finite[1:]] += turn * np.cumsum(back)
    return t


def first_of(t: Float) -> float:
    """Return the first stamp that is one, 0 where there is none."""
    finite = t[np.isfinite(t)]
    return float(finite[0]) if finite.size else 0.0
