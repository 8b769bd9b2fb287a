"""The workbench that a person uses: command line, figures, report.

In a notebook: `from exoid.workbench import main`; `main(["demo", "--out", "report"])`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
