"""How a campaign asks a command about recordings."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from exoid.apps.campaign.watch_row import row_of_lines
from exoid.workbench.command import find_verbs


def model_as_option(model: str | None, recordings: Sequence[str]) -> list[str]:
    """Recordings, and the model as most commands take it."""
    return [*recordings, *(["--model", model] if model is not None else [])]


def model_first(model: str | None, recordings: Sequence[str]) -> list[str]:
    """The model, then the recordings, as `exoid watch` takes them."""
    return ["standard" if model is None else model, *recordings]


@dataclass(frozen=True)
class CampaignVerb:
    """What stands behind the options: `words(model, recordings)`, and how the JSON of the command becomes its `answer`.

    `alone`: about one recording at a time, with none held out.
    """

    words: Callable[[str | None, Sequence[str]], list[str]] = model_as_option
    answer: Callable[[str], Any] = json.loads
    alone: bool = False


VERBS: Mapping[str, CampaignVerb] = MappingProxyType(
    {
        **dict.fromkeys(("compare", "diagnose", "discover", "identify", "rivals"), CampaignVerb()),
        "watch": CampaignVerb(model_first, row_of_lines, alone=True),
    }
)
"""Commands that a campaign can ask, where they are there."""


def askable() -> list[str]:
    """Names of the commands that a campaign can ask here, sorted."""
    return sorted({*VERBS} & {*find_verbs()})
