"""The motion to record: how good it is, what it makes of the limits, what it will tell."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from exoid.diagnosis.report.material import Context, Material
from exoid.diagnosis.report.wording import share

TITLE = "The motion to record"
ORDER = 12


def context(material: Material) -> Context:
    """Return the tables of a design or of a separating experiment; None for other results."""
    found = material.payload
    tables = {"exoid.design/1": _design, "exoid.separation/1": _separation}
    if not isinstance(found, Mapping) or found.get("schema") not in tables:
        return None
    limits = [
        (f"{limit['joint']} {limit['quantity']}", limit["low"], limit["high"], *limit["limit"], limit["unit"])
        for limit in found["limits"]
    ]
    return {
        **tables[found["schema"]](found),
        "limit_head": ("", "lowest", "highest", "limit", "limit", "unit"),
        "limit_rows": limits,
        "pictures": material.pictures_in("motion"),
    }


def _design(found: Mapping[str, Any]) -> Mapping[str, Any]:
    rows = [
        (name, p["value"], p["deviation"], p["unit"], share(p["relative"], ".2g"))
        for name, p in found["precision"].items()
    ]
    return {
        "kind": "design",
        "head": ("number", "assumed", "standard deviation", "unit", "relative"),
        "rows": rows,
        "duration": found["duration"],
        "assumed": [found["numbers"], f"noise: {found['noise']['source']}"],
        "notes": found["cautions"],
    }


def _separation(found: Mapping[str, Any]) -> Mapping[str, Any]:
    usual = [item["sigma"] for item in found["at_random"]]
    present = [entry["sigma"] for entry in found["present"] or ()]
    rows = [
        (element["truth"], element["rival"], element["sigma"], usual[k], present[k] if present else None)
        for k, element in enumerate(found["apart"])
    ]
    return {
        "kind": "separation",
        "head": ("true", "fitted", "designed", "at random", "present recordings"),
        "rows": rows,
        "duration": found["duration"],
        "notes": [way for pair in found["never"] for way in pair["ways"]],
        "assumed": [
            f"{rival['name']} with {', '.join(f'{n} = {v:.3g}' for n, v in rival['numbers'].items())} "
            f"({rival['source']})"
            for rival in found["rivals"]
        ],
    }
