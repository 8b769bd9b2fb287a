"""A model with its identified parameters put in: what every form of export starts from.

The torques are CasADi expressions of the motion alone. Operators with memory (backlash, presliding, delay) stay
inputs `memory[k]`; what feeds each, and its parameter as a number, is listed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from exoid.ground.errors import ExoidError
from exoid.symbolic.model import Model, read_model
from exoid.symbolic.model_file import Numbers, read_numbers
from exoid.workbench.reserved import is_taken


class ExportError(ExoidError):
    """A model that cannot be exported, or not in this form."""


@dataclass(frozen=True)
class Options:
    """`name` prefixes files and C functions; `sample_time` s of the controller; `sign_width` rad/s over which sgn
    fades (0: a step).
    """

    name: str = "exoid_leg"
    sample_time: float | None = None
    sign_width: float = 0.0

    def __post_init__(self) -> None:
        if not (self.name.isidentifier() and self.name.isascii() and len(self.name) <= 40):
            raise ExportError(
                f"{self.name[:60]!r} cannot prefix functions", remedy="use letters, digits and _, at most 40 of them"
            )
        if is_taken(self.name):
            raise ExportError(
                f"{self.name!r} already means something in C, Python or the shell",
                remedy="choose a name of your own, such as my_leg",
            )
        if self.sample_time is not None and not (math.isfinite(self.sample_time) and self.sample_time > 0.0):
            raise ExportError(
                f"a sample time of {self.sample_time!r} s", remedy="give the period of the control loop, such as 0.001"
            )
        if not (math.isfinite(self.sign_width) and self.sign_width >= 0.0):
            raise ExportError(f"a sign width of {self.sign_width!r} rad/s", remedy="give 0 or a small number")


@dataclass(frozen=True, eq=False)
class ExportedOperator:
    """An operator with memory: its word, what feeds it (a Function of the inputs), its parameter (None for ddt)."""

    operator: str
    argument: Any
    parameter: float | None


@dataclass(frozen=True, eq=False)
class Ready:
    """The numbers are in. Functions take (t, q (J,), dq (J,), ddq (J,), sign (J,), memory (K,)), and `base` (5,) where
    the base moves: angle rad, its derivatives, acceleration forwards and upwards m/s², and `force` (C,) where forces
    are measured: the model's `channels`, N or N·m. Torques are in N·m, N where a joint slides.

    `torque` is all the drives have to supply, `rigid` without friction and effects, `mass` (J J,) and `coriolis` (J J,)
    are row by row, `gravity` (J,). `forward` takes `tau` (J,) too and is None where an effect has memory. `linear` and
    `shape` are the numbers, by name, out of `numbers`.
    """

    model: Model
    linear: dict[str, float]
    shape: dict[str, float]
    torque: Any
    rigid: Any
    mass: Any
    coriolis: Any
    gravity: Any
    forward: Any | None
    memories: tuple[ExportedOperator, ...]
    numbers: Numbers


def read_ready(path: str) -> Ready:
    """Read a model file with its identified parameters; ExportError where it has none or not all of them."""
    model, numbers = read_model(path), read_numbers(path)
    if numbers is None:
        raise ExportError(
            "the model has no identified parameters, and a controller needs them",
            where=path,
            remedy=f"exoid identify REC... --model {path} --write identified.toml, then export identified.toml",
        )
    return ready(model, numbers, path)


def ready(model: Model, numbers: Numbers, where: str = "") -> Ready:
    """Put `numbers` into `model`; ExportError for a number that is missing or not finite."""
    import casadi as ca

    from exoid.symbolic.codegen.code import functions
    from exoid.symbolic.codegen.equation import model_expressions

    linear = _complete([p.name for p in model.parameters], numbers.linear, "parameters", where)
    if model.wearer is not None:  # a controller moves both
        added = zip(model.inertial, model.wearer.added(model), strict=True)
        linear |= {p.name: linear[p.name] + float(more) for p, more in added}
    shape = _complete([s.name for s in model.shapes], numbers.shape, "shape", where)
    x = model_expressions(model)
    outside = {"base": x.base_motion} if model.moving_base else {}
    outside |= {"force": x.force} if model.forces else {}
    given = [x.t, x.q, x.dq, x.ddq, x.sign, x.memory, *outside.values()]
    names = ["t", "q", "dq", "ddq", "sign", "memory", *outside]
    numeric = [ca.DM(list(linear.values())), ca.DM(list(shape.values()))]

    def put_in(expression: Any) -> Any:
        return ca.substitute([ca.densify(ca.SX(expression))], [x.linear, x.shape], [ca.SX(n) for n in numeric])[0]

    def function(name: str, expression: Any) -> Any:
        return ca.Function(name, given, [put_in(expression)], names, [name], {"cse": True})

    forward = None
    if not x.memories:
        tau = ca.SX.sym("tau", len(model.joints))
        state = ca.vertcat(x.t, x.q, x.dq, x.ddq, x.sign, x.base_motion, x.force)
        made = functions(x)["forward_dynamics"]
        value = made(state, *map(ca.SX, numeric), x.memory, tau)
        forward = ca.Function(
            "forward_dynamics", [*given, tau], [value], [*names, "tau"], ["acceleration"], {"cse": True}
        )
    memories = tuple(
        ExportedOperator(
            m.operator,
            function(f"argument_{k}", m.argument),
            None if m.parameter is None else float(put_in(m.parameter)),
        )
        for k, m in enumerate(x.memories)
    )
    made = Ready(
        model,
        linear,
        shape,
        function("torque", x.torque),
        function("rigid_torque", x.rigid),
        function("mass_matrix", ca.vec(x.M.T)),
        function("coriolis_matrix", ca.vec(x.C.T)),
        function("gravity_torque", x.G),
        forward,
        memories,
        numbers,
    )
    _refuse_overflow(made, where)
    return made


def _refuse_overflow(made: Ready, where: str) -> None:
    """Refuse numbers with which the torque is not finite although the motion is inside its limits."""
    import casadi as ca

    limits = made.model.motion_limits.values()
    for share in (0.0, 1.0):
        q = [low + share * (high - low) for low, high in (limit.angle for limit in limits)]
        dq, ddq = ([share * getattr(limit, name) for limit in limits] for name in ("velocity", "acceleration"))
        memory = [share] * len(made.memories)
        outside = [[share] * count for count in (len(made.model.base_state), len(made.model.channels)) if count]
        given = [0.0, q, dq, ddq, [share] * len(q), memory, *outside]
        outputs = [f(*given) for f in (made.torque, made.rigid, made.mass, made.coriolis, made.gravity)]
        outputs += [m.argument(*given) for m in made.memories]
        if not all(ca.DM(out).is_regular() for out in outputs):
            largest = max({**made.linear, **made.shape}.items(), key=lambda item: abs(item[1]))
            raise ExportError(
                "with these numbers the torque is not finite on a motion inside the limits",
                where=where,
                remedy=f"the largest is {largest[0]} = {largest[1]:g}; identify the model again",
            )


def _complete(names: list[str], known: Any, table: str, where: str) -> dict[str, float]:
    missing = [name for name in names if name not in known]
    if missing:
        raise ExportError(
            f"no identified number for {', '.join(missing)}",
            where=f"{where} [identified.{table}]",
            remedy="identify this model again with --write: its effects have changed since",
        )
    out = {name: float(known[name]) for name in names}
    wrong = [name for name, value in out.items() if not math.isfinite(value)]
    if wrong:
        raise ExportError(
            f"the identified number of {', '.join(wrong)} is not finite", where=where, remedy="identify it again"
        )
    return out
