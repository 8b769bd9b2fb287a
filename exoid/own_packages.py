"""Whether the packages that Python finds under the names exoid uses are exoid's own.

`measurement` or `workbench` are words that other distributions and a user's own files use too. The one found first
wins, and two installed into one environment overwrite each other's files.
"""

import os  # no module that Python has not loaded already, __future__ included, before the folder is taken back
import sys


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
    if os.path.realpath(sys.path[0]) == here != os.path.dirname(os.path.dirname(os.path.realpath(__file__))):
        del sys.path[0]


leave_out_folder_of_m()

from importlib.util import find_spec  # noqa: E402
from pathlib import Path  # noqa: E402

OWN = ("ground", "symbolic", "measurement", "optimisation", "diagnosis", "workbench")
MARK = {"ground": "Knows nothing of legs."}
"""Words in the `__init__.py` of a package that nobody else's has."""
LENDS = "from exoid.ground.lazy import lend"


def check_own_packages() -> None:
    """Raise ImportError where another package stands in the place of one of exoid's; say which, where, what to do."""
    home = Path(__file__).resolve().parents[1]
    for package in OWN:
        found = _origin(package)
        if found is not None and _is_ours(package, found, home):
            continue
        where = f"is {found}, which is not exoid's" if found else "is not there"
        raise ImportError(
            f"exoid needs its own package {package!r} in {home}, but what Python finds {where}\n"
            f"  what to do: {_remedy(package, found, home)}"
        )


def _origin(package: str) -> Path | None:
    spec = find_spec(package)
    return Path(spec.origin).resolve() if spec is not None and spec.origin else None


def _is_ours(package: str, found: Path, home: Path) -> bool:
    if found != home / package / "__init__.py":
        return False
    return MARK.get(package, LENDS) in found.read_text(encoding="utf-8")


def _remedy(package: str, found: Path | None, home: Path) -> str:
    if found is not None and home not in found.parents:
        return f"rename {found}, or start Python elsewhere; or install exoid into an environment of its own"
    return (
        "install exoid into an environment of its own: python -m venv NAME, then NAME/bin/pip install exoid "
        f"(pip list shows which other distribution brings a package {package!r})"
    )
