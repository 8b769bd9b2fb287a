"""`exoid watch` in a campaign: what it reported of one recording, as the one answer that is kept."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from exoid.apps.campaign.verb import CampaignVerb


def model_first(model: str | None, recordings: Sequence[str]) -> list[str]:
    """The model, then the recordings, as `exoid watch` takes them."""
    return ["standard" if model is None else model, *recordings]


def row_of_lines(text: str) -> dict[str, Any]:
    """Return the answer that the events in `text`, one JSON object per line, come to."""
    return row_of_events([json.loads(line) for line in text.splitlines()])


def row_of_events(events: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the events of `watch` as one answer: verdict, what changed and when, numbers at the end.

    A change that is named twice, at once and with better data, counts as it was named last. The verdict is "changed",
    "unexplained" (the error grew, and nothing known explains it), "unchanged", or "undetermined" where the recording
    does not determine the model.
    """
    changes: list[Mapping[str, Any]] = []
    for one in events:
        if one["event"] == "change" and one["kind"] != "over":
            if changes and one.get("state") == "refined":
                changes.pop()
            changes.append(one)
    kinds = {one["event"] for one in events}
    last: Mapping[str, Any] = next((one for one in reversed(events) if one["event"] == "summary"), {})
    verdict = "unchanged" if "reference" in kinds else "undetermined"
    accepted = [
        {
            "name": found["name"], "parameters": found["change"], "look_alikes": found["look_alikes"],
            "p_value": found["p_value"], "since": one.get("since"), "kind": one["kind"],
        }
        for one in changes for found in one["differences"]
    ]  # fmt: skip
    return {
        "schema": "exoid.watch/1",
        "verdict": "changed" if changes else "unexplained" if "unexplained" in kinds else verdict,
        "joints": next((one["joints"] for one in events if one["event"] == "start"), []),
        "accepted": accepted, "parameters": last.get("parameters", {}), "events": list(events),
        **({"rms_before": changes[0]["rms_before"], "rms_after": changes[-1]["rms_after"]} if changes else {}),
    }  # fmt: skip


VERB = CampaignVerb(model_first, row_of_lines, alone=True)
