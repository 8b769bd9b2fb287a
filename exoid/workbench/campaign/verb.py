"""How a campaign asks a command about recordings. A command that can be asked says how by its `IN_CAMPAIGNS`."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any


def model_as_option(model: str | None, recordings: Sequence[str]) -> list[str]:
    """Return the recordings, and the model as most commands take it."""
    return [*recordings, *(["--model", model] if model is not None else [])]


@dataclass(frozen=True)
class CampaignVerb:
    """What stands behind the options: `words(model, recordings)`, and how the JSON of the command becomes its `answer`.

    `alone`: about one recording at a time, with none held out.
    """

    words: Callable[[str | None, Sequence[str]], list[str]] = model_as_option
    answer: Callable[[str], Any] = json.loads
    alone: bool = False
