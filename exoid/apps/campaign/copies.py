"""Recordings that are the same byte for byte: one that was copied to other devices counts several times, unseen."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from typing import Any

SHOWN = 6
"""Jobs that are named of those that share recordings."""


def same_recordings(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return for each row which of its recordings are those of which other jobs, a few of them named; "" for none."""
    places = _places(rows)
    out = []
    for k, row in enumerate(rows):
        named = []
        for name, content in _recordings(row):
            others = (place for place in places[content] if place != (k, name))
            named += [f"{name} = {rows[other]['name']}/{theirs}" for other, theirs in islice(others, SHOWN)]
        out.append("; ".join(named))
    return out


def describe_copies(rows: Sequence[Mapping[str, Any]], device: str | None) -> list[str]:
    """Return sentences about recordings that several jobs have, or one of them twice."""
    shared: dict[tuple[int, ...], int] = defaultdict(int)
    for places in _places(rows).values():
        if len(places) > 1:
            shared[tuple(sorted({k for k, _ in places}))] += 1
    out = []
    for jobs, count in shared.items():
        devices = {rows[k]["fields"].get(device) for k in jobs} if device else set()
        names = [rows[k]["name"] for k in jobs]
        more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
        what = "1 recording is" if count == 1 else f"{count} recordings are"
        counted = "as several devices" if len(devices) > 1 else "several times"
        out.append(f"{what} the same, byte for byte, in {', '.join(names[:SHOWN])}{more}: counted {counted}")
    return out


def _places(rows: Sequence[Mapping[str, Any]]) -> dict[str, list[tuple[int, str]]]:
    """Return {content: row and name of every recording with it}."""
    found: dict[str, list[tuple[int, str]]] = defaultdict(list)
    for k, row in enumerate(rows):
        for name, content in _recordings(row):
            found[content].append((k, name))
    return found


def _recordings(row: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    sums = row.get("sums", {})
    for role in ("recordings", "verify"):
        yield from zip(row.get(role, ()), sums.get(role, ()), strict=False)
