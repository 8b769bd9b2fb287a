"""The command `exoid`, also as `python -m exoid`."""

import os
import sys

CHECKOUT = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))

if __name__ == "__main__" and not sys.flags.safe_path and os.path.realpath(sys.path[0]) != CHECKOUT:
    del sys.path[0]  # `python -m` put the current folder there: a `pathlib.py` beside the recordings would be imported

from exoid.ground.import_path import leave_out_current_folder  # noqa: E402

leave_out_current_folder()

from exoid.workbench.command import main  # noqa: E402 - what it imports is not to come from the current folder

if __name__ == "__main__":
    sys.exit(main())
