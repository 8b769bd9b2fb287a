"""The estimator in C gives what the one in Python gives, and needs nothing but math.h."""

from __future__ import annotations

import ctypes
import shutil
import subprocess

import numpy as np
import pytest

from benchmarks.python_updater import Updater
from exoid.apps.watch.front import CUTOFF
from exoid.apps.watch.updater import residual_scale, write_updater
from exoid.ground.errors import ExoidError
from exoid.measurement.bench.simulation import Bench, simulate
from exoid.symbolic.model import Model
from exoid.symbolic.model_file import Numbers

COMPILER = next((c for c in ("cc", "gcc", "clang") if shutil.which(c)), None)
NUMBERS = Numbers(
    {"Phi1": 1.6, "Phi2": 0.5, "Phi3": 0.4, "Phi4": 0.3, "coulomb:hip": 3.0, "viscous:hip": 1.0, "coulomb:knee": 2.0,
     "viscous:knee": 2.0},
    {}, None,
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
@pytest.mark.parametrize("rate", [100.0, 500.0])
def test_c_and_python_agree_to_1e_9(tmp_path, rate):
    model, run = Model.standard(), simulate(bench=Bench(duration=8.0, rate=rate), seed=3)
    files = write_updater(model, NUMBERS, name="leg", sample_time=1.0 / rate, cutoff=CUTOFF)
    for name, text in files.items():
        (tmp_path / name).write_text(text, "utf-8")
    source = files["leg_updater.c"]
    assert "malloc" not in source
    assert source.count("#include") == 2
    flags = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-pedantic", "-ffp-contract=off", "-shared", "-fPIC"]
    made = subprocess.run(
        [str(COMPILER), *flags, "leg_updater.c", "-o", "leg.so", "-lm"], cwd=tmp_path, capture_output=True, text=True
    )
    assert made.returncode == 0, made.stderr
    c = ctypes.CDLL(str(tmp_path / "leg.so"))
    state = (ctypes.c_double * 20000)()
    pair = ctypes.c_double * 2
    c.leg_updater_init(state)
    at = residual_scale(model, NUMBERS)
    python = Updater(model, np.array([*NUMBERS.linear.values()]), np.zeros(0), at, rate, CUTOFF)
    updates = 0
    t = np.arange(len(run)) / rate
    for now, q, tau in zip(t, run.q, run.tau, strict=True):
        updates += c.leg_updater_step(state, ctypes.c_double(now), pair(*q), pair(*tau))
    python.push(np.column_stack([t, run.q, run.tau]))
    assert updates > 100
    scale = np.abs(python.estimator.linear) + 1.0
    np.testing.assert_allclose(np.array(state[:8]) / scale, python.estimator.linear / scale, rtol=0, atol=1e-9)
    np.testing.assert_allclose(state[8:16], python.estimator.variance, rtol=1e-8)
    spread = (ctypes.c_double * 8)()
    c.leg_updater_spread(state, spread)
    enough = python.estimator.blocks >= 4.0
    expected = np.where(enough, np.sqrt(np.diag(python.estimator.covariance())), 0.0)
    np.testing.assert_allclose(spread[:], expected, rtol=1e-7)
    forgotten = [0, 3, 6]
    python.estimator.forget(forgotten)
    c.leg_updater_forget(state, (ctypes.c_int * 8)(*(k in forgotten for k in range(8))))
    np.testing.assert_allclose(state[8:16], python.estimator.variance, rtol=1e-7)
    meat = np.array(state[16 + 64 + 24 :][:64]).reshape(8, 8)
    np.testing.assert_allclose(meat, python.estimator.meat, rtol=1e-6, atol=1e-9 * np.abs(python.estimator.meat).max())
    again = simulate(bench=Bench(duration=8.0, rate=rate), seed=4)
    t = t[-1] + (1.0 + np.arange(len(again))) / rate
    for now, q, tau in zip(t, again.q, again.tau, strict=True):
        c.leg_updater_step(state, ctypes.c_double(now), pair(*q), pair(*tau))
    python.push(np.column_stack([t, again.q, again.tau]))
    np.testing.assert_allclose(np.array(state[:8]) / scale, python.estimator.linear / scale, rtol=0, atol=1e-8)
    # It moves from wrong numbers towards the truth.
    assert abs(python.estimator.estimates()[6].value - 3.0) < 0.3


def test_what_cannot_be_followed_is_refused():
    with pytest.raises(ExoidError, match="period"):
        write_updater(Model.standard(), NUMBERS, name="leg", sample_time=None, cutoff=CUTOFF)
    model = Model.standard().with_effect("hysteresis", "knee")
    with pytest.raises(ExoidError, match="memory"):
        write_updater(model, NUMBERS, name="leg", sample_time=0.01, cutoff=CUTOFF)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """The estimator of the leg at 100 Hz, and a struct for it."""
    folder = tmp_path_factory.mktemp("updater")
    for name, text in write_updater(Model.standard(), NUMBERS, name="leg", sample_time=0.01, cutoff=CUTOFF).items():
        (folder / name).write_text(text, "utf-8")
    flags = ["-std=c99", "-O1", "-g", "-fsanitize=undefined", "-fno-sanitize-recover", "-shared", "-fPIC"]
    made = [str(COMPILER), *flags, "leg_updater.c", "-o", "leg.so", "-lm"]
    if subprocess.run(made, cwd=folder, capture_output=True).returncode:
        made = [word for word in made if "sanitize" not in word]
        subprocess.run(made, cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "leg.so"))


def followed(c, run, bad=slice(0, 0), column=0, value=0.0):
    """Return the numbers after a run, and how many steps said what; `value` in the samples `bad` of one column."""
    state, pair = (ctypes.c_double * 20000)(), ctypes.c_double * 2
    c.leg_updater_init(state)
    rows = np.column_stack([run.q, run.tau])
    rows[bad, column] = value
    said = {-1: 0, 0: 0, 1: 0}
    for k, row in enumerate(rows.tolist()):
        said[c.leg_updater_step(state, ctypes.c_double(k / 100.0), pair(*row[:2]), pair(*row[2:]))] += 1
    return np.array(state[:8]), said


@pytest.mark.slow
@pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
@pytest.mark.parametrize("value", [1e308, -1e308, np.nan, np.inf, 1e12, 1e6, 60.0])
@pytest.mark.parametrize("column", [0, 1, 3])
def test_samples_that_cannot_be_true_are_refused_and_poison_nothing_in_c(compiled, value, column):
    run = simulate(bench=Bench(duration=12.0, rate=100.0), seed=3)
    clean, said = followed(compiled, run)
    assert said[-1] == 0
    numbers, said = followed(compiled, run, slice(600, 650), column, value)
    if column == 3 and abs(value) <= 1e12:  # what is taken for a torque is weighed by Huber
        assert np.isfinite(numbers).all()
        return
    assert said[-1] == 50
    np.testing.assert_allclose(numbers, clean, rtol=0.05, atol=0.05)
    first, _ = followed(compiled, run, slice(0, 300), column, value)  # from the first sample on, and for long
    assert np.isfinite(first).all()


def test_a_period_that_no_loop_has_is_refused():
    for period in (1e9, 0.06, 1e-9, float("nan"), -0.01):
        with pytest.raises(ExoidError, match="sampling rate"):
            write_updater(Model.standard(), NUMBERS, name="leg", sample_time=period, cutoff=CUTOFF)
