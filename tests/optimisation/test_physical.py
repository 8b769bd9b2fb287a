"""The best possible leg: inside its bounds, proven, no worse than another solver's, and free where that will do."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.measurement.trajectories.trajectory import random_trajectory
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.linear.loss import huber
from exoid.optimisation.linear.physical import MARGIN, certify_physical, physics, solve_physical
from exoid.optimisation.linear.problem import LinearData
from exoid.optimisation.linear.solve import solve_huber, solve_sse
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.model import Model
from exoid.workbench.command import main

MODEL = Model.standard()
POSSIBLE = physics(MODEL)
INFINITE, DELTA = np.full(2, np.inf), np.array([0.6, 0.6])
PAPER_SSE = np.array([27.97, 12.15, 1.79, -8.41, 31.83, 15.25, 52.39, -5.89])
"""The paper's Φ_SSE, whose knee viscosity no leg has."""


def made(linear, seed=0, samples=400):
    motion = random_trajectory(np.random.default_rng(seed), MODEL.limits).at(np.linspace(0.0, 10.0, samples))
    columns = MODEL.columns(motion)
    tau = columns @ linear + 0.5 * np.random.default_rng(seed).standard_t(3, size=columns.shape[:2])
    names, units = zip(*((p.name, p.unit) for p in MODEL.parameters), strict=True)
    return LinearData(columns, tau, np.zeros(samples, int), names, units)


def slsqp(data, delta, start):
    """The same problem by another solver, in scaled parameters."""
    scale = np.linalg.norm(data.vector) / np.linalg.norm(data.matrix, axis=0)
    size = huber(data.tau, delta)

    def matrices(x):
        return [np.linalg.eigvalsh(one.matrix(x * scale))[0] for one in POSSIBLE.inequalities]

    def slope(x):
        residual = data.residual(x * scale)
        limit = np.broadcast_to(np.asarray(delta)[:, None], residual.shape)
        return -2.0 * scale * np.einsum("jnp,jn->p", data.columns, np.clip(residual, -limit, limit)) / size

    bounds = list(zip(POSSIBLE.low / scale, POSSIBLE.high / scale, strict=True))
    found = minimize(
        lambda x: huber(data.residual(x * scale), delta) / size,
        start / scale,
        jac=slope,
        method="SLSQP",
        bounds=bounds,
        constraints={"type": "ineq", "fun": matrices},
        options={"ftol": 1e-14, "maxiter": 500},
    )
    return found.x * scale


@pytest.mark.slow
@given(
    st.tuples(*[st.floats(0.1, 1.5)] * 4, *[st.floats(-0.3, 1.5)] * 4),
    st.integers(0, 50),
    st.sampled_from(["sse", "huber"]),
)
@settings(max_examples=25, deadline=None)
def test_every_answer_is_possible_and_proven(factors, seed, kind):
    delta = INFINITE if kind == "sse" else DELTA
    data = made(np.array([1.8, 0.4, 0.5, 0.2, 4.0, 2.0, 3.0, 1.2]) * factors, seed, 200)
    found = solve_physical(data, delta, POSSIBLE)
    assert POSSIBLE.broken(found) == ()
    proof = certify_physical(data, found, delta, POSSIBLE)
    assert proof.holds, proof
    free = solve_sse(data) if kind == "sse" else solve_huber(data, delta)
    if POSSIBLE.broken(free):
        assert proof.primal >= huber(data.residual(free), delta)
    else:
        np.testing.assert_array_equal(found, free)


@pytest.mark.parametrize("delta", [INFINITE, DELTA], ids=["sse", "huber"])
@pytest.mark.parametrize(
    "linear", [PAPER_SSE, [1.4, 0.06, 0.35, 0.1, 4.0, 2.0, 3.0, -0.5]], ids=["viscosity", "masses"]
)
def test_another_solver_finds_nothing_better(linear, delta):
    data = made(np.array(linear))
    found = solve_physical(data, delta, POSSIBLE)
    other = POSSIBLE.inside(slsqp(data, delta, POSSIBLE.inside(np.array(linear))))
    mine, theirs = (huber(data.residual(x), delta) for x in (found, other))
    assert mine <= theirs * (1.0 + 1e-9)
    assert theirs == pytest.approx(mine, rel=1e-4)


def test_where_masses_all_but_vanish_a_proof_may_be_missing_but_is_never_wrong():
    data = made(np.array([0.0, 0.0, 0.0, -0.05, -1.0, 0.0, 0.0, 0.0]), samples=200)
    found = solve_physical(data, DELTA, POSSIBLE)
    proof = certify_physical(data, found, DELTA, POSSIBLE)
    best = min(proof.primal, huber(data.residual(POSSIBLE.inside(slsqp(data, DELTA, found))), DELTA))
    assert proof.dual <= best * (1.0 + 1e-12)


def test_a_wrong_claim_gets_no_proof():
    data = made(PAPER_SSE)
    found = solve_physical(data, DELTA, POSSIBLE)
    assert not certify_physical(data, found * 1.0001, DELTA, POSSIBLE).holds
    free = solve_huber(data, DELTA)
    assert not certify_physical(data, free, DELTA, POSSIBLE).holds  # better, but no leg


def test_positive_masses_are_inside_and_the_mass_matrix_is_definite():
    rng = np.random.default_rng(5)
    for _ in range(200):
        m_th, m_sh, i_th, i_sh = np.exp(rng.uniform(-2.0, 2.5, 4))
        l_th, l_sh, a = rng.uniform(0.05, 0.6, 3)
        phi = np.array(
            [
                i_th + i_sh + m_th * l_th**2 + m_sh * (a**2 + l_sh**2),
                i_sh + m_sh * l_sh**2,
                m_sh * a * l_sh,
                m_th * a * l_th - i_th - m_th * l_th**2,
                *rng.uniform(0.0, 5.0, 4),
            ]
        )
        smallest = min(np.linalg.eigvalsh(one.matrix(phi))[0] for one in POSSIBLE.inequalities)
        assert smallest > -MARGIN
        one, two, three = POSSIBLE.inside(rng.normal(size=8))[:3]
        for cos in np.linspace(-1.0, 1.0, 9):
            off = two + three * cos
            assert one + 2.0 * three * cos > 0.0 and (one + 2.0 * three * cos) * two - off**2 > 0.0


def test_an_answer_on_many_bounds_is_proven_too():
    data = made(np.array([0.9, 0.4, 0.5, 0.2, 0.0, 0.0, 0.0, 0.0]), 0, 200)
    proof = certify_physical(data, solve_physical(data, INFINITE, POSSIBLE), INFINITE, POSSIBLE)
    assert proof.holds, proof


@pytest.mark.slow
def test_identify_says_what_a_possible_leg_costs():
    recordings = [run.recording for run in simulate_runs(2, None, standard_leg(), seed=1, bench=Bench(duration=15.0))]
    wrong = [replace(r, tau=r.tau - np.array([0.0, 4.0]) * np.gradient(r.q, r.t, axis=0)) for r in recordings]
    prepared = prepare(MODEL, wrong)
    free, held = (identify(MODEL, prepared.train, optimisers=(), physical=p) for p in (False, True))
    assert free.estimate("viscous:knee").value < 0.0 and free.held is None
    assert held.estimate("viscous:knee").value == 0.0 and held.certificate.holds
    assert held.held is not None and held.held.broken == ("viscous:knee",) and held.held.cost > 0.0
    assert held.loss > free.loss
    assert any("viscous:knee (-" in str(f) for f in held.plausibility)
    assert json.loads(json.dumps(held.to_json()))["physical"]["violated"] == ["viscous:knee"]


@pytest.mark.slow
def test_from_the_command_line(tmp_path, capsys):
    files = []
    for k, run in enumerate(simulate_runs(2, None, standard_leg(), seed=1, bench=Bench(duration=10.0))):
        r = run.recording
        files.append(str(tmp_path / f"run_{k}.csv"))
        np.savetxt(
            files[-1], np.column_stack([r.t, r.q, r.tau]), delimiter=",", header="t,q1,q2,tau1,tau2", comments=""
        )
    assert main(["identify", *files, "--physical", "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["physical"] == {**found["physical"], "violated": [], "cost": 0.0}
    assert found["certificate"]["holds"] and "a leg can have" in found["certificate"]["scope"]
