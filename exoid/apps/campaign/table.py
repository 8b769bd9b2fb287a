"""The answers of a campaign as tables: a row per job, a row per parameter, a row per recording that cannot be read."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from exoid.apps.campaign.copies import same_recordings
from exoid.apps.campaign.plan import Plan
from exoid.apps.campaign.store import job_file_name
from exoid.diagnosis.report.sections.verdict import term
from exoid.ground.files import write_whole

FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""What a spreadsheet takes for a formula at the start of a cell: a name from a file is not one."""


def flat(plan: Plan, row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row of the table of jobs: fields, status, verdict, effects with values, errors before and after."""
    result = row.get("result") or {}
    accepted = result.get("accepted") or []
    out: dict[str, Any] = {"job": row["name"], **{name: row["fields"].get(name, "") for name in plan.fields}}
    out |= {
        "status": row["status"],
        "verdict": result.get("verdict", ""),
        "effects": "; ".join(map(effect_name, accepted)),
    }
    out["values"] = "; ".join(filter(None, map(effect_values, accepted)))
    out["possible"] = "; ".join(effect_name(one) for one in result.get("possible") or [])
    out["look_alikes"] = "; ".join(sorted({name for one in accepted for name in one.get("look_alikes", [])}))
    for label, values in errors(result).items():
        for k, value in enumerate(values):
            out[f"{label}_{_joint(result, k)}"] = value
    out |= {
        "recordings": len(row["recordings"]),
        "verify": len(row["verify"]),
        "unreadable": len(row.get("unreadable", [])),
    }
    out["reason"] = row.get("reason", "")
    out["versions"] = ", ".join(f"{name} {number}" for name, number in sorted(row.get("versions", {}).items()))
    report = f"reports/{job_file_name(row['name'], row['key'])}.html" if row.get("report") else ""
    return out | {"report": report, "key": row["key"]}


def table_of(plan: Plan, rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return the table of jobs; where recordings are copies of others, with a column that says of which."""
    lines, same = [flat(plan, row) for row in rows], same_recordings(rows)
    if any(same):
        lines = [{**line, "same_recordings": text} for line, text in zip(lines, same, strict=True)]
    return lines


def effect_name(one: Mapping[str, Any]) -> str:
    """Return "stribeck:knee" of an entry of `accepted` or `possible`, from recordings or from a simulated leg."""
    return str(one["name"]) if "name" in one else term(one)


def effect_values(one: Mapping[str, Any]) -> str:
    """Return the numbers of an accepted effect with their 95 % intervals, "load_friction:knee c = 0.22 [0.2, 0.24]"."""
    parts = [_with_interval(name, number) for name, number in (one.get("parameters") or {}).items()]
    return f"{effect_name(one)} {', '.join(parts)}" if parts else ""


def _with_interval(name: str, number: Mapping[str, Any]) -> str:
    value, low, high = (number.get(key) for key in ("value", "low", "high"))
    interval = "" if low is None or high is None else f" [{low:.4g}, {high:.4g}]"
    unit = "" if number.get("unit") in (None, "1") else number["unit"]
    return f"{name} = " + ("unknown" if value is None else f"{value:.4g}{interval} {unit}".rstrip())


def errors(result: Mapping[str, Any]) -> dict[str, Sequence[float]]:
    """Return RMS per joint in N·m, of held-out recordings where there are some: first and last model, noise floor."""
    found: dict[str, Sequence[float]] = {}
    steps = result.get("steps") or []
    if steps:
        first, last = steps[0], steps[-1]
        found["rms_before"] = first["verify_rms"] or first["train_rms"]
        found["rms_after"] = last["verify_rms"] or last["train_rms"]
    elif isinstance(result.get("rms"), dict):  # a simulated leg
        found["rms_before"], found["rms_after"] = result["rms"]["base"], result["rms"]["found"]
    elif result.get("rms_before"):  # a recording that was watched
        found |= {label: result[label] for label in ("rms_before", "rms_after")}
    elif result.get("rms"):
        found["rms_before"] = result.get("verify_rms") or result["rms"]
    floor = result.get("noise_floor") or result.get("floor")
    return found | ({"noise_floor": floor} if floor else {})


def parameters(plan: Plan, rows: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return a row per parameter of every job: value, unit, and the 95 % interval from `low` to `high`."""
    out = []
    for row in rows:
        for name, one in ((row.get("result") or {}).get("parameters") or {}).items():
            fields = {field: row["fields"].get(field, "") for field in plan.fields}
            numbers = {key: one.get(key) for key in ("value", "low", "high")}
            out.append({"job": row["name"], **fields, "parameter": name, **numbers, "unit": one.get("unit", "")})
    return out


def blind_lines(rows: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Results of blind trials as `trials.count` takes them; what broke down counts as wrong."""
    out = []
    for row in rows:
        hidden = [name for name in row["fields"]["hidden"].split("+") if name]
        blank = {"case": row["name"], "kind": row["fields"]["kind"], "hidden": dict.fromkeys(hidden)}
        out.append(row["result"] if row["status"] == "done" else blank | {"error": row.get("reason", row["status"])})
    return out


def unreadable(rows: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return a row per recording that could not be read, with the reason."""
    return [{"job": row["name"], **one} for row in rows for one in row.get("unreadable", [])]


def write_tables(folder: Path, plan: Plan, rows: Sequence[Mapping[str, Any]]) -> list[Path]:
    """Write table, parameters and unreadable recordings as CSV, and as Parquet where pyarrow is installed."""
    tables = {
        "table": table_of(plan, rows),
        "parameters": parameters(plan, rows),
        "unreadable": unreadable(rows),
    }
    written = []
    for name, content in tables.items():
        if not content:
            for suffix in ("csv", "parquet"):
                (folder / f"{name}.{suffix}").unlink(missing_ok=True)
            continue
        heads = list(dict.fromkeys(key for row in content for key in row))
        written.append(write_whole(folder / f"{name}.csv", _csv(content, heads), at_once=True, inside=folder))
        parquet = _parquet(content, heads)
        if parquet is not None:
            written.append(write_whole(folder / f"{name}.parquet", parquet, at_once=True, inside=folder))
    return written


def has_parquet() -> bool:
    """Whether pyarrow is installed, so that tables are written as Parquet too."""
    import importlib.util

    return importlib.util.find_spec("pyarrow") is not None


def _csv(rows: Sequence[Mapping[str, Any]], heads: Sequence[str]) -> bytes:
    stream = io.StringIO(newline="")
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(heads)
    for row in rows:
        writer.writerow([_cell(row.get(head)) for head in heads])
    return stream.getvalue().encode("utf-8")


def _cell(value: Any) -> Any:
    if isinstance(value, str):
        return f"'{value}" if value.startswith(FORMULA) else value
    return "" if value is None else json.dumps(value)


def _parquet(rows: Sequence[Mapping[str, Any]], heads: Sequence[str]) -> bytes | None:
    if not has_parquet():
        return None
    import pyarrow as pa
    from pyarrow import parquet

    table = pa.table({head: [row.get(head) for row in rows] for head in heads})
    stream = io.BytesIO()
    parquet.write_table(table, stream)
    return stream.getvalue()


def _joint(result: Mapping[str, Any], k: int) -> str:
    joints = result.get("joints") or ("hip", "knee")
    return str(joints[k]) if k < len(joints) else str(k + 1)
