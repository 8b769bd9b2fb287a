"""The page of a campaign: the fleet at a glance, every job in a table that sorts and filters, links to the reports.

It needs no network. While the campaign runs it is written again every few seconds, and asks to be read again.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from exoid.apps.campaign.plan import Plan
from exoid.apps.campaign.pooled import pool
from exoid.apps.campaign.table import effect_name, parameters, table_of, unreadable
from exoid.ground.files import write_whole

FOLDER = Path(__file__).parent
SECONDS = 10
"""After this many seconds the page of a running campaign asks to be read again."""


def write_page(
    folder: Path, plan: Plan, rows: Sequence[Mapping[str, Any] | None], events: Sequence[str], *, running: bool
) -> Path:
    """Write `folder`/index.html about the `rows` that are there (None: not yet); return its path."""
    text = render_campaign(plan, rows, events, running=running)
    return write_whole(folder / "index.html", text, at_once=True, inside=folder)


def render_campaign(
    plan: Plan, rows: Sequence[Mapping[str, Any] | None], events: Sequence[str], *, running: bool
) -> str:
    """Return the page as HTML text; text from files is data in it, never markup."""
    from markupsafe import Markup

    from exoid.diagnosis.report.page import environment, report_style

    # Embedded as JSON in which nothing can end the script element; the page sets it as text.
    content = json.dumps(data(plan, rows, events, running=running), ensure_ascii=False).replace("<", "\\u003c")
    template = environment().from_string((FOLDER / "page.html").read_text("utf-8"))
    return template.render(
        title=plan.name, refresh=SECONDS if running else 0, data=Markup(content),
        style=Markup(report_style() + (FOLDER / "page.css").read_text("utf-8")),
        script=Markup((FOLDER / "page.js").read_text("utf-8")),
    )  # fmt: skip


def data(
    plan: Plan, rows: Sequence[Mapping[str, Any] | None], events: Sequence[str], *, running: bool
) -> dict[str, Any]:
    """Return the contents of the page as plain data."""
    done = [row for row in rows if row is not None]
    table = table_of(plan, done)
    heads = [
        head
        for head in dict.fromkeys(h for row in table for h in row)
        if any(r.get(head) not in ("", None) for r in table)
    ]
    hidden = {"report", "key", "versions"}  # versions: one campaign has one set, the table has them
    return {
        "running": running, "jobs": len(rows), "done": len(done),
        "status": dict(Counter(row["status"] for row in done)), "events": list(events)[-20:], "notes": list(plan.notes),
        "heads": [head for head in heads if head not in hidden],
        "rows": [[_rounded(row.get(head)) for head in heads if head not in hidden] + [row["report"]] for row in table],
        "fleet": fleet(plan, done), "history": [] if running else history(plan, done),
        "device": plan.device, "date": plan.date,
        "pooled": [] if running else [item.to_json() for item in pool(plan, done)],
        "unreadable": unreadable(done),
    }  # fmt: skip


def fleet(plan: Plan, rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return device × effect: in how many of a device's jobs each effect is accepted, and how many gave an answer."""
    if plan.device is None:
        return {}
    answered: Counter[str] = Counter()
    counts: dict[str, Counter[str]] = {}
    for row in rows:
        device = row["fields"].get(plan.device, "")
        if row["status"] != "done" or "verdict" not in row["result"]:
            continue
        answered[device] += 1
        for item in row["result"].get("accepted", []):
            counts.setdefault(effect_name(item), Counter())[device] += 1
    order = sorted(counts, key=lambda effect: (-sum(counts[effect].values()), effect))
    devices = sorted(answered)
    return {
        "devices": devices, "effects": order, "answered": [answered[d] for d in devices],
        "counts": [[counts[effect][device] for effect in order] for device in devices],
    }  # fmt: skip


def history(plan: Plan, rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return per parameter its values with intervals over dates and devices; empty where groups have no date."""
    if plan.date is None or plan.device is None:
        return []
    found: dict[str, dict[str, Any]] = {}
    for row in parameters(plan, rows):
        entry = found.setdefault(row["parameter"], {"parameter": row["parameter"], "unit": row["unit"], "points": []})
        if row["value"] is not None:
            numbers = [_rounded(row[key], 6) for key in ("value", "low", "high")]
            entry["points"].append([row[plan.date], row[plan.device], *numbers, row["job"]])
    return list(found.values())


def _rounded(value: Any, digits: int = 4) -> Any:
    return float(f"{value:.{digits}g}") if isinstance(value, float) else value
