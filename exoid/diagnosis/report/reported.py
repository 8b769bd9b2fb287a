"""A result that writes its report: `found.report("out")`; the commands say of the same what else they know."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from pathlib import Path

from exoid.diagnosis.report.material import Material
from exoid.diagnosis.report.page import write_report
from exoid.ground.plain import AsJson


class Reported(AsJson):
    """A result that writes its report."""

    @abstractmethod
    def material(self) -> Material:
        """Material that the report draws on, the recordings apart."""

    def report(self, folder: str | Path = "exoid-report") -> Path:
        """Write the report into `folder`, made where there is none, and return the path of the page.

        OutputError where it cannot be written.
        """
        return write_report(replace(self.material(), payload=self.to_json()), folder)
