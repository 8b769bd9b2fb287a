"""What a person touches: command line, figures, report.

In a notebook: `from exoid.workbench import main`; `main(["demo", "--out", "report"])`.
"""

from typing import TYPE_CHECKING

from exoid.ground.lazy import lend

if TYPE_CHECKING:
    from exoid.workbench.command import main as main

__all__ = lend(__name__)
