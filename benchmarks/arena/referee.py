"""What answers are worth beside the truth: counts, errors and power, and the page that shows them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from benchmarks.arena.cases import kind_of
from exoid.diagnosis.grading import match

SAME = (
    ("com_offset_shank", "encoder_offset_knee"),
    ("gravity_tilt", "encoder_offset_hip"),
)
"""Names of the standard leg that no motion distinguishes: whoever says one says both."""
SIZES = (0.0, 1.0, 2.0, 4.0, 8.0, math.inf)
"""Of the effect, in units of noise: bounds of the table of power."""
Line = Mapping[str, Any]


def graded(truth: Sequence[str], names: Sequence[Sequence[str]]) -> tuple[int, int]:
    """Return how many hidden effects are named, and how many names answer for none."""
    named = [(one[0], [*one[1:], *(x for pair in SAME if one[0] in pair for x in pair)]) for one in names]
    found = sum(by is not None for by in match(list(truth), named).values())
    return found, len(named) - found


def right(line: Line, truth: Line) -> bool:
    """Whether exactly what is hidden is named, and the verdict, where one is given, is the one to be given."""
    found, wrong = graded(truth["hidden"], line["names"])
    told = truth.get("told", "")
    verdict = line.get("verdict", "").partition(":")[0]
    return found == len(truth["hidden"]) and not wrong and (not told or verdict in ("", told, "refused"))


def page(answers: Sequence[Line], truths: Mapping[str, Line], titles: Mapping[str, str]) -> str:
    """Return docs/arena.md: tables of all entries over the cases that all of them answered."""
    by_entry = {entry: {a["case"]: a for a in answers if a["entry"] == entry} for entry in titles}
    by_entry = {entry: own for entry, own in by_entry.items() if own}
    common = sorted(set.intersection(*(set(own) for own in by_entry.values()))) if by_entry else []
    if not common:
        return "No case was answered by every entry yet.\n"
    told = [case for case in common if truths[case]["hidden"]]
    empty = [case for case in common if not truths[case]["hidden"]]
    rows, power = [], []
    for entry, own in by_entry.items():
        grades = {case: graded(truths[case]["hidden"], own[case]["names"]) for case in common}
        hidden = sum(len(truths[case]["hidden"]) for case in common)
        away = [own[case]["away"] for case in common if own[case]["away"] is not None]
        rows.append(
            [
                titles[entry],
                _of(sum(right(own[case], truths[case]) for case in told), len(told)),
                _of(sum(right(own[case], truths[case]) for case in empty), len(empty)),
                _of(sum(found for found, _ in grades.values()), hidden),
                _of(sum(wrong > 0 for _, wrong in grades.values()), len(common)),
                f"{np.median(away):.2f}" if away else "",
                f"{np.mean(away):.2f}" if away else "",
                f"{np.median([own[case]['seconds'] for case in common]):.1f}",
            ]
        )
        power.append([titles[entry], *_power(told, truths, lambda case, own=own: right(own[case], truths[case]))])
    head = ["entry", "right, something hidden", "right, nothing to name", "effects named", "cases with a wrong name"]
    head += ["unseen error, median", "mean", "s of CPU, median"]
    sizes = [f"{low:g} to {high:g}" for low, high in pairwise(SIZES)]
    kinds = sorted({kind_of(case) for case in common})
    by_kind = [
        [
            kind,
            *(
                _of(
                    sum(right(own[c], truths[c]) for c in common if kind_of(c) == kind),
                    sum(kind_of(c) == kind for c in common),
                )
                for own in by_entry.values()
            ),
        ]
        for kind in kinds
    ]
    return "\n".join(
        [
            f"{len(common)} cases were answered by every entry.",
            "",
            *_table(head, rows),
            "",
            "## Power: share of cases right against the size of what is hidden, in units of noise",
            *_table(["entry", *sizes], power),
            "",
            "## Right by kind of case",
            *_table(["plant, kind", *(titles[entry] for entry in by_entry)], by_kind),
            "",
        ]
    )


def _power(cases: Sequence[str], truths: Mapping[str, Line], is_right: Callable[[str], bool]) -> list[str]:
    out = []
    for low, high in pairwise(SIZES):
        some = [case for case in cases if low <= truths[case]["size"] < high]
        out.append(_of(sum(is_right(case) for case in some), len(some)))
    return out


def _of(count: int, all_: int) -> str:
    return f"{count} of {all_}" if all_ else ""


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    return ["| " + " | ".join(row) + " |" for row in (head, ["---"] * len(head), *rows)]
