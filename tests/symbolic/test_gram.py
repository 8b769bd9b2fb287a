"""The sums of products along Fourier motions: C, CasADi's machine and the model's own columns give the same."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from exoid.symbolic.codegen.cache import GeneratedC, load_library
from exoid.symbolic.codegen.compiler import EXACT
from exoid.symbolic.codegen.information import central_differences, information, mean_sign
from exoid.symbolic.codegen.instructions import template
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Motion

LIMITS = np.array([[-0.13, 1.26, 1.92, 5.16], [-1.62, -0.23, 1.64, 5.16]])


def numbers(model):
    rng = np.random.default_rng(5)
    return rng.uniform(0.5, 2.0, len(model.parameters)), model.typical_shape


def motions(count=3):
    rng = np.random.default_rng(1)
    return rng.normal(scale=0.2, size=(count, 2, 10)), np.tile([0.6, -0.9], (count, 1))


def made(model, backend="auto", grid=200):
    return information(model, *numbers(model), LIMITS, period=10.0, harmonics=5, grid=grid, backend=backend)


@pytest.mark.parametrize(
    "names", [(), ("stribeck:knee", "load_friction:hip"), ("torque_ripple:knee",), ("gravity_tilt",)]
)
@pytest.mark.parametrize(("rescale", "doublings"), [(True, 0), (False, 0), (True, 4), (False, 5)])
def test_c_and_virtual_machine_agree(names, rescale, doublings):
    model = Model.standard()
    for name in names:
        model = model.with_effect(name)
    fast, slow = made(model), made(model, "vm")
    if fast.backend != "c":
        pytest.skip("no C compiler")
    assert slow.backend == "vm"
    one, other = (info.sums(*motions(), rescale=rescale, doublings=doublings) for info in (fast, slow))
    np.testing.assert_allclose(one.gram, other.gram, rtol=1e-11, atol=1e-12 * np.abs(other.gram).max())
    np.testing.assert_allclose(one.factor, other.factor, rtol=1e-12)


def test_the_sums_are_those_of_the_regressor():
    model = Model.standard()
    info = made(model, grid=4000)
    swing, offset = motions(1)
    gram = info.sums(swing, offset, rescale=False).gram[0]
    from exoid.measurement.trajectories.trajectory import Fourier

    motion = Fourier(offset[0], swing[0, :, :5], swing[0, :, 5:], 10.0).at(info.times)
    columns = model.columns(motion)
    expected = np.einsum("jnp,jnr->jpr", columns, columns) / len(motion)
    np.testing.assert_allclose(gram, expected, atol=2e-3 * np.abs(expected).max())
    assert gram[0, 4, 4] == pytest.approx(1.0)  # sgn² is one, in the cell of a reversal too


def test_shapes_and_operators_with_a_past_by_differences():
    model = Model.standard().with_effect("stribeck:knee")
    info = made(model)
    motion = Motion(info.times, *np.random.default_rng(2).normal(size=(3, len(info.times), 2)))
    exact, near = info.sensitivities(motion), central_differences(model, motion, info.linear, info.shape)
    np.testing.assert_allclose(exact, near, atol=1e-5 * np.abs(exact).max())
    past = made(Model.standard().with_effect("backlash:hip"))
    assert past.backend == "python" and past.names[-2:] == ("backlash:hip.c", "backlash:hip.h")
    assert np.isfinite(past.sums(*motions(2), rescale=True).gram).all()


def test_rescaling_ends_at_the_first_limit():
    info = made(Model.standard())
    swing, offset = motions()
    factor = info.sums(swing, offset, rescale=False).factor
    again = info.sums(swing * factor[:, :, None], offset, rescale=False).factor
    np.testing.assert_allclose(again, 1.0, rtol=1e-12)
    outside = info.sums(swing, offset + 5.0, rescale=False).factor
    assert np.all(outside == 0.0)


def test_soft_limits_are_norms_and_become_the_limits():
    info = made(Model.standard())
    swing, offset = motions()
    hard = info.sums(swing, offset, rescale=False).factor
    for doublings in (2, 4, 6, 12):
        factor = info.sums(swing, offset, rescale=False, doublings=doublings).factor
        order = 2**doublings
        # The largest of N samples and three limits is at most their norm times N^(1/p), and at least norm / 3^(1/p).
        assert np.all(factor <= hard * info.grid ** (1.0 / order) * (1.0 + 1e-12))
        assert np.all(factor >= hard * 3.0 ** (-1.0 / order) * (1.0 - 1e-12))
    np.testing.assert_allclose(factor, hard, rtol=2e-3)
    outside = info.sums(swing, offset + 5.0, rescale=False, doublings=3).factor
    assert np.all(outside == 0.0)


def test_shapes_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="do not fit"):
        made(Model.standard()).sums(np.zeros((2, 2, 8)), np.zeros((2, 2)), rescale=True)


def test_the_mean_sign_is_the_sign_away_from_reversals():
    speed, pull = np.array([[0.5, -0.5], [0.01, 0.0]]), np.array([[1.0, 1.0], [2.0, 3.0]])
    np.testing.assert_allclose(mean_sign(speed, pull, 0.02), [[1.0, -1.0], [0.5, 0.0]])


def test_the_sine_of_the_generated_code():
    text = (
        "#include <math.h>\n"
        + template("sine.h")
        + "void many(long n, const double *x, double *y) { for (long k = 0; k < n; ++k) y[k] = exoid_sin(x[k]); }\n"
    )
    found = load_library("sine", [text], EXACT, lambda: GeneratedC(text, EXACT, {}), ["many"])
    if found is None:
        pytest.skip("no C compiler")
    x = np.linspace(-20.0, 20.0, 100_001)
    y = np.empty_like(x)
    pointers = [a.ctypes.data_as(ctypes.POINTER(ctypes.c_double)) for a in (x, y)]
    found.c.many(ctypes.c_long(len(x)), *pointers)
    assert np.abs(y - np.sin(x)).max() < 3e-15
