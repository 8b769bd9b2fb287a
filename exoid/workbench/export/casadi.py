"""A serialised CasADi function: torque(t, q, dq, ddq, sign, memory), for optimal control and simulation in CasADi."""

from __future__ import annotations

import tempfile
from pathlib import Path

from exoid.workbench.identified import Options, Ready

HELP = "a CasADi function (load it with casadi.Function.load)"


def write(ready: Ready, options: Options) -> dict[str, str]:
    """Return {file name: text}."""
    with tempfile.TemporaryDirectory() as folder:  # what `load` reads, CasADi only writes to a file
        path = Path(folder) / "function"
        ready.torque.save(str(path))
        return {f"{options.name}.casadi": path.read_text(encoding="ascii")}
