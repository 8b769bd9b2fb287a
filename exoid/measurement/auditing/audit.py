"""The audit: every file in `checks/` looks at the recording; nothing is registered anywhere.

A check is a module with `def check(recording) -> list[Finding]`. It must not change the recording and must
not raise; what makes a recording unusable is a finding of severity "refused".
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from exoid.ground.folder import modules_in
from exoid.measurement.auditing import checks
from exoid.measurement.finding import SEVERITIES, Finding
from exoid.measurement.recording import Recording


@cache
def find_checks() -> dict[str, Callable[[Recording], list[Finding]]]:
    """Return {file name: check} of every module in `exoid/measurement/auditing/checks/`."""
    return {name: module.check for name, module in modules_in(checks).items()}


def audit(recording: Recording) -> tuple[Finding, ...]:
    """Return the findings of every check of `recording`, worst first; findings it already carries are kept in front."""
    found = [finding for check in find_checks().values() for finding in check(recording)]
    found.sort(key=lambda finding: SEVERITIES.index(finding.severity))
    return recording.findings + tuple(found)
