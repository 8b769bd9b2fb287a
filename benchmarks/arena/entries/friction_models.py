"""How papers on servos choose a friction model: a few whole models, judged on recordings left out."""

from __future__ import annotations

from benchmarks.arena.columns import Table, torque_of
from benchmarks.arena.task import Answer, Task

TITLE = "friction models of servo papers"
MODELS = (
    (),
    ("stribeck",),
    ("load_friction",),
    ("viscous_quadratic",),
    ("stribeck", "load_friction"),
    ("stribeck", "viscous_quadratic"),
    ("stribeck", "load_friction", "viscous_quadratic"),
)
"""What is added to Coulomb and viscous friction, at every joint alike."""


def answer(task: Task) -> Answer:
    """Return the plainest model within a hundredth of the least error on recordings left out, joints one by one."""
    table, named = Table(task), list[str]()
    for joint in task.model.joint_names:
        errors = []
        for model in MODELS:
            tried = [*named, *(f"{effect}:{joint}" for effect in model if f"{effect}:{joint}" in table.best)]
            columns = [*table.base, *(k for name in tried for k in table.best[name])]
            errors.append((float(table.unseen(columns).sum()), tried))
        least = min(error for error, _ in errors)
        named = next(tried for error, tried in errors if error <= 1.01 * least)
    return Answer([(name,) for name in named], torque_of(task, named))
