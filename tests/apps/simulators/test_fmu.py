"""FMUs give the model's torque, its motion and its estimator's numbers in FMPy, in both versions and both kinds."""

from __future__ import annotations

import shutil
import subprocess
import zipfile

import numpy as np
import pytest

from benchmarks.python_updater import Updater
from exoid.apps.simulators.export import fmu
from exoid.apps.simulators.fmu import VERSIONS, fmu_bytes
from exoid.apps.watch.front import CUTOFF
from exoid.apps.watch.updater import residual_scale
from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.bench.simulation import Bench, simulate
from exoid.symbolic.codegen.kernel import compiled
from exoid.symbolic.model import Model
from exoid.symbolic.model_file import Numbers
from exoid.symbolic.motion import Motion
from exoid.workbench.command import main
from exoid.workbench.export import c
from exoid.workbench.identified import ExportError, Options, ready
from tests.workbench.test_export import expected, motion, run_c, variant

fmpy = pytest.importorskip("fmpy")
COMPILER = next((name for name in ("cc", "gcc", "clang") if shutil.which(name)), None)
STEP = 0.01
compiles = pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")


def plain() -> tuple[Model, Numbers]:
    model = Model.standard()
    return model, Numbers(dict(zip([p.name for p in model.parameters], standard_leg().base, strict=True)), {}, None)


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Return the model, its numbers, and {file name: path} of its FMUs."""
    folder = tmp_path_factory.mktemp("fmu")
    model, numbers = plain()
    paths = {}
    for name, content in fmu.write(ready(model, numbers), Options("leg", STEP)).items():
        paths[name] = folder / name
        paths[name].write_bytes(content)
    return model, numbers, paths


class Driven:
    """An FMU in co-simulation, step by step."""

    def __init__(self, path, folder, start=0.0):
        self.description = fmpy.read_model_description(str(path), validate=True)
        unpacked = fmpy.extract(str(path), unzipdir=str(folder))
        self.slave = fmpy.instantiate_fmu(unpacked, self.description, "CoSimulation")
        self.place = {one.name: one.valueReference for one in self.description.modelVariables}
        self.new = self.description.fmiVersion == "3.0"
        if self.new:
            self.slave.enterInitializationMode(startTime=start)
        else:
            self.slave.setupExperiment(startTime=start)
            self.slave.enterInitializationMode()

    def began(self):
        self.slave.exitInitializationMode()
        return self

    def set(self, names, values):
        put = self.slave.setFloat64 if self.new else self.slave.setReal
        put([self.place[name] for name in names], [float(value) for value in values])

    def get(self, names):
        take = self.slave.getFloat64 if self.new else self.slave.getReal
        return np.array(take([self.place[name] for name in names]))

    def step(self, t, h):
        self.slave.doStep(currentCommunicationPoint=t, communicationStepSize=h)

    def close(self):
        self.slave.terminate()
        self.slave.freeInstance()


def named(quantity, joints=("hip", "knee")):
    return [f"{quantity}.{joint}" for joint in joints]


def torques(path, folder, on):
    """Return the torque (N, 2) that an inverse-dynamics FMU gives along a motion."""
    one, out = Driven(path, folder, on.t[0]).began(), []
    for k, t in enumerate(on.t):
        for quantity, values in (("q", on.q), ("dq", on.dq), ("ddq", on.ddq)):
            one.set(named(quantity), values[k])
        one.step(t, on.t[1] - on.t[0])
        out.append(one.get(named("tau")))
    one.close()
    return np.array(out)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", ["inverse", "forward", "estimator"])
def test_the_description_is_what_the_standard_asks_for(exported, version, kind):
    from fmpy.validation import validate_fmu

    path = exported[2][f"leg_{kind}_fmi{version[0]}.fmu"]
    assert validate_fmu(str(path)) == []
    description = fmpy.read_model_description(str(path), validate=True)
    assert description.fmiVersion == version and description.coSimulation and description.modelExchange
    assert all(one.unit for one in description.modelVariables)


@pytest.mark.slow
def test_sources_are_inside_and_need_nothing_else(exported, tmp_path):
    for name, path in exported[2].items():
        with zipfile.ZipFile(path) as archive:
            inside = archive.namelist()
            assert "sources/fmu.c" in inside and ("sources/buildDescription.xml" in inside) == ("fmi3" in name)
            archive.extractall(tmp_path / name)
        if COMPILER is None:
            continue
        files = sorted(file.name for file in (tmp_path / name / "sources").glob("*.c"))
        strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O1", "-fPIC", "-shared"]
        made = subprocess.run(
            [COMPILER, *strict, *files, "-o", "made.so", "-lm"], cwd=tmp_path / name / "sources", capture_output=True,
            text=True, check=False,
        )  # fmt: skip
        assert made.returncode == 0, made.stderr


@pytest.mark.slow
def test_the_same_model_is_the_same_file():
    model, numbers = plain()
    one, again = (fmu.write(ready(model, numbers), Options("leg", STEP)) for _ in range(2))
    assert one == again
    heavier = Numbers({**numbers.linear, "Phi1": 9.0}, {}, None)
    other = fmu.write(ready(model, heavier), Options("leg", STEP))
    assert all(other[name] != content for name, content in one.items())


@compiles
@pytest.mark.parametrize("version", VERSIONS)
def test_inverse_dynamics_is_the_models_torque(exported, tmp_path, version):
    model, numbers, paths = exported
    on = motion()
    found = torques(paths[f"leg_inverse_fmi{version[0]}.fmu"], tmp_path, on)
    np.testing.assert_allclose(found, expected(model, numbers, on), rtol=0, atol=1e-9)


@pytest.mark.slow
@compiles
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize(("name", "joint"), [("hysteresis", "hip"), ("time_delay", "hip")])
def test_a_model_with_memory_is_sampled_on_its_own_clock(tmp_path, version, name, joint):
    """What its C gives, sample by sample; a step of four periods takes four samples with the inputs held."""
    model, numbers = variant(name, joint)
    options, on = Options("leg", STEP), Motion(*(x[::2] for x in (motion().t, motion().q, motion().dq, motion().ddq)))
    made = ready(model, numbers)
    path = tmp_path / "leg.fmu"
    path.write_bytes(fmu_bytes(fmu._inverse(made, options), version))
    for file, text in c.write(made, options).items():
        (tmp_path / file).write_text(text, encoding="utf-8")
    shared = ["-shared", "-fPIC", "-ffp-contract=off", "leg.c", "-o", "leg.so", "-lm"]
    subprocess.run([str(COMPILER), *shared], cwd=tmp_path, check=True)
    import ctypes

    library = ctypes.CDLL(str(tmp_path / "leg.so"))
    np.testing.assert_allclose(torques(path, tmp_path / "in", on), run_c(library, "leg", on, True), rtol=0, atol=1e-9)
    held = Motion(on.t, *(np.repeat(x[::4], 4, axis=0)[: len(on)] for x in (on.q, on.dq, on.ddq)))
    coarse = Motion(*(x[::4] for x in (on.t, on.q, on.dq, on.ddq)))
    found = torques(path, tmp_path / "again", coarse)
    np.testing.assert_allclose(found, run_c(library, "leg", held, True)[3::4], rtol=0, atol=1e-9)


@compiles
@pytest.mark.parametrize("version", VERSIONS)
def test_forward_dynamics_is_the_inverse_of_the_torque(exported, tmp_path, version):
    """Away from standstill, where sgn is what it is: the acceleration under the model's torque is the motion's."""
    model, numbers, paths = exported
    on, one = motion(), Driven(paths[f"leg_forward_fmi{version[0]}.fmu"], tmp_path)
    tau = expected(model, numbers, on)
    fast = np.flatnonzero((np.abs(on.dq) > 0.15).all(axis=1))[::10]
    assert fast.size > 5
    for k in fast:
        one.set([*named("q"), *named("dq"), *named("tau")], [*on.q[k], *on.dq[k], *tau[k]])
        np.testing.assert_allclose(one.get(named("ddq")), on.ddq[k], rtol=0, atol=1e-9 * np.abs(on.ddq[k]).max() + 1e-9)
        np.testing.assert_allclose(one.get(["der(q.hip)", "der(q.knee)"]), on.dq[k], rtol=0, atol=0)
    one.began().close()


@compiles
@pytest.mark.parametrize("version", VERSIONS)
def test_the_motion_of_co_simulation_is_that_of_any_other_solver(exported, tmp_path, version):
    from scipy.integrate import solve_ivp

    model, numbers, paths = exported
    one = Driven(paths[f"leg_forward_fmi{version[0]}.fmu"], tmp_path)
    start, tau = np.array([0.6, -0.9, 0.0, 0.0]), np.array([4.0, -1.0])
    one.set([*named("q"), *named("dq"), *named("tau")], [*start, *tau])
    one.began()
    for k in range(40):
        one.step(k * 0.01, 0.01)
    found = one.get([*named("q"), *named("dq")])
    one.close()
    machine, linear = compiled(model), np.array(list(numbers.linear.values()))

    def rates(t, x):
        sign = np.tanh(x[2:] / fmu.SIGN_WIDTH)[None]
        at = Motion(np.array([t]), x[None, :2], x[None, 2:], np.zeros((1, 2)), sign)
        left = tau - machine.inverse_dynamics(at, linear)[0]
        return [*x[2:], *np.linalg.solve(machine.mass_matrix(at, linear)[0], left)]

    wanted = solve_ivp(rates, (0.0, 0.4), start, rtol=1e-10, atol=1e-12, method="LSODA").y[:, -1]
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-6)


@compiles
@pytest.mark.parametrize("kind", ["inverse", "forward", "estimator"])
@pytest.mark.parametrize("version", VERSIONS)
def test_model_exchange_and_co_simulation_agree(exported, version, kind):
    path = str(exported[2][f"leg_{kind}_fmi{version[0]}.fmu"])
    ends = [
        fmpy.simulate_fmu(path, stop_time=0.2, output_interval=STEP, fmi_type=how, relative_tolerance=1e-8)[-1]
        for how in ("CoSimulation", "ModelExchange")
    ]
    np.testing.assert_allclose(*(list(end) for end in ends), rtol=1e-4, atol=1e-4)


@pytest.mark.slow
@compiles
@pytest.mark.parametrize("version", VERSIONS)
def test_the_estimator_gives_the_numbers_of_the_one_in_python(exported, tmp_path, version):
    model, numbers, paths = exported
    run = simulate(bench=Bench(duration=40.0, rate=1.0 / STEP), seed=3)
    t = np.arange(len(run)) * STEP
    one = Driven(paths[f"leg_estimator_fmi{version[0]}.fmu"], tmp_path).began()
    for now, q, tau in zip(t, run.q, run.tau, strict=True):
        one.set([*named("q"), *named("tau")], [*q, *tau])
        one.step(now, STEP)
    names = [p.name.replace(":", ".") for p in model.parameters]
    found = one.get([f"number.{name}" for name in names])
    deviation = one.get([f"deviation.{name}" for name in names])
    one.close()
    at = residual_scale(model, numbers)
    python = Updater(model, np.array([*numbers.linear.values()]), np.zeros(0), at, 1.0 / STEP, CUTOFF)
    python.push(np.column_stack([t, run.q, run.tau]))
    scale = np.abs(python.estimator.linear) + 1.0
    np.testing.assert_allclose(found / scale, python.estimator.linear / scale, rtol=0, atol=1e-9)
    assert np.all(found != np.array([*numbers.linear.values()]))
    enough = python.estimator.blocks >= 4.0
    wanted = np.where(enough, np.sqrt(np.diag(python.estimator.covariance())), 0.0)
    np.testing.assert_allclose(deviation, wanted, rtol=1e-6)
    assert enough.any()


@compiles
@pytest.mark.parametrize("version", VERSIONS)
def test_a_state_that_was_kept_comes_back(exported, tmp_path, version):
    one = Driven(exported[2][f"leg_forward_fmi{version[0]}.fmu"], tmp_path).began()
    keep, back = ("getFMUState", "setFMUState") if one.new else ("getFMUstate", "setFMUstate")
    kept = getattr(one.slave, keep)()
    before = one.get(named("q"))
    one.step(0.0, 0.1)
    assert np.all(one.get(named("q")) != before)
    getattr(one.slave, back)(kept)
    np.testing.assert_array_equal(one.get(named("q")), before)
    one.close()


@compiles
@pytest.mark.parametrize("kind", ["inverse", "forward", "estimator"])
@pytest.mark.parametrize("version", VERSIONS)
def test_a_step_that_is_none_is_refused_and_nothing_has_happened(exported, tmp_path, version, kind):
    """Also a time, an input and a state that are no numbers; a step of 1e308 s would never come back."""
    from fmpy.fmi1 import FMICallException

    one = Driven(exported[2][f"leg_{kind}_fmi{version[0]}.fmu"], tmp_path)
    one.began()
    one.step(0.0, 0.1)
    before = one.get(list(one.place))
    for t, h in ((0.1, np.nan), (0.1, -1.0), (0.1, 1e308), (0.1, np.inf), (np.nan, 0.1), (-np.inf, 0.1)):
        with pytest.raises(FMICallException):
            one.step(t, h)
    with pytest.raises(FMICallException):
        one.set(["q.hip"], [np.nan])
    np.testing.assert_array_equal(one.get(list(one.place)), before)
    one.step(0.1, 0.1)
    one.close()


@compiles
@pytest.mark.parametrize("version", VERSIONS)
def test_a_start_that_is_no_time_is_refused(exported, tmp_path, version):
    from fmpy.fmi1 import FMICallException

    with pytest.raises(FMICallException):
        Driven(exported[2][f"leg_inverse_fmi{version[0]}.fmu"], tmp_path, np.nan)


def test_without_a_compiler_the_sources_are_there(monkeypatch, tmp_path):
    monkeypatch.setattr("exoid.apps.simulators.fmu.find_compiler", lambda: None)
    model, numbers = plain()
    for name, content in fmu.write(ready(model, numbers), Options("leg", STEP)).items():
        (tmp_path / name).write_bytes(content)
        with zipfile.ZipFile(tmp_path / name) as archive:
            assert not any(one.startswith("binaries") for one in archive.namelist())
            assert "sources/fmu.c" in archive.namelist()


@pytest.mark.slow
def test_what_cannot_be_an_fmu_is_said():
    model, numbers = variant("hysteresis", "hip")
    with pytest.raises(ExportError, match="sampled"):
        fmu.write(ready(model, numbers), Options("leg"))
    made = fmu.write(ready(model, numbers), Options("leg", STEP))
    assert {name.split("_")[1] for name in made} == {"inverse"}
    said = " ".join(fmu.notes(ready(model, numbers), Options("leg", STEP)))
    assert "no FMU of forward" in said and "no FMU of estimator" in said
    assert "--sample-time" in " ".join(fmu.notes(ready(*plain()), Options("leg")))


def test_a_machine_of_three_joints_on_a_moving_base_has_its_inputs():
    from exoid.symbolic.joints import Joint

    chain = (Joint("a", length=0.3), Joint("b", length=0.2), Joint("c", length=0.1))
    model = Model(name="arm", joints=chain, moving_base=True)
    numbers = Numbers({p.name: 1.0 + k for k, p in enumerate(model.parameters)}, {}, None)
    made = fmu._inverse(ready(model, numbers), Options("arm"))
    names = [one.name for one in made.variables]
    assert names[:3] == named("q", "abc") and "base.angle" in names and names[-3:] == named("tau", "abc")


@pytest.mark.slow
def test_the_command_writes_fmus_only_where_they_are_asked_for(tmp_path, capsys):
    lines = [f'"{name}" = {value}' for name, value in plain()[1].linear.items()]
    text = "\n".join(['name = "leg"', "[identified.parameters]", *lines])
    (tmp_path / "leg.toml").write_text(text, encoding="utf-8")
    asked = ["export", str(tmp_path / "leg.toml"), "--out", str(tmp_path / "out")]
    assert main(asked) == 0
    assert not list((tmp_path / "out").glob("*.fmu")) and list((tmp_path / "out").glob("*.c"))
    assert main([*asked, "--as", "fmu"]) == 0
    assert {one.name for one in (tmp_path / "out").glob("*.fmu")} == {
        f"exoid_leg_{kind}_fmi{version[0]}.fmu" for kind in ("inverse", "forward") for version in VERSIONS
    }
    assert "no FMU of estimator" in capsys.readouterr().out
