"""Columns on their way to a recording: what can be used of them so far, and what was said of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exoid.measurement.finding import Finding, row_ranges
from exoid.symbolic.joints import LEG, Joint
from exoid.symbolic.motion import Float


@dataclass(frozen=True, eq=False)
class Draft:
    """Columns {canonical: (N,)} in SI units that may still hold NaN, with `valid` (N,) and `row` (N,).

    `missing` {canonical: (N,)} are cells of angles and torques that say nothing, in rows that are valid otherwise.
    """

    columns: Mapping[str, Float]
    valid: NDArray[np.bool_]
    row: NDArray[np.int64]
    told: frozenset[str]
    file: str
    findings: tuple[Finding, ...] = ()
    joints: tuple[Joint, ...] = LEG
    missing: Mapping[str, NDArray[np.bool_]] = field(default_factory=dict)

    def good(self, name: str) -> NDArray[np.bool_]:
        """Cells (N,) of a column that can be used."""
        return self.valid & ~self.missing[name] if name in self.missing else self.valid

    def without(self, name: str, cells: NDArray[np.bool_]) -> Draft:
        """Return the draft without the `cells` (N,) of a column: without whole rows where it is no angle or torque."""
        if name not in self.own:
            return replace(self, valid=self.valid & ~cells)
        known = self.missing.get(name, np.zeros_like(cells))
        return replace(self, missing={**self.missing, name: known | cells})

    @property
    def own(self) -> frozenset[str]:
        """Columns in which a cell may be missing by itself."""
        return frozenset(f"{key}{k + 1}" for key in ("q", "tau") for k in range(len(self.joints)))

    def rows(self, chosen: NDArray[Any]) -> Draft:
        """Return the draft of the rows `chosen`, in that order."""
        columns = {name: values[chosen] for name, values in self.columns.items()}
        missing = {name: cells[chosen] for name, cells in self.missing.items()}
        return replace(self, columns=columns, valid=self.valid[chosen], row=self.row[chosen], missing=missing)

    def noted(self, check: str, severity: str, what: str, where: str = "", **more: Any) -> Draft:
        """Return the draft with one finding more; `where` follows the file name."""
        place = f"{self.file}, {where}" if where else self.file
        return replace(self, findings=(*self.findings, Finding(check, severity, what, place, **more)))

    def mended(
        self, check: str, what: str, mask: NDArray[np.bool_], remedy: str, column: str = "", **more: Any
    ) -> Draft:
        """Return the draft with a note on what was repaired in the rows of `mask` (N,)."""
        rows = row_ranges(np.sort(self.row[mask]))
        where = f"column {column}, {rows}" if column else rows
        return self.noted(check, "repaired", what, where, value=float(mask.sum()), limit=0.0, remedy=remedy, **more)
