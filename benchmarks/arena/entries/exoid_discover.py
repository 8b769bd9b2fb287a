"""exoid as a user calls it: three recordings to fit, one to verify."""

from __future__ import annotations

from benchmarks.arena.task import Answer, Task
from exoid.diagnosis.discovery import discover

TITLE = "exoid, `discover`"


def answer(task: Task) -> Answer:
    """Return what `discover` accepts and the torque of the model that it ends with."""
    found = discover(task.model, task.recordings[:3], task.recordings[3:])
    names = [(one.name, *sorted({*one.look_alikes, *one.never_separable})) for one in found.accepted]
    fit = found.fit
    return Answer(names, fit.model.torque(task.motion, fit.linear, fit.shape), found.verdict)
