"""The command `exoid`, also as `python -m exoid`."""

from __future__ import annotations

import sys

from workbench.command import main

if __name__ == "__main__":
    sys.exit(main())
