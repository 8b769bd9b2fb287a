"""What is needed to get the same result again: command, settings, model, versions."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Any

from workbench.command_line.files import json_text
from workbench.report.material import Material

TITLE = "To repeat this"
ORDER = 90


def context(material: Material) -> Mapping[str, Any] | None:
    """Return command, settings, model and versions."""
    from workbench.command import versions

    model = material.model
    data = "" if material.payload is None else base64.b64encode(json_text(material.payload).encode()).decode("ascii")
    terms = [term.name for term in getattr(model, "terms", ())]
    return {
        "command": material.command,
        "settings": dict(material.settings),
        "model": "" if model is None else f"{model.name}" + (f" with {', '.join(terms)}" if terms else ""),
        "versions": versions(),
        "seconds": material.seconds,
        "data": data,
    }
