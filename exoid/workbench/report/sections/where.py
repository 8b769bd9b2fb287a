"""How large the error is, and where it sits: joint, variable, share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from exoid.workbench.report.cells import share
from exoid.workbench.report.material import Material
from exoid.workbench.terminal.screen import without_empty

TITLE = "Where the model fails"
ORDER = 30


def context(material: Material) -> Mapping[str, Any] | None:
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


def error_sizes(found: Any) -> tuple[list[str], list[tuple[Any, ...]]]:
    """Return the head and the rows of a table with the size of the error of each joint beside that of its torque."""
    columns = {
        "torque": found.signal_rms,
        "error, fitted": found.rms,
        "error, unseen": (None,) * len(found.joints) if found.verify_rms is None else found.verify_rms,
        "noise floor": found.noise_floor,
    }
    rows = zip(found.joints, *columns.values(), strict=True)
    head = ["joint", *(f"{word} [{found.unit}]" for word in columns)]
    return head, [(joint, *(None if x is None else float(x) for x in values)) for joint, *values in rows]


def words(variable: str, joints: Sequence[str]) -> str:
    """Return "knee velocity" for "dq2"; a name that is not a variable of the diagnosis stays what it is."""
    from exoid.diagnosis.evidence.curves import variables
    from exoid.symbolic.joints import Joint

    known = variables(tuple(Joint(name) for name in joints))
    return known[variable][0] if variable in known else variable
