"""The suspects: what each would explain on unseen motion, how sure that is, and what looks like it."""

from __future__ import annotations

from exoid.diagnosis.report.material import Context, Material
from exoid.diagnosis.report.sections.verdict import term, title
from exoid.diagnosis.report.sections.where import words
from exoid.diagnosis.report.wording import said_of, share
from exoid.diagnosis.sureness import meanings_of
from exoid.ground.text import without_empty

TITLE = "Suspects"
ORDER = 40
MOST = 10


def context(material: Material) -> Context:
    """Return the ranking and what is left unexplained."""
    if material.diagnosis is None:
        return None
    found, joints = material.diagnosis.to_json(), material.diagnosis.joints
    left = found.get("unexplained") or {"significant": False}
    variables = [words(name, joints) for name in left.get("variables", ())]
    rows = [
        (
            place,
            title(term(suspect), material.model),
            said_of(term(suspect), material.model) or "–",
            share(suspect["explained_share"]),
            suspect.get("sureness") or "–",
            ", ".join(title(other, material.model) for other in suspect["look_alikes"]) or "–",
            suspect.get("caution") or "–",
            suspect["p_value"],
            term(suspect),
        )
        for place, suspect in enumerate(found["suspects"][:MOST], start=1)
    ]
    degrees = {item.get("sureness", "") for item in found["suspects"][:MOST]}
    names = (
        "rank", "effect", "what it means", "explains", "how sure", "look-alikes in these data", "caution", "p-value",
        "id",
    )  # fmt: skip
    head, shown = without_empty(names, rows)
    return {
        "head": head,
        "rows": shown,
        "meanings": meanings_of(degrees - {material.diagnosis.sureness}),  # that one stands at the top of the page
        "pictures": material.pictures_in("suspects"),
        "more": max(0, len(found["suspects"]) - MOST),
        "unexplained": {"suggested_toml": [], **left, "variables": variables},
    }
