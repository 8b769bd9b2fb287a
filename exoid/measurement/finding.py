"""A finding of an audit about a recording: where, how sure, what it would do to the result, what to do."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exoid.ground.plain import AsJson

SEVERITIES = ("refused", "warning", "repaired", "info")
"""Worst first. "repaired": mended without guessing and therefore only reported; "refused": cannot be used."""

EVERY = "all recordings"
"""Where a finding is that is about all of them."""
SELECTION = "selection"
"""What a finding is called that says which rows are left out by choice."""


@dataclass(frozen=True)
class Finding(AsJson):
    """One observation about one recording.

    `what` is a sentence, `where` names file, column and rows, `value` the number seen and `limit` the number
    it was compared with (None where there is none), `consequence` says what it would do to the result,
    `confidence` is "certain", "likely" or "possible", `remedy` says what to do; `option` is the convention in which
    all recordings may be, as `--convention` takes it.
    """

    check: str
    severity: str
    what: str
    where: str = ""
    value: float | None = None
    limit: float | None = None
    remedy: str = ""
    consequence: str = ""
    confidence: str = "certain"
    option: str = ""

    @property
    def repaired(self) -> bool:
        """True if it was mended."""
        return self.severity == "repaired"

    def __post_init__(self) -> None:
        if self.severity not in SEVERITIES:
            raise ValueError(f"severity {self.severity!r} is not one of {SEVERITIES}")

    def __str__(self) -> str:
        place = f"{self.where}: " if self.where else ""
        advice = f" ({self.remedy})" if self.remedy else ""
        return f"{self.severity}: {place}{self.what}{advice}"

    def _json(self) -> dict[str, Any]:
        told = super()._json()
        del told["option"]  # the remedy says it
        return {**told, "repaired": self.repaired}


def alike_findings(findings: Iterable[Finding]) -> list[list[Finding]]:
    """The findings in groups of those that say the same but for their numbers."""
    groups: dict[tuple[str, str, str], list[Finding]] = {}
    for item in findings:
        groups.setdefault((item.severity, item.check, re.sub(r"\d[\d.,]*", "#", item.what)), []).append(item)
    return list(groups.values())


def file_of(finding: Finding) -> str:
    """Name of the file that a finding is about."""
    return PurePath(finding.where.partition(",")[0]).name


def more_files(others: Sequence[Finding]) -> str:
    """Words for the files of findings that are told with the first of their kind: ", alike in 5 more files"."""
    names = list(dict.fromkeys(map(file_of, others)))
    if not names:
        return ""
    return f", alike in {names[0]}" if len(names) == 1 else f", alike in {len(names)} more files"


def row_ranges(rows: NDArray[np.integer[Any]], most: int = 4) -> str:
    """Return row numbers as text: "rows 12-15, 40, 77-80 and 3 more ranges"; `rows` in ascending order."""
    rows = np.asarray(rows)
    if rows.size == 0:
        return ""
    cuts = np.flatnonzero(np.diff(rows) != 1)
    first, last = rows[np.r_[0, cuts + 1]], rows[np.r_[cuts, rows.size - 1]]
    texts = [str(a) if a == b else f"{a}-{b}" for a, b in zip(first[:most], last[:most], strict=True)]
    more = f" and {first.size - most} more ranges" if first.size > most else ""
    return f"row{'s' if rows.size > 1 else ''} {', '.join(texts)}{more}"
