"""Torque, model and error over the stride."""

from __future__ import annotations

from typing import TYPE_CHECKING

from exoid.apps.page import numbers
from exoid.apps.page.reply import as_json

if TYPE_CHECKING:
    from exoid.apps.page.reply import Answer


ANSWERS: dict[str, Answer] = {
    "strides": lambda workspace, request: as_json(numbers.strides(workspace, workspace.opened())),
}
