"""An effect of the user's own."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from exoid.apps.page.reply import Action


ACTIONS: dict[str, Action] = {"effect": lambda workspace, told: workspace.add_effect(dict(told["effect"]))}
