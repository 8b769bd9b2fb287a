"""The best possible arm in space: proven, no worse than another solver's, and there are bodies with its numbers."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.linear.bodies import Body3D, nearest_bodies
from exoid.optimisation.linear.links import nearest_matrices
from exoid.optimisation.linear.physical import certify_physical, physics, solve_physical
from exoid.optimisation.linear.problem import LinearData
from exoid.optimisation.linear.solve import delta_rule, solve_sse
from exoid.symbolic.model import model_of
from exoid.symbolic.model_file import Numbers
from exoid.symbolic.motion import Motion
from exoid.symbolic.robot_file import parse_robot
from exoid.symbolic.spatial_machine import spatial_machine
from exoid.workbench.export import mjcf, urdf
from exoid.workbench.identified import Options, ready
from tests.symbolic.arms import arm_text
from tests.workbench.test_export_space import check, mujoco_reads, pinocchio_reads

KINDS = (("revolute",), ("revolute", "revolute", "prismatic"), ("prismatic", "revolute"))
SAMPLES = 200
WRIST = model_of(spatial_machine(parse_robot(arm_text(6, 3).encode())).model)


def arm(seed, count, noise, kinds=("revolute",)):
    """A model and noisy torques of an arm whose links become smaller and smaller."""
    model = model_of(spatial_machine(parse_robot(arm_text(seed, count, kinds).encode())).model)
    rng = np.random.default_rng(seed)
    t = 0.02 * np.arange(SAMPLES)
    q, dq, ddq = np.zeros((3, SAMPLES, count))
    for k in range(1, 6):
        rate, (a, b) = 0.5 * np.pi * k, rng.normal(size=(2, count)) / k
        s, c = np.sin(rate * t)[:, None], np.cos(rate * t)[:, None]
        q, dq, ddq = q + a * s + b * c, dq + rate * (a * c - b * s), ddq - rate**2 * (a * s + b * c)
    bodies = []
    for k in range(count):
        mass = 3.0 * 0.5**k * rng.uniform(0.5, 1.5)
        bodies.append(Body3D(mass, 0.05 * rng.normal(size=3), mass * 4e-4 * np.diag([1.0, 1.2, 0.9])))
    phi = np.einsum("pjk,jk->p", model.mixture, [one.numbers for one in bodies])
    columns = model.columns(Motion(t, q, dq, ddq))
    tau = columns @ np.array([*phi, *([1.0, 0.5] * count)])
    tau = tau + noise * tau.std(axis=1, keepdims=True) * rng.standard_t(3, size=tau.shape)
    names, units = zip(*((p.name, p.unit) for p in model.parameters), strict=True)
    return model, LinearData(columns, tau, np.zeros(SAMPLES, int), names, units)


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "noise"), [(0, 0.03), (8, 0.03), (16, 1e-3), (17, 1e-3)])
def test_every_answer_is_possible_proven_and_has_bodies(seed, noise):
    model, data = arm(seed, 3 + seed % 5, noise, KINDS[seed % 3])
    possible, delta = physics(model), np.full(len(model.joints), np.inf)
    for _ in range(2):
        found = solve_physical(data, delta, possible)
        assert possible.broken(found) == ()
        proof = certify_physical(data, found, delta, possible)
        assert proof.holds, proof
        assert not certify_physical(data, found * 1.0001, delta, possible).holds
        delta = delta_rule(data.residual(found))
    phi = found[: len(model.inertial)]
    bodies = nearest_bodies(model, phi, patient=True)
    for one in bodies:
        assert one.mass > 0.0 and np.linalg.eigvalsh(0.5 * np.trace(one.inertia) * np.eye(3) - one.inertia)[0] > 0.0
    again = np.einsum("pjk,jk->p", model.mixture, [one.numbers for one in bodies])
    np.testing.assert_allclose(again, phi, rtol=1e-9, atol=1e-12)


@pytest.mark.slow
def test_another_solver_finds_nothing_better():
    """Each body's pseudo-inertia is a triangle times its transpose: all that can be, and nothing else."""
    model, data = arm(2, 3, 0.03)
    free, infinite = solve_sse(data), np.full(3, np.inf)
    possible = physics(model)
    assert possible.broken(free)
    mine = np.sum(data.residual(solve_physical(data, infinite, possible)) ** 2)
    lower = np.tril_indices(4)
    scale = np.array([0.12, 0.12, 0.12, 1.0])

    def parameters(x):
        numbers = []
        for part in x[:30].reshape(3, 10):
            triangle = np.zeros((4, 4))
            triangle[lower] = part
            p = scale[:, None] * (triangle @ triangle.T) * scale
            first, trace = p[:3, 3], np.trace(p[:3, :3])
            tensor = trace * np.eye(3) - p[:3, :3]
            numbers.append([tensor[0, 0], tensor[0, 1], tensor[0, 2], tensor[1, 1], tensor[1, 2], tensor[2, 2], *first,
                            p[3, 3]])  # fmt: skip
        return np.concatenate([np.einsum("pjk,jk->p", model.mixture, numbers), x[30:] ** 2])

    start = np.concatenate([np.tile(np.eye(4)[lower], 3), np.ones(6)])
    other = least_squares(lambda x: data.residual(parameters(x)).ravel(), start, max_nfev=400, x_scale="jac")
    assert 2.0 * other.cost == pytest.approx(mine, rel=1e-4)  # it knows no margin, and no largest link


def test_what_can_be_stays_as_it_is():
    model, data = arm(1, 3, 0.0)
    possible = physics(model)
    found = solve_physical(data, np.full(3, np.inf), possible)
    np.testing.assert_array_equal(found, solve_sse(data))
    assert certify_physical(data, found, np.full(3, np.inf), possible).holds


@pytest.mark.slow
def test_a_possible_fit_is_not_called_impossible():
    runs = [run.recording for run in simulate_runs(2, WRIST, seed=3, bench=Bench(duration=12.0))]
    free, held = (identify(WRIST, runs, optimisers=(), physical=physical) for physical in (False, True))
    assert held.certificate.holds and any(one.check == "realisable" for one in free.plausibility)
    assert not any(one.check == "realisable" for one in held.plausibility)
    (said,) = (one for one in held.plausibility if one.check == "possible")
    assert "a possible machine" in said.what


@pytest.mark.slow
def test_an_arm_of_small_inertias_goes_out_to_simulators():
    model, data = arm(3, 6, 0.01)
    infinite, possible = np.full(6, np.inf), physics(model)
    free = solve_sse(data)
    assert nearest_bodies(model, free[: len(model.inertial)]) is None, "least squares has no bodies"
    found = solve_physical(data, infinite, possible)
    given = Numbers(dict(zip([p.name for p in model.parameters], map(float, found), strict=True)), {}, None)
    one = ready(model, given)
    check(urdf.write(one, Options())["exoid_leg.urdf"], model, given, pinocchio_reads)
    check(mjcf.write(one, Options())["exoid_leg.xml"], model, given, mujoco_reads)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_numbers_that_no_matrices_have_are_no_traceback(seed):
    """Multipliers then run away, as far as matrices of which nothing can be inverted."""
    rng = np.random.default_rng(seed)
    for _ in range(60):
        size, bodies, count = (int(k) for k in rng.integers(2, 5, 3))
        roots = rng.standard_normal((bodies, size, size))
        before = roots @ roots.swapaxes(1, 2) + np.eye(size) * 10.0 ** rng.uniform(-6.0, 0.0)
        weights = rng.standard_normal((count, bodies, size, size))
        weights, values = weights + weights.swapaxes(2, 3), rng.standard_normal(count) * 10.0 ** rng.uniform(-3.0, 3.0)
        weights[0], values[0] = np.eye(size), -1.0  # a trace that is negative
        found = nearest_matrices(before, weights, values)
        assert found is None or np.einsum("kii->", found).real > 0.0 > values[0]  # which whoever asks looks at
