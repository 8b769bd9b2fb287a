"""Functional Mock-up Units, FMI 2.0 and 3.0, model exchange and co-simulation: for Simulink, Dymola, OpenModelica.

    NAME_inverse      the torque of a motion; a model with memory is sampled, on the period of --sample-time
    NAME_forward      the motion under drive torques; sgn of a velocity fades near rest, or no solver gets past it
    NAME_estimator    the numbers, followed while the machine runs, as `--updater` has it in C

The C inside is that of the formats `c` and `--updater`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache

from exoid.apps.simulators.fmu import INPUT, OUTPUT, RATE, STATE, VERSIONS, FmuModel, FmuVariable, fmu_bytes
from exoid.ground.errors import ExoidError
from exoid.measurement.recording import force_unit
from exoid.symbolic.joints import Joint
from exoid.workbench.export import c
from exoid.workbench.exporting import exporter
from exoid.workbench.identified import ExportError, Options, Ready

HELP = "FMUs (FMI 2.0 and 3.0) of inverse dynamics, forward dynamics and the estimator, sources inside"
ON_REQUEST = True
"""Written only where it is named: it takes a compiler several seconds."""
SIGN_WIDTH = 0.01
"""rad/s over which sgn fades in forward dynamics, where no other width is given."""
BASE = (("base.angle", "rad"), ("base.velocity", "rad/s"), ("base.acceleration", "rad/s²"), ("base.ax", "m/s²"),
        ("base.az", "m/s²"))  # fmt: skip
BASE_IN_SPACE = (
    *((f"base.{angle}{after}", unit)
      for after, unit in (("", "rad"), ("_velocity", "rad/s"), ("_acceleration", "rad/s²"))
      for angle in ("roll", "pitch", "yaw")),
    *((f"base.a{axis}", "m/s²") for axis in "xyz"),
)  # fmt: skip


def write(ready: Ready, options: Options) -> dict[str, bytes]:
    """Return {file name: FMU}; ExportError where the model cannot run on the clock of a controller."""
    found = {}
    for kind, model in _models(ready, options)[0].items():
        for version in VERSIONS:
            found[f"{options.name}_{kind}_fmi{version[0]}.fmu"] = fmu_bytes(model, version)
    return found


def notes(ready: Ready, options: Options) -> tuple[str, ...]:
    """Return the kinds of model that have no FMU, and why."""
    return tuple(f"no FMU of {kind}: {why}" for kind, why in _models(ready, options)[1].items())


@lru_cache(maxsize=1)  # files and notes are asked for one after the other, and the C takes seconds
def _models(ready: Ready, options: Options) -> tuple[dict[str, FmuModel], dict[str, str]]:
    """Return {kind: model} of the FMUs that there can be, and {kind: why not} of the others."""
    makers: dict[str, Callable[[Ready, Options], FmuModel]] = {"forward": _forward, "estimator": _estimator}
    made, refused = {"inverse": _inverse(ready, options)}, {}
    for kind, make in makers.items():
        try:
            made[kind] = make(ready, options)
        except ExoidError as error:
            refused[kind] = f"{error.what} ({error.remedy})" if error.remedy else error.what
    return made, refused


def _inverse(ready: Ready, options: Options) -> FmuModel:
    joints, name = ready.model.joints, options.name
    given = [*_signals("q", INPUT, joints), *_signals("dq", INPUT, joints), *_signals("ddq", INPUT, joints)]
    outside = _outside(ready)
    variables = (*given, *outside, *_signals("tau", OUTPUT, joints))
    place = _places(variables)
    arguments = [f"m->v + {place(word)}" for word in ("q", "dq", "ddq", "base", "force", "tau") if place(word)]
    call = f"{name}_torque({{}}m->v[0], {', '.join(arguments)});"
    parts = {"MEMORY": "", "SAMPLE": "  (void)m;", "EVALUATE": f"  {call.format('')}", "RESET": ""}
    if ready.memories:
        parts = {
            "MEMORY": f"  {name}_state memory;",
            "SAMPLE": f"  {call.format('&m->memory, ')}",
            "EVALUATE": "  if (!m->samples) { /* before the first sample: what it would give, not remembered */\n"
            f"    {name}_state memory = m->memory;\n    {call.format('&memory, ')}\n  }}",
            "RESET": f"  {name}_init(&m->memory);",
        }
    title = f"{ready.model.name}: inverse dynamics, torque of a motion"
    period = options.sample_time if ready.memories else None
    if ready.memories and period is None:
        raise ExportError("the model has an effect with memory, which is sampled", remedy="add --sample-time SECONDS")
    return FmuModel(f"{name}_inverse", title, variables, c.write(ready, options), parts, period)


def _forward(ready: Ready, options: Options) -> FmuModel:
    if ready.forward is None:
        raise ExportError("the model has an effect with memory, and its acceleration depends on the past")
    width = options.sign_width or SIGN_WIDTH
    joints, name = ready.model.joints, options.name
    middle = {joint: 0.5 * sum(limit.angle) for joint, limit in ready.model.motion_limits.items()}
    states = [replace(item, start=_finite(middle.get(joint.name, 0.0))) for item, joint in
              zip(_signals("q", STATE, joints), joints, strict=True)]  # fmt: skip
    rates = [replace(signal, name=f"der({signal.name[1:]})", role=RATE) for signal in _signals("dq", RATE, joints)]
    variables = (
        *_signals("tau", INPUT, joints), *_outside(ready), *states, *_signals("dq", STATE, joints), *rates,
        *_signals("ddq", RATE, joints),
    )  # fmt: skip
    place = _places(variables)
    arguments = [f"m->v + {place(word)}" for word in ("q", "dq", "base", "force", "tau", "ddq") if place(word)]
    copied = f"  memcpy(m->v + {place('der(q')}, m->v + {place('dq')}, sizeof(double) * {len(joints)});"
    parts = {
        "MEMORY": "", "SAMPLE": "  (void)m;", "RESET": "",
        "EVALUATE": f"{copied}\n  {name}_forward_dynamics(m->v[0], {', '.join(arguments)});",
    }  # fmt: skip
    title = f"{ready.model.name}: forward dynamics, sgn of a velocity fades below {width:g} rad/s"
    sources = c.write(ready, replace(options, sign_width=width))
    return FmuModel(f"{name}_forward", title, variables, sources, parts)


def _estimator(ready: Ready, options: Options) -> FmuModel:
    model, name = ready.model, options.name
    sources = exporter("updater").write(ready, options)
    numbers = [
        FmuVariable(f"number.{_word(p.name)}", OUTPUT, p.unit, p.label, ready.linear[p.name]) for p in model.parameters
    ]
    spreads = [FmuVariable(f"deviation.{item.name[7:]}", OUTPUT, item.unit, "standard deviation") for item in numbers]
    variables = (*_signals("q", INPUT, model.joints), *_signals("tau", INPUT, model.joints), *numbers, *spreads)
    place, count = _places(variables), len(numbers)
    step = f"&m->memory, m->v[0], m->v + {place('q')}, m->v + {place('tau')}"
    parts = {
        "MEMORY": f"  {name}_updater memory;",
        "SAMPLE": f"  (void){name}_updater_step({step});\n"
        f"  memcpy(m->v + {place('number')}, m->memory.linear, sizeof(double) * {count});\n"
        f"  {name}_updater_spread(&m->memory, m->v + {place('deviation')});",
        "EVALUATE": "  (void)m;",
        "RESET": f"  {name}_updater_init(&m->memory);",
    }
    title = f"{model.name}: its numbers, followed while it runs"
    return FmuModel(f"{name}_estimator", title, variables, sources, parts, options.sample_time)


def _signals(quantity: str, role: str, joints: Sequence[Joint]) -> list[FmuVariable]:
    """Return a variable of each joint."""
    words = {"q": "position", "dq": "velocity", "ddq": "acceleration", "tau": "torque of the drive"}
    return [
        FmuVariable(f"{quantity}.{joint.name}", role, joint.unit(quantity), f"{words[quantity]} of {joint.name}")
        for joint in joints
    ]


def _outside(ready: Ready) -> list[FmuVariable]:
    """Return the variables that come from outside: the motion of the base, measured forces."""
    base = BASE_IN_SPACE if ready.model.spatial else BASE
    found = [FmuVariable(name, INPUT, unit, "motion of the base") for name, unit in base if ready.model.moving_base]
    return found + [
        FmuVariable(f"force.{channel}", INPUT, force_unit(channel), "measured, on the machine")
        for channel in ready.model.channels
    ]


def _places(variables: Sequence[FmuVariable]) -> Callable[[str], int]:
    """Return a function that gives the place of the first variable called "word." something; 0 where there is none."""

    def place(word: str) -> int:
        return next((k for k, variable in enumerate(variables, 1) if variable.name.startswith(f"{word}.")), 0)

    return place


def _word(name: str) -> str:
    """Return a parameter's name as FMI can structure it: coulomb:hip is coulomb.hip."""
    return name.replace(":", ".")


def _finite(value: float) -> float:
    return value if abs(value) < 1e6 else 0.0
