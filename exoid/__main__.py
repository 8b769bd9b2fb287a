"""The command `exoid`, also as `python -m exoid`."""

from __future__ import annotations

import sys

from exoid.ground.import_path import leave_out_current_folder

leave_out_current_folder()

from exoid.workbench.command import main  # noqa: E402 - what it imports is not to come from the current folder

if __name__ == "__main__":
    sys.exit(main())
