"""Counts of blind trials that went right, by kind, and names of those that went wrong.

A case is *right* when exactly as much is accepted as was hidden, and each hidden effect is an accepted one or among its
look-alikes; `outside` is right when nothing is accepted and what is left is reported at the right joint in the right
variable; `convention` is right when the option that reads the recordings rightly is named and nothing is accepted;
where a person or the ground pushes and nobody measured it, *unexplained* is right, with nothing accepted, and of a walk
with the sentence that something outside the model pushes.

A case that was missed *could not be told* where knowing the structure of what is hidden would have lowered the error on
unseen motion, of the given model or of what was named instead, by less than what `discover` asks of any candidate: a
gap of which the recordings show no more than the spring behind it. It stays a miss, and is counted apart.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from exoid.apps.campaign.trials.cases import KINDS, OUTSIDE
from exoid.apps.campaign.trials.chains import CHAINS
from exoid.apps.campaign.trials.machines import CONVENTION
from exoid.apps.campaign.trials.people import PEOPLE, SUSPECTED, UNMEASURED, WALKING
from exoid.diagnosis.grading import match
from exoid.diagnosis.rules import RULES


def matched(line: Mapping[str, Any]) -> tuple[int, int]:
    """Numbers of hidden effects found (each by another accepted one) and of accepted ones that are extra."""
    answers = match(list(line["hidden"]), [(a["name"], a["look_alikes"]) for a in line["accepted"]])
    found = sum(by is not None for by in answers.values())
    return found, len(line["accepted"]) - found


def right(line: Mapping[str, Any]) -> bool:
    """True if the answer is what a user should have been told."""
    if "error" in line:
        return False
    if line["kind"] == "outside":
        (name,) = line["hidden"]
        effect, variables = OUTSIDE[name]
        rest = line["unexplained"]
        placed = rest["joint"] == effect.joints[0] and bool({*rest["variables"]} & {*variables})
        return line["verdict"] == "unexplained" and placed
    if line["kind"] == CONVENTION:
        option = line["case"].split("/")[1]
        return line["verdict"] == "check_channels" and f"--convention {option.replace('+', ',')}" in line["next"]
    if line["kind"] in UNMEASURED:
        said = line["kind"] not in WALKING or SUSPECTED in line["says"]
        return line["verdict"] == "unexplained" and not line["accepted"] and said
    found, extra = matched(line)
    return found == len(line["hidden"]) and extra == 0 and (bool(line["hidden"]) or line["verdict"] == "adequate")


def excess(line: Mapping[str, Any]) -> float:
    """Return the unseen error after `discover` over that of the true structure, the worse joint."""
    return float(np.max(np.array(line["rms"]["found"]) / np.array(line["rms"]["true"])))


def tellable(line: Mapping[str, Any]) -> bool:
    """True if knowing what is hidden would have lowered the squared error on unseen motion enough at some joint, both
    that of the given model and that of what was found.
    """
    true = np.array(line["rms"]["true"])
    gains = [np.max(1.0 - np.square(true / np.array(line["rms"][key]))) for key in ("base", "found")]
    return bool(min(gains) >= RULES.least_share)


_BOTH = frozenset((*CHAINS, *PEOPLE))
"""Kinds with an effect, and with nothing hidden."""
HEADS = (
    "kind", "cases", "right", "extra", "missed", "could not be told", "look-alikes", "error/true (median, worst)",
    "covered",
)  # fmt: skip


def counted(lines: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    """Return one row per kind, in the order of `HEADS`."""
    rows: list[tuple[str, ...]] = []
    for kind, quiet in itertools.product(KINDS, (False, True)):
        some = [line for line in lines if line["kind"] == kind and quiet == (kind in _BOTH and not line["hidden"])]
        good = [line for line in some if "error" not in line]
        if not some:
            continue
        extra = sum(matched(line)[1] > 0 for line in good)
        missed = [line for line in good if matched(line)[0] < len(line["hidden"])]
        asked = kind not in ("none", "outside", CONVENTION, *UNMEASURED) and not quiet
        alike = [len(a["look_alikes"]) for line in good for a in line["accepted"]]
        ratios = [excess(line) for line in good] or [math.nan]
        covered = [ok for line in good for ok in line["covered_true"]]
        rows.append(
            (
                f"{kind}, nothing hidden" if quiet else kind,
                str(len(some)),
                f"{100 * sum(map(right, some)) / len(some):.1f} %",
                str(extra),
                str(len(missed)) if asked else "",
                str(sum(not tellable(line) for line in missed)) if asked else "",
                f"{np.mean(alike):.2f}" if alike else "",
                f"{np.median(ratios):.3f}, {max(ratios):.3f}",
                f"{100 * np.mean(covered):.1f} %" if covered else "",
            )
        )
    return rows


def describe_miss(line: Mapping[str, Any]) -> str:
    """Return one wrong case in a line."""
    if "error" in line:
        return f"{line['case']}: {line['error']}"
    named = [a["name"] + (f" ~ {', '.join(a['look_alikes'])}" if a["look_alikes"] else "") for a in line["accepted"]]
    rest = line["unexplained"]
    left = f"; left: {rest['joint']} {rest['variables']}" if rest["significant"] else ""
    error = f"error/true {excess(line):.2f}"
    missed = matched(line)[0] < len(line["hidden"])
    told = "; could not be told" if missed and not tellable(line) else ""
    return f"{line['case']}: {line['verdict']} [{'; '.join(named) or 'nothing accepted'}]{left}; {error}{told}"
