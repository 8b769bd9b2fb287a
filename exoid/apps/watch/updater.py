"""The recursive estimator in C99: a struct, no allocation, no dependency but math.h; the numbers of
`exoid.apps.watch.recursive.estimator` step by step.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from exoid.apps.watch.front import COMMON_ORDER, HALF, LONGEST_HOLE, ORDER, SIGN_WIDTH, SPIKE, Filters
from exoid.apps.watch.recursive.encoder_noise import DIFFERENCE, MIDDLE, following
from exoid.apps.watch.recursive.estimator import (
    FORGOTTEN,
    FORGOTTEN_LEAST,
    LEAST_BLOCKS,
    ROBUST,
    Estimator,
    constants,
)
from exoid.apps.watch.recursive.estimator_c import part_of_c
from exoid.apps.watch.window import STEADY
from exoid.ground.text import filled, in_comment
from exoid.measurement.reading.limits import ABSURD, FASTEST, LASTING, LATEST
from exoid.optimisation.preparation.sticking import STICK
from exoid.symbolic.codegen.instructions import PLAIN, scalar_c
from exoid.symbolic.model import Model
from exoid.symbolic.model_file import Numbers
from exoid.symbolic.model_structure import require_no_force, require_still_base
from exoid.symbolic.motion import Float
from exoid.workbench.identified import ExportError

if TYPE_CHECKING:
    import numpy as np

USUAL_SCALE = 0.5
"""N·m; the scale of the residual at first, where the model file does not say its Huber thresholds."""
SPREAD, LEAST = 0.3, 0.05
"""A number is known to this part of itself at first, and to no less than this in its unit."""


def write_updater(
    model: Model, numbers: Numbers, *, name: str, sample_time: float | None, cutoff: float
) -> dict[str, str]:
    """Return {file name: text} of the estimator for a loop of period `sample_time` s; ExportError where that is not
    given, or the model has an effect with memory.
    """
    if sample_time is None:
        raise ExportError("the updater needs the period of the control loop", remedy="add --sample-time SECONDS")
    require_still_base(model, "the updater")
    require_no_force(model, "the updater")
    import numpy as np

    function = _columns(model, numbers)
    linear = np.array([numbers.linear[p.name] for p in model.parameters])
    filters = Filters(1.0 / sample_time, cutoff)
    unit = residual_scale(model, numbers)
    start = first_estimator(model, linear, unit, filters.working / filters.stride)
    joints, count = len(model.joints), len(model.parameters)
    values = {
        "FIELDS": part_of_c("fields.h").rstrip(), "ESTIMATION": part_of_c("step.c"),
        "FORGETTING": part_of_c("forget.c"), "SPREADING": part_of_c("spread.c"), "DIFFERENCE": _list(DIFFERENCE),
        "QUIET": repr(MIDDLE * float(DIFFERENCE @ DIFFERENCE)), "LISTEN": repr(following(filters.rate)),
        "ROUGH": repr(filters.roughness),
        "TYPE": f"{name}_updater", "name": name, "guard": f"{name}_updater_h".upper(),
        "J": joints, "P": count, "W": count + 2, "MODEL": in_comment(model.name),
        "NAMES": ", ".join(f"{k}: {in_comment(f'{p.name} [{p.unit}]')}" for k, p in enumerate(model.parameters)),
        "JOINTS": ", ".join(model.joint_names), "TS": repr(sample_time), "RATE": repr(filters.rate),
        "HALF": HALF, "RING": 2 * HALF + 1, "SPIKE": repr(SPIKE), "ORDER": ORDER, "COMMON": COMMON_ORDER,
        "KEEP": repr(filters.keep), "SECOND": repr(filters.common), "FACTOR": filters.factor,
        "STRIDE": filters.stride, "STICK": repr(STICK), "REACH": repr(filters.reach * filters.rate / filters.lag),
        "LAG": filters.lag, "SIGN": repr(SIGN_WIDTH),
        "RINGING": filters.ringing, "ABSURD": repr(ABSURD), "LATEST": repr(LATEST), "FASTEST": repr(FASTEST),
        "FARTHEST": repr(FASTEST * sample_time), "LASTING": repr(LASTING), "LONGEST": int(LONGEST_HOLE / sample_time),
        "LEAST": repr(STEADY), "ENOUGH": repr(LEAST_BLOCKS),
        "FORGOTTEN": repr(FORGOTTEN), "FORGOTTEN_LEAST": repr(FORGOTTEN_LEAST),
        **constants(start), "DELAY": f"{filters.delay:.3g}",
        "LINEAR": _list(linear), "SPREAD": _list(np.sqrt(start.variance)), "FORGET": _list(start.pace),
        "UNIT": _list(unit), "BODY": _body(function, joints),
        "OPERATIONS": _operations(function, joints, count, filters),
    }  # fmt: skip
    texts = {end: Path(__file__).with_name(f"updater.{end}.in").read_text("utf-8") for end in ("h", "c")}
    return {f"{name}_updater.{end}": filled(text, values) for end, text in texts.items()}


def first_estimator(model: Model, linear: Float, unit: Float, rate: float) -> Estimator:
    """Return an estimator that begins at identified parameters (P,); `unit` (J,) N·m is the scale of the residual."""
    return Estimator.start(model, linear, SPREAD * abs(linear) + LEAST, unit, rate)


def residual_scale(model: Model, numbers: Numbers) -> np.ndarray:
    """Return the scale (J,) of the residual at first, N·m."""
    import numpy as np

    if numbers.delta is None:
        return np.full(len(model.joints), USUAL_SCALE)
    return np.maximum(np.array(numbers.delta) / ROBUST, 1e-3)


def _columns(model: Model, numbers: Numbers) -> Any:
    """Return the CasADi function of all columns (J · P,), row by row, at the identified parameters."""
    import casadi as ca

    from exoid.symbolic.codegen.equation import model_expressions

    x = model_expressions(model)
    if x.memories:
        raise ExportError(
            "the model has an effect with memory, whose columns the updater cannot follow",
            remedy="leave that effect out of the model, or estimate in Python with exoid watch",
        )
    joints, count = len(model.joints), len(model.parameters)
    cells = [ca.SX(0)] * (joints * count)
    for j, p, expression in x.columns:
        cells[j * count + p] = cells[j * count + p] + expression
    linear = ca.SX(ca.DM([numbers.linear[p.name] for p in model.parameters]))
    shape = ca.SX(ca.DM([numbers.shape[s.name] for s in model.shapes]))
    put = ca.substitute([ca.densify(ca.vertcat(*cells))], [x.linear, x.shape], [linear, shape])[0]
    given = [x.t, x.q, x.dq, x.ddq, x.sign]
    return ca.Function("columns", given, [put], ["t", "q", "dq", "ddq", "sign"], ["columns"], {"cse": True})


def _body(function: Any, joints: int) -> str:
    names = [("t",), *(tuple(f"{word}[{j}]" for j in range(joints)) for word in ("q", "dq", "ddq", "sign"))]
    return scalar_c(function, names, "columns[{k}] = {value};", PLAIN)


def _operations(function: Any, joints: int, count: int, filters: Filters) -> str:
    """Return the operations that a period takes, in words; counted, not measured."""
    always = 2 * joints * ORDER * 3 + joints * (2 * HALF + 1) ** 2
    working = function.n_instructions() + joints * (count + 2) * COMMON_ORDER * 3
    kept = joints * (6 + 3 * joints) * count**2 + count**3 // 3 + 16 * count**3 + 14 * count**2
    return (
        f"about {always} operations in every period, {working} more in every {_nth(filters.factor)}, and {kept} more "
        f"in every {_nth(filters.factor * filters.stride)}"
    )


def _nth(number: int) -> str:
    return f"{number}th" if number > 1 else "one"


def _list(values: np.ndarray) -> str:
    return ", ".join(repr(float(v)) for v in values)
