"""Sentences on stderr about recordings that were read: each kind of finding once, with how many files have it alike."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from pathlib import PurePath
from typing import TYPE_CHECKING

from exoid.workbench.terminal.screen import warn

if TYPE_CHECKING:
    from exoid.measurement.finding import Finding
    from exoid.measurement.recording import Recording


def say_findings(recordings: Sequence[Recording], args: argparse.Namespace) -> None:
    """Say what the audits of recordings warn of and, in one line, what was repaired, which --quiet leaves out.

    With --verbose each finding of each file. A mapping that was remembered is said every time. In which convention they
    are is left to the answer, which asks all of them together.
    """
    from exoid.measurement.auditing.convention import CHECKS as CONVENTION
    from exoid.measurement.reading.among import LEFT_OUT

    told = [
        finding
        for recording in recordings
        for finding in recording.findings
        if finding.check not in CONVENTION and (finding.severity != "info" or finding.check in ("mapping", LEFT_OUT))
    ]
    if getattr(args, "verbose", False):
        for finding in told:
            warn(finding.what if finding.check == LEFT_OUT else str(finding))
        return
    repaired = []
    for first, *others in _alike(told):
        if first.severity == "repaired":
            option = f" ({first.remedy})" if "--" in first.remedy else ""
            repaired.append(f"{_file(first)}: {first.what}{_more(others)}{option}")
        else:
            warn(first.what if first.check == LEFT_OUT else f"{first}{_more(others)}")
    if repaired and not args.quiet:
        warn(f"repaired: {'; '.join(repaired)}; --verbose says where")


def _alike(findings: Sequence[Finding]) -> list[list[Finding]]:
    """Return the findings in groups of those that say the same but for their numbers, one of each file."""
    groups: dict[tuple[str, str, str], list[Finding]] = {}
    for item in findings:
        groups.setdefault((item.severity, item.check, re.sub(r"\d[\d.,]*", "#", item.what)), []).append(item)
    return list(groups.values())


def _file(finding: Finding) -> str:
    return PurePath(finding.where.partition(",")[0]).name


def _more(others: Sequence[Finding]) -> str:
    names = list(dict.fromkeys(_file(other) for other in others))
    if not names:
        return ""
    return f", alike in {names[0]}" if len(names) == 1 else f", alike in {len(names)} more files"
