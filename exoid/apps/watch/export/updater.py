"""The estimator that follows the model's parameters while the controller runs, in C99."""

from __future__ import annotations

from exoid.apps.watch.front import CUTOFF
from exoid.apps.watch.updater import write_updater
from exoid.workbench.identified import Options, Ready

HELP = "C that follows the model's parameters while the controller runs; needs --sample-time"
ON_REQUEST = True


def write(ready: Ready, options: Options) -> dict[str, str]:
    """Return {file name: text}; ExportError without a sample time, or for an effect with memory."""
    return write_updater(
        ready.model, ready.numbers, name=options.name, sample_time=options.sample_time, cutoff=CUTOFF
    )
