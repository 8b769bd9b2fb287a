"""Where Python looks for exoid's packages, and which folder it does not look into.

In a checkout `symbolic/`, `diagnosis/` and the others lie beside `exoid/`, installed they lie in it; they are called
`exoid.symbolic` and so on in both.
"""

import os  # no module that Python has not loaded already, __future__ included, before the folder is taken back
import sys

HERE = os.path.dirname(os.path.realpath(__file__))


def leave_out_folder_of_m() -> None:
    """Take back what `python -m exoid` put first on the path, the current folder, unless exoid lies there: a checkout.

    A `pathlib.py` beside the recordings would be imported from it.
    """
    if sys.argv[:1] != ["-m"] or sys.flags.safe_path:  # "-m" stands there while Python looks for what it is to run
        return
    try:
        here = os.path.realpath(os.getcwd())
    except OSError:  # removed meanwhile: nothing can be imported from it
        return
    if os.path.realpath(sys.path[0]) == here != os.path.dirname(HERE):
        del sys.path[0]


def folders_of_packages() -> list[str]:
    """Return the folders in which the packages are looked for, as `__path__` of exoid.

    The links that lie in a checkout's `exoid/` are for editors and type checkers. They are not followed here: a clone
    may be without them, and a traceback is to name the file that one edits.
    """
    inside = os.path.join(HERE, "symbolic")
    installed = os.path.isdir(inside) and not os.path.islink(inside)
    return [HERE] if installed else [os.path.dirname(HERE), HERE]
