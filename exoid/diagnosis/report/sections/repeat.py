"""Data needed to get the same result again: command, settings, model, versions."""

from __future__ import annotations

import base64

from exoid.diagnosis.report.material import Context, Material, without_folders
from exoid.ground.output import json_text
from exoid.ground.version import versions

TITLE = "To repeat this"
ORDER = 90


def context(material: Material) -> Context:
    """Return command, settings, model and versions."""
    from markupsafe import Markup

    model = material.model
    text = "" if material.payload is None else without_folders(json_text(material.payload))
    terms = [term.name for term in getattr(model, "terms", ())]
    return {
        "command": material.command,
        "settings": dict(material.settings),
        "model": "" if model is None else f"{model.name}" + (f" with {', '.join(terms)}" if terms else ""),
        "versions": versions(),
        "seconds": material.seconds,
        "data": Markup(base64.b64encode(text.encode()).decode("ascii")),
    }
