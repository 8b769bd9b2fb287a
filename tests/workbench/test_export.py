"""Every exported form gives the model's torque: C99 by a strict compiler, CasADi, NumPy, URDF in Pinocchio."""

from __future__ import annotations

import ctypes
import json
import shutil
import subprocess

import numpy as np
import pytest

from exoid.measurement.bench.leg import random_leg, standard_leg
from exoid.measurement.trajectories.trajectory import random_trajectory
from exoid.symbolic.effect import Effect, Shape
from exoid.symbolic.effect_catalogue import catalogue
from exoid.symbolic.model import Model
from exoid.symbolic.model_file import Numbers, write_model
from exoid.symbolic.motion import Motion
from exoid.workbench.command import main
from exoid.workbench.export import c, casadi, numpy, urdf
from exoid.workbench.exporting import usual_formats
from exoid.workbench.identified import ExportError, Options, ready
from tests.exported_module import python_module

STEP = 0.005
COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)]
VARIANTS = [
    (effect.id, joint)
    for effect in catalogue().values()
    for joint in ((None,) if effect.on_both else effect.joints)
    if joint not in effect.absorbed_on
]
LAGGING = Effect(
    "lagging", "friction that follows the speed late", "c * lag(dtheta, T)", joints=("knee",),
    coefficients={"c": "N·m·s/rad"}, shape={"T": Shape("s", 0.01, 0.4)},
)  # fmt: skip
VARIANTS.append((LAGGING.id, "knee"))


def variant(name: str, joint: str | None) -> tuple[Model, Numbers]:
    model = Model.standard().with_effect(LAGGING if name == LAGGING.id else name, joint)
    base = dict(zip([p.name for p in model.parameters], standard_leg().base, strict=False))
    linear = {p.name: base.get(p.name, 0.7 * (p.typical or 1.0)) for p in model.parameters}
    shape = {s.name: float(_inside(s.shape)) for s in model.shapes}
    return model, Numbers(linear, shape, None)


def _inside(shape) -> float:
    if shape.choices:
        return shape.choices[-1]
    value = shape.typical if shape.typical is not None else 0.5 * (shape.min + shape.max)
    return 0.0131 if shape.unit == "s" and shape.max <= 0.2 else value


def motion() -> Motion:
    t = np.arange(0.0, 2.0, STEP)
    one = random_trajectory(np.random.default_rng(3)).at(t)
    return Motion(one.t, one.q, one.dq, one.ddq)


def expected(model: Model, numbers: Numbers, on: Motion) -> np.ndarray:
    return model.torque(on, np.array(list(numbers.linear.values())), np.array(list(numbers.shape.values())))


def backward(t, x):
    """What a controller can do in place of ddt: it does not know the next sample."""
    return np.concatenate([[0.0], np.diff(x) / STEP])


def late(t, x, f):
    """What a controller can do in place of slow."""
    out, share = np.array(x, dtype=float), 1.0 - np.exp(-2.0 * np.pi * f * STEP)
    for k in range(1, len(x)):
        out[k] = out[k - 1] + share * (x[k] - out[k - 1])
    return out


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Return {variant: (model, numbers, ready, options)} with every variant under a name of its own."""
    out = {}
    for number, (name, joint) in enumerate(VARIANTS):
        model, numbers = variant(name, joint)
        out[name, joint] = (model, numbers, ready(model, numbers), Options(f"leg{number}", STEP))
    return out


@pytest.fixture(scope="module", params=COMPILERS or [pytest.param("none", marks=pytest.mark.skip("no C compiler"))])
def library(request, exported, tmp_path_factory):
    folder = tmp_path_factory.mktemp("c")
    sources = []
    for _, _, one, options in exported.values():
        for file, text in c.write(one, options).items():
            (folder / file).write_text(text, encoding="utf-8")
            sources += [file] if file.endswith(".c") else []
    strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O1"]
    made = subprocess.run(
        [request.param, *strict, "-shared", "-fPIC", "-o", "legs.so", *sources, "-lm"],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert made.returncode == 0, made.stderr
    return ctypes.CDLL(str(folder / "legs.so"))


def run_c(library, name: str, on: Motion, memory: bool) -> np.ndarray:
    torque, double = getattr(library, f"{name}_torque"), ctypes.c_double * 2
    torque.restype = None
    state = (ctypes.c_double * 4096)()
    if memory:
        getattr(library, f"{name}_init")(state)
    out = np.empty((len(on), 2))
    for k in range(len(on)):
        tau = double()
        arguments = [ctypes.c_double(on.t[k]), *(double(*x[k]) for x in (on.q, on.dq, on.ddq)), tau]
        torque(*([state] if memory else []), *arguments)
        out[k] = tau
    return out


@pytest.mark.parametrize("which", VARIANTS, ids=lambda v: f"{v[0]}:{v[1]}")
def test_c_numpy_and_the_model_agree(which, exported, library, tmp_path):
    model, numbers, one, options = exported[which]
    on = motion()
    module = python_module(numpy.write(one, options)[f"{options.name}.py"], tmp_path, options.name)
    wanted = expected(model, numbers, on)
    np.testing.assert_allclose(module.torque(on.t, on.q, on.dq, on.ddq), wanted, rtol=1e-9, atol=1e-9)
    if {m.operator for m in one.memories} & {"ddt", "slow"}:  # causal in C: said in the file, and tested as such
        module.ddt, module.slow = backward, late
        wanted = module.torque(on.t, on.q, on.dq, on.ddq)
    np.testing.assert_allclose(run_c(library, options.name, on, bool(one.memories)), wanted, rtol=1e-9, atol=1e-8)


def test_the_parts_in_c_are_those_of_the_equation_of_motion(exported, library):
    *_, options = exported["stribeck", "knee"]
    rng, double = np.random.default_rng(5), ctypes.c_double
    q, dq, ddq = rng.uniform(-1.2, 1.2, (3, 2))
    mass, coriolis, gravity, rigid = (double * 4)(), (double * 4)(), (double * 2)(), (double * 2)()
    pair = double * 2
    name = options.name
    getattr(library, f"{name}_mass_matrix")(pair(*q), mass)
    getattr(library, f"{name}_coriolis")(pair(*q), pair(*dq), coriolis)
    getattr(library, f"{name}_gravity")(double(0.0), pair(*q), gravity)
    getattr(library, f"{name}_rigid_torque")(double(0.0), pair(*q), pair(*dq), pair(*ddq), rigid)
    together = np.reshape(mass, (2, 2)) @ ddq + np.reshape(coriolis, (2, 2)) @ dq + np.array(gravity)
    np.testing.assert_allclose(rigid, together, rtol=1e-12)
    tau, back = pair(), pair()
    getattr(library, f"{name}_torque")(double(0.0), pair(*q), pair(*dq), pair(*ddq), tau)
    getattr(library, f"{name}_forward_dynamics")(double(0.0), pair(*q), pair(*dq), tau, back)
    np.testing.assert_allclose(back, ddq, rtol=1e-9)


def test_the_casadi_function_comes_back(exported, tmp_path):
    import casadi as ca

    model, numbers, one, options = exported["stribeck", "knee"]
    path = tmp_path / "leg.casadi"
    path.write_text(casadi.write(one, options)[f"{options.name}.casadi"])
    torque, on = ca.Function.load(str(path)), motion()
    for k in range(0, len(on), 60):
        got = torque(on.t[k], on.q[k], on.dq[k], on.ddq[k], on.sign[k], ca.DM(0, 1))
        np.testing.assert_allclose(got.full().ravel(), expected(model, numbers, on)[k], rtol=1e-11)


@pytest.mark.parametrize("seed", range(5))
def test_pinocchio_reads_the_urdf_and_gives_the_same_rigid_torque(seed, tmp_path):
    pin = pytest.importorskip("pinocchio")
    leg = random_leg(np.random.default_rng(seed))
    model = Model.standard(thigh_length=leg.thigh_length)
    numbers = Numbers(dict(zip([p.name for p in model.parameters], leg.base, strict=True)), {}, None)
    text = urdf.write(ready(model, numbers), Options())["exoid_leg.urdf"]
    robot = pin.buildModelFromXML(text)
    data, rng = robot.createData(), np.random.default_rng(seed)
    frictionless = np.array([*leg.base[:4], 0.0, 0.0, 0.0, 0.0])
    for _ in range(20):
        q, dq, ddq = rng.uniform(-2.0, 2.0, (3, 2))
        # Pinocchio's inverse dynamics knows neither damping nor friction.
        wanted = model.torque(Motion(np.zeros(1), q[None], dq[None], ddq[None]), frictionless)[0]
        np.testing.assert_allclose(pin.rnea(robot, data, q, dq, ddq), wanted, rtol=1e-9, atol=1e-9)


def test_urdf_refuses_a_leg_that_cannot_be():
    model = Model.standard()
    impossible = (1.0, 0.5, 0.9, 0.1, 1.0, 1.0, 1.0, 1.0)
    numbers = Numbers(dict(zip([p.name for p in model.parameters], impossible, strict=True)), {}, None)
    with pytest.raises(ExportError, match="no leg of positive masses"):
        urdf.write(ready(model, numbers), Options())


def test_what_a_controller_cannot_do_is_refused_in_words():
    model, numbers = variant("time_delay", "knee")
    with pytest.raises(ExportError, match="period of the control loop"):
        c.write(ready(model, numbers), Options())
    ahead = Numbers(numbers.linear, {"time_delay:knee.d": -0.02}, None)
    with pytest.raises(ExportError, match="look ahead"):
        c.write(ready(model, ahead), Options(sample_time=0.001))
    with pytest.raises(ExportError, match="cannot prefix"):
        Options(name="a b")


def test_a_model_name_cannot_leave_its_comment():
    from dataclasses import replace

    model = replace(Model.standard(), name='*/ int evil; """ x')
    numbers = Numbers(dict(zip([p.name for p in model.parameters], standard_leg().base, strict=True)), {}, None)
    one = ready(model, numbers)
    assert "*/ int" not in c.write(one, Options())["exoid_leg.h"]
    assert numpy.write(one, Options())["exoid_leg.py"].count('"""') == 4


def test_the_command_writes_all_formats_and_says_what_is_missing(tmp_path, capsys):
    model = Model.standard()
    bare = write_model(model, tmp_path / "bare.toml")
    assert main(["export", str(bare), "--out", str(tmp_path / "no")]) == 2
    assert "no identified parameters" in capsys.readouterr().err
    lines = "\n".join(
        f'"{p.name}" = {{ value = {v} }}' for p, v in zip(model.parameters, standard_leg().base, strict=True)
    )
    full = tmp_path / "full.toml"
    full.write_text(bare.read_text(encoding="utf-8") + f"\n[identified.parameters]\n{lines}\n", encoding="utf-8")
    out = tmp_path / "out"
    assert main(["export", str(full), "--out", str(out), "--json", str(tmp_path / "e.json"), "--quiet"]) == 0
    told = json.loads((tmp_path / "e.json").read_text(encoding="utf-8"))
    assert sorted(told["files"]) == sorted(usual_formats())
    assert {f.name for f in out.iterdir()} == {file for files in told["files"].values() for file in files}
