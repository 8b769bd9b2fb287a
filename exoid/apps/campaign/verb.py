"""Commands about recordings as a campaign asks them."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from exoid.apps.campaign import verbs
from exoid.ground.folder import with_apps
from exoid.workbench.command import find_verbs


def model_as_option(model: str | None, recordings: Sequence[str]) -> list[str]:
    """Recordings, and the model as most commands take it."""
    return [*recordings, *(["--model", model] if model is not None else [])]


@dataclass(frozen=True)
class CampaignVerb:
    """A command of a campaign: `words(model, recordings)` stand behind its options, its JSON becomes its `answer`.

    `alone`: about one recording at a time, with none held out.
    """

    words: Callable[[str | None, Sequence[str]], list[str]] = model_as_option
    answer: Callable[[str], Any] = json.loads
    alone: bool = False


def verb_of(name: str) -> CampaignVerb:
    """Return the CampaignVerb of a command that a campaign can ask."""
    found: CampaignVerb = import_module(with_apps(verbs)[name]).VERB
    return found


def askable() -> list[str]:
    """Names of the commands that a campaign can ask here, sorted."""
    return sorted({*with_apps(verbs)} & {*find_verbs()})
