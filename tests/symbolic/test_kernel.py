"""Compiled models and fitness kernels: same numbers as without, in any state of the cache."""

import itertools
import os
import subprocess
import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from exoid.ground.errors import ExpressionError
from exoid.symbolic import Coefficient, Effect, Model, Motion, Shape
from exoid.symbolic.codegen import cache as library
from exoid.symbolic.codegen import compiler
from exoid.symbolic.codegen import fitness as fitness_module
from exoid.symbolic.codegen.compiler import NoCompilerWarning
from exoid.symbolic.codegen.fitness import CHUNK, STRETCH, fitness
from exoid.symbolic.codegen.kernel import compiled
from exoid.symbolic.columns import derived_columns, model_columns
from tests.waiting import HUNG

ROOT = Path(__file__).parents[2]
N_M = Coefficient("N·m")
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    needs_compiler = pytest.mark.skipif(compiler.find_compiler() is None, reason="no C compiler")


def random_motion(n=60, seed=0):
    rng = np.random.default_rng(seed)
    return Motion(np.cumsum(rng.uniform(0.005, 0.02, n)), *(rng.normal(size=(n, 2)) for _ in range(3)))


def rich_model():
    """Shapes, memory, feedback, a transform and derived effects at once."""
    load = Effect("load", "", "c * abs(tau_rigid) * sgn(dtheta)", coefficients={"c": Coefficient("1")})
    late = Effect("late", "", "delay(tau_model, d) - tau_model", shape={"d": Shape("s", -0.1, 0.1, typical=0.03)})
    slack = Effect("slack", "", "c * play(theta, h)", coefficients={"c": N_M}, shape={"h": Shape("rad", 0.01, 0.4)})
    creep = Effect(
        "creep",
        "",
        "c * sgn(dtheta) * exp(-(dtheta / v)**2)",
        coefficients={"c": N_M},
        shape={"v": Shape("rad/s", 0.1, 0.4)},
    )
    model = Model.standard()
    for effect, joint in ((load, "hip"), (slack, "knee"), (creep, "knee"), (late, "hip")):
        model = model.with_effect(effect, joint)
    for effect in ("com_offset_thigh", "base_motion", "gravity_tilt", "cuff_interaction"):
        model = model.with_effect(effect)
    return model


@pytest.fixture
def fresh_cache(tmp_path, monkeypatch):
    """An empty cache, and no memory of what this process has loaded."""
    from exoid.symbolic.codegen import kernel

    monkeypatch.setenv("EXOID_CACHE", str(tmp_path))
    monkeypatch.setattr(kernel, "_RECENT", {})
    monkeypatch.setattr(fitness_module, "_LOADED", {})
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["auto", "vm"])
@pytest.mark.parametrize("make", [Model.standard, rich_model])
def test_columns_and_torque_agree(make, backend):
    model, motion = make(), random_motion()
    linear = np.random.default_rng(1).normal(size=len(model.parameters))
    fast = compiled(model, backend)
    wanted = model.columns(motion, None, linear)
    scale = np.abs(wanted).max()
    assert fast.columns(motion, None, linear) == pytest.approx(wanted, abs=1e-12 * scale)
    assert fast.inverse_dynamics(motion, linear) == pytest.approx(model.torque(motion, linear), abs=1e-11 * scale)


@pytest.mark.parametrize("backend", ["auto", "vm"])
def test_a_late_sensor_is_late_for_effects_too(backend):
    """Whatever makes a torque, the sensor shows all of it later: what has a memory and stands behind it included."""
    late = Effect("late", "", "delay(tau_model, d) - tau_model", shape={"d": Shape("s", -0.1, 0.1, typical=0.03)})
    slack = Effect("slack", "", "c * play(theta, h)", coefficients={"c": N_M}, shape={"h": Shape("rad", 0.01, 0.4)})
    plain = Model.standard().with_effect("stribeck:hip").with_effect(slack, "hip")
    model = Model.standard().with_effect(late, "hip").with_effect("stribeck:hip").with_effect(slack, "hip")
    motion = random_motion()
    linear = np.random.default_rng(2).normal(size=len(model.parameters))
    before = plain.torque(motion, linear, model.typical_shape[1:])
    then = np.interp(motion.t - model.typical_shape[0], motion.t, before[:, 0])
    for torque in (model.torque(motion, linear), compiled(model, backend).inverse_dynamics(motion, linear)):
        assert torque[:, 0] == pytest.approx(then, abs=1e-10) and torque[:, 1] == pytest.approx(before[:, 1], abs=1e-10)


@pytest.mark.parametrize("backend", ["auto", "vm"])
def test_forward_dynamics_undoes_inverse_dynamics(backend):
    effect = Effect("load", "", "c * abs(tau_rigid) * sgn(dtheta)", coefficients={"c": Coefficient("1")})
    model = Model.standard().with_effect(effect, "hip").with_effect("com_offset_shank")
    motion = random_motion()
    linear = np.array([25.14, 7.42, 1.43, -10.42, 31.35, 12.53, 43.40, 28.01, 0.1, 0.1])
    fast = compiled(model, backend)
    tau = fast.inverse_dynamics(motion, linear)
    assert fast.forward_dynamics(motion, tau, linear) == pytest.approx(motion.ddq, abs=1e-10)


def test_matrices_assemble_to_the_torque():
    motion, linear = random_motion(), np.array([25.14, 7.42, 1.43, -10.42, 0, 0, 0, 0])
    model = Model.standard()
    leg = compiled(model)
    m, c = leg.mass_matrix(motion, linear), leg.coriolis(motion, linear)
    tau = np.einsum("nij,nj->ni", m, motion.ddq) + np.einsum("nij,nj->ni", c, motion.dq) + leg.gravity(motion, linear)
    assert tau == pytest.approx(model.torque(motion, linear), abs=1e-10)
    j = leg.jacobian(motion, 0.25)
    x = 0.4 * np.cos(motion.q[:, 0]) + 0.25 * np.cos(motion.q.sum(axis=1))
    assert j[:, 0, 0] == pytest.approx(x)


def test_no_samples_and_wrong_lengths():
    model = Model.standard()
    empty = Motion(np.zeros(0), np.zeros((0, 2)), np.zeros((0, 2)), np.zeros((0, 2)))
    assert model.columns(empty).shape == (2, 0, 8)
    with pytest.raises(ValueError, match="linear has shape"):
        model.torque(empty, np.zeros(7))
    with pytest.raises(ValueError, match="shape has shape"):
        model.columns(empty, np.zeros(1))


def test_fitness_in_c_and_in_numpy(monkeypatch):
    rng = np.random.default_rng(4)
    columns = Model.standard().columns(random_motion(5000))
    tau, population, delta = rng.normal(size=(2, 5000)) * 60, rng.normal(size=(13, 8)) * 9, np.array([30.0, 70.0])
    fast = fitness(columns, tau)
    monkeypatch.setattr(fitness_module, "kernel_for", lambda *_: None)
    slow = fitness(columns, tau)
    assert slow.backend == "numpy" and len(fast.entries) == 10
    residual = tau - np.einsum("jnp,ip->ijn", columns, population)
    wanted = np.where(
        np.abs(residual) <= delta[:, None], residual**2, 2 * delta[:, None] * (np.abs(residual) - delta[:, None] / 2)
    ).sum(axis=(1, 2))
    for one in (fast, slow):
        assert one.sse(population) == pytest.approx((residual**2).sum(axis=(1, 2)), rel=1e-12)
        assert one.huber(population, delta) == pytest.approx(wanted, rel=1e-12)
        assert one.huber(population, [np.inf, np.inf]) == pytest.approx(one.sse(population), rel=1e-12)
        assert one.sse(population[:0]).shape == (0,)


@pytest.mark.parametrize("backend", ["auto", "vm"])
def test_a_torque_that_is_not_finite_is_refused_as_numpy_refuses_it(backend):
    steep = Effect(
        "steep",
        "",
        "c * exp(k * theta)",
        coefficients={"c": N_M},
        shape={"k": Shape("1/rad", 1.0, 2e3, typical=1.5e3)},
    )
    model, motion = Model.standard().with_effect(steep, "hip"), random_motion()
    for columns in (model.columns, compiled(model, backend).columns):
        with pytest.raises(ExpressionError, match=r"not a finite number at sample \d+"):
            columns(motion)


@pytest.mark.parametrize("count", [1, 4, 7, 41])
def test_threads_change_no_bit(count):
    rng = np.random.default_rng(3)
    made = fitness(rng.normal(size=(2, 1500, 5)), rng.normal(size=(2, 1500)))
    population = rng.normal(size=(count, 5))
    one = made.huber(population, [1.0, 2.0])
    for threads in (2, 3, 16):
        assert np.array_equal(made.huber(population, [1.0, 2.0], threads=threads), one)
        assert np.array_equal(made.sse(population, threads=threads), made.sse(population))
    with pytest.raises(ValueError, match="at least one"):
        made.sse(population, threads=0)


@pytest.mark.parametrize("samples", [STRETCH * CHUNK - 1, 3 * STRETCH * CHUNK + 1])
def test_long_recordings_are_shared_by_samples(samples):
    rng = np.random.default_rng(3)
    columns, tau = rng.normal(size=(2, samples, 2)), rng.normal(size=(2, samples))
    made, population = fitness(columns, tau), rng.normal(size=(5, 2))
    one = made.huber(population, [1.0, 2.0])
    for threads in (2, 3, 16):
        assert np.array_equal(made.huber(population, [1.0, 2.0], threads=threads), one)
    residual = tau - np.einsum("jnp,ip->ijn", columns, population)
    assert made.sse(population) == pytest.approx((residual**2).sum(axis=(1, 2)), rel=1e-11)


def test_a_full_disk_falls_back_with_a_warning_and_leaves_nothing(fresh_cache, monkeypatch):
    def full(path, text):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    monkeypatch.setattr(library, "find_compiler", lambda: compiler.Compiler("cc", "cc for this test"))
    compiler.warn_slow.cache_clear()
    with pytest.warns(NoCompilerWarning, match="No space left"):
        assert compiled(Model.standard()).backend == "vm"
    assert not list(fresh_cache.iterdir())


def test_fitness_keeps_nan_to_the_candidate_that_has_it():
    columns = Model.standard().columns(random_motion(50))
    one = fitness(columns, np.zeros((2, 50)))
    population = np.ones((6, 8))
    population[2, 3], population[4, 0] = np.nan, np.inf
    for values in (one.sse(population), one.huber(population, [1.0, 1.0])):
        assert list(np.isnan(values)) == [False, False, True, False, True, False]
    with pytest.raises(ValueError, match="not finite"):
        fitness(columns, np.full((2, 50), np.nan))
    with pytest.raises(ValueError, match="positive threshold"):
        one.huber(population, [0.0, 1.0])


@pytest.mark.slow
@needs_compiler
def test_the_cache_is_used_and_a_damaged_entry_is_rebuilt(fresh_cache, monkeypatch):
    from exoid.symbolic.codegen import kernel

    model, motion = Model.standard(), random_motion()
    wanted = model.columns(motion)
    (entry,) = fresh_cache.glob("model-*")
    made = (entry / "library.so").stat().st_mtime_ns
    assert not list(fresh_cache.glob(".*"))

    monkeypatch.setattr(kernel, "_RECENT", {})
    assert np.array_equal(model.columns(replace(motion)), wanted)  # another motion, of which nothing is kept
    assert (entry / "library.so").stat().st_mtime_ns == made

    for name, damage in (
        ("library.so", b"broken"),
        ("record.json", b"{}"),
        ("seal.json", b"[]"),
        ("seal.json", b"\xff"),
    ):
        # Another inode, as a damaged disk or an interrupted copy leaves it; the loaded library stays mapped.
        (entry / name).unlink()
        (entry / name).write_bytes(damage)
        monkeypatch.setattr(kernel, "_RECENT", {})
        assert np.array_equal(model.columns(replace(motion)), wanted)
        assert library._open(entry, ()) is not None


@needs_compiler
def test_leftovers_of_killed_processes_are_swept(fresh_cache):
    old, young = fresh_cache / ".building-old", fresh_cache / ".building-young"
    for folder in (old, young):
        folder.mkdir()
    os.utime(old, (0, 0))
    Model.standard().columns(random_motion())
    assert not old.exists() and young.exists()


def test_a_cache_that_cannot_be_written_is_replaced_by_a_private_one(tmp_path, monkeypatch):
    from exoid.ground.cache import cache_folder

    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv("EXOID_CACHE", str(blocked / "below"))
    assert cache_folder().is_dir() and blocked not in cache_folder().parents


def test_the_key_knows_everything_that_matters(monkeypatch):
    found = compiler.Compiler("/usr/bin/cc", "cc 12")
    key = library._key("content", found, ("-O2",))
    assert key == library._key("content", found, ("-O2",))
    assert key != library._key("content", found, ("-O3",))
    assert key != library._key("other", found, ("-O2",))
    assert key != library._key("content", compiler.Compiler("/usr/bin/cc", "cc 13"), ("-O2",))
    for name, value in (("processor", "another"), ("library_versions", {"casadi": "9"}), ("generator_key", "edited")):
        with monkeypatch.context() as patch:
            patch.setattr(library, name, lambda value=value: value)
            assert key != library._key("content", found, ("-O2",))


def test_fast_arithmetic_stays_inside_the_kernel():
    """Linked carelessly, -ffast-math turns subnormal numbers into zero in the whole process."""
    fitness(Model.standard().columns(random_motion()), np.zeros((2, 60))).sse(np.ones((4, 8)))
    assert np.float64(2.0**-1060) * np.float64(0.5) > 0.0


SCRIPT = """
import numpy as np
from exoid.symbolic import Model, Motion
from exoid.symbolic.codegen.kernel import compiled
one = compiled(Model.standard(0.37))
motion = Motion(np.arange(3.0), *(np.ones((3, 2)) for _ in range(3)))
print(one.backend, repr(float(one.columns(motion)[0, 0, 0])))
"""


@pytest.mark.slow
@needs_compiler
def test_two_processes_at_once(tmp_path):
    environment = {"EXOID_CACHE": str(tmp_path), "PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin"}
    command = [sys.executable, "-c", SCRIPT]
    running = [subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    answers = [process.communicate(timeout=HUNG)[0] for process in running]
    assert answers[0] == answers[1] != ""
    assert len(list(tmp_path.glob("model-*"))) == 1
    assert not list(tmp_path.glob(".*"))


@pytest.mark.slow
def test_warm_start_needs_neither_sympy_nor_casadi():
    script = SCRIPT + "import sys\nprint('sympy' in sys.modules, 'casadi' in sys.modules)"
    for _ in range(2):
        done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True)
    if done.stdout.startswith("c "):
        assert done.stdout.splitlines()[1] == "False False"


def fallen_back(folder, monkeypatch, script):
    """What is said, once, where the compiler is this script; everything else is as with the virtual machine."""
    fake = folder / "fake-cc"
    fake.write_text(f"#!/bin/sh\n{script}\n")
    fake.chmod(0o755)
    monkeypatch.setenv("EXOID_COMPILER", str(fake))
    monkeypatch.setattr(compiler, "_HANGING", set())
    compiler._probe.cache_clear()
    compiler.warn_slow.cache_clear()
    model, motion = Model.standard(0.41), random_motion()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        first = model.columns(motion)
        fit = fitness(first, np.zeros((2, len(motion))))
    assert {w.category for w in caught} == {NoCompilerWarning}
    assert fit.backend == "numpy" and compiled(model).backend == "vm"
    assert first == pytest.approx(compiled(model, "vm").columns(motion))
    said = {str(w.message).replace(str(fake), "CC") for w in caught}
    assert len(said) == 1 and not any("nstall" in text for text in said), said
    return said.pop()


ANSWERS = '[ "$1" = --version ] && echo fake cc && exit'
EMPTY = "for last; do :; done; while [ $# -gt 0 ]; do [ $1 = -o ] && out=$2; shift; done"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("script", "patience", "said"),
    [
        ("exit 1", {}, "no C compiler here works (CC --version says nothing)"),
        (f"{ANSWERS}; echo no space >&2; exit 1", {}, "CC failed | no space"),
        (f"{ANSWERS}; kill -9 $$", {}, "CC was ended by signal 9"),
        (f"{ANSWERS}; true", {}, "CC wrote no library"),
        (f"{ANSWERS}; {EMPTY}; echo x > $out", {}, "what CC made of the generated code cannot be used"),
        ("exec sleep 30", {"ANSWER": 0.3}, "CC does not say who it is within 0.3 s"),
        (f"{ANSWERS}; exec sleep 30", {"HUNG": 0.3}, "CC did not finish within 0.3 s, and is not asked again"),
        (f"{ANSWERS}; while :; do :; done", {"PATIENCE": 1}, "CC took more than 1 s of processor for one model"),
    ],
)
def test_a_compiler_that_fails_is_done_without_and_it_is_said_why(fresh_cache, monkeypatch, script, patience, said):
    for name, seconds in patience.items():
        monkeypatch.setattr(compiler, name, seconds)
    assert said in fallen_back(fresh_cache, monkeypatch, script)


@needs_compiler
def test_a_library_without_our_functions_is_not_used(fresh_cache, monkeypatch):
    real = compiler.CANDIDATES[0] if os.path.exists("/usr/bin/cc") else "gcc"
    script = f"{ANSWERS}; {EMPTY}; echo 'int x;' > $out.c; exec {real} -shared -fPIC $out.c -o $out"
    assert "what CC made of the generated code cannot be used" in fallen_back(fresh_cache, monkeypatch, script)


@needs_compiler
def test_a_compiler_that_fails_once_is_asked_again(fresh_cache, monkeypatch):
    """Memory may be short for a moment: the kernel then ends what takes most."""
    real = compiler.find_compiler()
    ended = fresh_cache / "ended"
    fake = fresh_cache / "fake-cc"
    fake.write_text(f'#!/bin/sh\n[ -e {ended} ] || {{ : > {ended}; kill -9 $$; }}\nexec {real.path} "$@"\n')
    fake.chmod(0o755)
    again = compiler.Compiler(str(fake), real.identity)
    (fresh_cache / "x.c").write_text("int x;\n")
    again.build(fresh_cache / "x.c", fresh_cache / "x.so", compiler.EXACT)
    assert ended.exists() and (fresh_cache / "x.so").stat().st_size


@pytest.mark.parametrize(
    ("wanted", "said"),
    [("none", "EXOID_COMPILER says to do without.*Unset"), ("/nowhere/cc", "no C compiler '/nowhere/cc'.*unset it")],
)
def test_what_EXOID_COMPILER_says_is_what_is_told(fresh_cache, monkeypatch, wanted, said):
    monkeypatch.setenv("EXOID_COMPILER", wanted)
    compiler._probe.cache_clear()
    compiler.warn_slow.cache_clear()
    with pytest.warns(NoCompilerWarning, match=said):
        assert compiled(Model.standard()).backend == "vm"


def test_columns_at_many_frequencies_are_those_at_each():
    model, motion = Model.standard().with_effect("gravity_tilt").with_effect("base_motion"), random_motion()
    reference = np.random.default_rng(2).normal(size=len(model.parameters))
    some = (np.linspace(0.2, 5.0, 40), np.geomspace(0.2, 5.0, 9), np.array([0.7, 1.1]))
    for frequencies, phase in itertools.product(some, (0.0, 0.8)):
        shapes = np.column_stack([np.full(frequencies.size, 0.03), frequencies, np.full(frequencies.size, phase)])
        many = derived_columns(model, motion, shapes, reference)(shapes)
        for found, shape in zip(many, shapes, strict=True):
            whole = model_columns(model, motion, shape, reference)[:, :, -4:]
            np.testing.assert_allclose(found, np.swapaxes(whole, 1, 2), atol=1e-11)
