"""What a person touches: command line, figures, report.

In a notebook: `from workbench import main`; `main(["demo", "--out", "report"])`.
"""

from typing import TYPE_CHECKING

from ground.lazy import lend

if TYPE_CHECKING:
    from workbench.command import main as main

__all__ = lend(__name__)
