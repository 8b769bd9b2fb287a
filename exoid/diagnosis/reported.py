"""What results have from the workbench, which lies above them: their report."""

from __future__ import annotations

from pathlib import Path


class Reported:
    """A result that writes its report."""

    def report(self, folder: str | Path = "exoid-report") -> Path:
        """Write the report into `folder`, made where there is none, and return the path of the page.

        OutputError where it cannot be written.
        """
        from exoid.workbench.report.result import write_result

        return write_result(self, folder)
