"""Look-alikes: on these recordings, or on any motion at all, and the experiment that would distinguish them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from exoid.diagnosis.report.material import Context, Material
from exoid.diagnosis.report.sections.verdict import term
from exoid.diagnosis.report.wording import said_of

TITLE = "Look-alikes"
ORDER = 45
APPENDIX = True
MOST = 5


def context(material: Material) -> Context:
    """Return one entry per accepted effect, and per leading suspect that has look-alikes; None where nothing leads."""
    if material.diagnosis is None:
        return None
    found = material.diagnosis.to_json()
    accepted = [_entry(item, material.model, added=True) for item in found.get("accepted", [])]
    names = {effect["name"] for effect in accepted}
    leading = [suspect for suspect in found["suspects"][:MOST] if suspect["look_alikes"]]
    suspects = [_entry(suspect, material.model, added=False) for suspect in leading]
    entries = accepted + [suspect for suspect in suspects if suspect["name"] not in names]
    return {"entries": entries} if entries else None


def _entry(one: Mapping[str, Any], model: Any, *, added: bool) -> Mapping[str, Any]:
    name = term(one)
    return {
        "name": name,
        "added": added,
        "here": [(other, said_of(other, model)) for other in one["look_alikes"]],
        "never": [(other, said_of(other, model)) for other in one.get("never_separable") or ()],
        "experiment": said_of(name, model, "tells_apart"),
    }
