"""Sentences on stderr about recordings that were read: each kind of finding once, with how many files have it alike."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from exoid.workbench.terminal.screen import warn

if TYPE_CHECKING:
    from exoid.measurement.recording import Recording


def say_findings(recordings: Sequence[Recording], args: argparse.Namespace) -> None:
    """Say what the audits of recordings warn of and, in one line, what was repaired, which --quiet leaves out.

    With --verbose each finding of each file. A mapping that was remembered is said every time.
    """
    from exoid.measurement.finding import alike_findings, file_of, more_files
    from exoid.measurement.reading.among import LEFT_OUT

    told = [
        finding
        for recording in recordings
        for finding in recording.findings
        if finding.severity != "info" or finding.check in ("mapping", LEFT_OUT)
    ]
    if getattr(args, "verbose", False):
        for finding in told:
            warn(finding.what if finding.check == LEFT_OUT else str(finding))
        return
    repaired = []
    for first, *others in alike_findings(told):
        if first.severity == "repaired":
            option = f" ({first.remedy})" if "--" in first.remedy else ""
            repaired.append(f"{file_of(first)}: {first.what}{more_files(others)}{option}")
        else:
            warn(first.what if first.check == LEFT_OUT else f"{first}{more_files(others)}")
    if repaired and not args.quiet:
        warn(f"repaired: {'; '.join(repaired)}; --verbose says where")
