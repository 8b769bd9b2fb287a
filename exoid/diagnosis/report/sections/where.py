"""Size of the error and its place: joint, variable, share."""

from __future__ import annotations

from collections.abc import Sequence

from exoid.diagnosis.evidence.curves import variables
from exoid.diagnosis.report.material import Context, Material
from exoid.diagnosis.report.wording import error_sizes, share
from exoid.ground.text import without_empty
from exoid.symbolic.joints import Joint

TITLE = "Where the model fails"
ORDER = 30


def context(material: Material) -> Context:
    """Return the size of the error per joint and the places where it is largest."""
    found = material.comparison
    if found is None:
        return None
    head, rows = without_empty(
        ("joint", "depends on", "share of the error", "what that means", "caution"),
        [
            (
                w.joint,
                words(w.variable, found.joints),
                share(w.share),
                w.sentence.removeprefix(f"{w.joint}: "),
                w.caution or "–",
            )
            for w in found.where
        ],
    )
    return {
        **dict(zip(("size_head", "size"), error_sizes(found), strict=True)),
        "head": head,
        "rows": rows,
        "pictures": material.pictures_in("where"),
    }


def words(variable: str, joints: Sequence[str]) -> str:
    """Return "knee velocity" for "dq2"; a name that is not a variable of the diagnosis stays what it is."""
    known = variables(tuple(Joint(name) for name in joints))
    return known[variable][0] if variable in known else variable
