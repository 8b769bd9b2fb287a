"""Problems with certified answers: every solver must reproduce the stored optimum."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from paper_leg import NAMES, UNITS, Leg, paper_motion

from exoid.optimisation.linear.certificate import certify
from exoid.optimisation.linear.loss import huber
from exoid.optimisation.linear.problem import LinearData
from exoid.optimisation.linear.reference import solve_reference
from exoid.optimisation.linear.solve import delta_rule, solve_huber, solve_sse

FILES = sorted((Path(__file__).parents[1] / "certified").glob("*.toml"))
INFINITE = np.full(2, np.inf)


def uniform(count, seed):
    """Park and Miller's minimal standard generator: the same numbers on every machine."""
    out, state = np.empty(count), seed
    for i in range(count):
        state = 16807 * state % 2147483647
        out[i] = state / 2147483647
    return out


def build(spec):
    motion = paper_motion(spec["samples"], spec["step"], spec["period"])
    columns = Leg().columns(motion)
    shape = columns.shape[:2]
    draw = uniform(6 * shape[0] * shape[1], spec["seed"]).reshape(6, *shape)
    noise = spec["noise"] * np.sqrt(3.0) * (draw[:4].sum(axis=0) - 2.0)
    knocks = np.where(draw[4] < spec["knocked"], spec["knock"] * (2.0 * draw[5] - 1.0), 0.0)
    tau = columns @ np.array(spec["linear"]) + noise + knocks
    return LinearData(columns, tau, np.zeros(shape[1], int), NAMES, UNITS)


@pytest.fixture(params=FILES, ids=lambda p: p.stem, scope="module")
def case(request):
    spec = tomllib.loads(request.param.read_text(encoding="utf-8"))
    return build(spec["data"]), spec["answer"]


def close(a, b):
    return np.max(np.abs(np.asarray(a) - b) / np.maximum(np.abs(b), 1.0)) <= 1e-9


def test_sse_and_threshold(case):
    data, answer = case
    linear = solve_sse(data)
    assert close(linear, np.array(answer["sse"]))
    assert close(delta_rule(data.residual(linear)), np.array(answer["delta"]))
    proof = certify(data, linear, INFINITE)
    assert proof.holds
    assert proof.gap <= answer["gap"]
    assert proof.kkt <= answer["kkt"]


def test_huber(case):
    data, answer = case
    delta = np.array(answer["delta"])
    linear = solve_huber(data, delta)
    assert close(linear, np.array(answer["huber"]))
    assert huber(data.residual(linear), delta) == pytest.approx(answer["loss"], rel=1e-12)
    proof = certify(data, linear, delta)
    assert proof.gap <= answer["gap"]
    assert proof.kkt <= answer["kkt"]


@pytest.mark.parametrize("kind", ["sse", "huber"])
def test_ipopt_agrees(case, kind):
    data, answer = case
    delta = np.array(answer["delta"]) if kind == "huber" else INFINITE
    found = solve_reference(data, delta)
    assert found.status == "Solve_Succeeded"
    assert close(found.x, np.array(answer[kind]))
    assert certify(data, found.x, delta).holds


def test_every_file_is_known():
    assert len(FILES) >= 3
