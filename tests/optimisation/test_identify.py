"""The whole identification: what was put in comes out, with proof and honest words."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from paper_leg import PAPER, Leg, record

from exoid.ground.errors import NotEnoughDataError
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.fitting.settings import Search
from exoid.optimisation.fitting.shapes import from_unit, grid, search_shape, to_unit
from exoid.optimisation.optimisers.nfo import NFO
from exoid.symbolic.effect import Shape


def inside(fit, truth):
    return np.mean([e.low <= t <= e.high for e, t in zip(fit.estimates, truth, strict=True)])


@pytest.fixture(scope="module")
def fit():
    return identify(Leg(), [record(noise=5.0, outliers=0.1, samples=700, step=0.05)])


def test_everybody_is_measured_against_the_certified_optimum(fit):
    assert fit.certificate.gap <= 1e-13
    assert fit.sse.certificate.gap <= 1e-13
    for stage in (fit.sse, fit):
        assert stage.runs["nfo_whitened"].gap <= 1e-12
        assert stage.runs["nfo"].gap > 1e-9
        assert abs(stage.reference.gap) <= 1e-12
    assert fit.runs["nfo"].evaluations == 16_000


def test_the_truth_is_found(fit):
    assert inside(fit, PAPER) >= 0.7
    assert np.abs(fit.linear - PAPER).max() < 2.0
    assert np.abs(fit.sse.linear - PAPER).max() > np.abs(fit.linear - PAPER).max()
    assert not fit.plausibility
    assert fit.estimate("viscous:knee").unit == "N·m·s/rad"
    with pytest.raises(KeyError):
        fit.estimate("nonsense")


@pytest.mark.slow
def test_a_fit_shows_and_writes_itself(fit):
    text = repr(fit)
    assert "viscous:knee" in text
    assert "certified optimum" in text
    assert "relative gap" in text
    shown = fit._repr_html_()
    assert all(e.name in shown for e in fit.estimates) and "IPOPT" in shown
    assert list(fit.to_frame().columns) == ["value", "unit", "low", "high", "sse"]
    written = json.loads(json.dumps(fit.to_json(), allow_nan=False))
    assert written["parameters"]["Phi1"]["unit"] == "kg·m²"
    assert written["certificate"]["holds"] is True
    assert len(fit.plot().axes) == 4


@pytest.mark.slow
def test_a_joint_that_is_modelled_badly_bends_the_other_less_where_joints_are_weighted():
    clean = record(noise=2.0, samples=700, step=0.05)
    bump = np.where(clean.motion.q[:, 0] > np.median(clean.motion.q[:, 0]), 60.0, 0.0)
    bent = replace(clean, torque=clean.torque + np.outer([0.0, 1.0], bump))
    plain, weighted = (identify(Leg(), [bent], weighted=asked) for asked in (False, True))
    assert np.all(plain.weight == 1.0) and np.prod(weighted.weight) == pytest.approx(1.0)
    assert weighted.rms[0] < 0.9 * plain.rms[0] and weighted.rms[1] >= plain.rms[1]
    assert np.abs(weighted.residual - (bent.torque - weighted.data.columns @ weighted.linear)).max() < 1e-9
    assert weighted.certificate.gap <= 1e-13 and weighted.runs["nfo_whitened"].gap <= 1e-10
    assert abs(weighted.reference.gap) <= 1e-10


def test_same_seed_same_fit():
    data = [record(noise=5.0, outliers=0.1, samples=300, step=0.1)]
    first, second = (identify(Leg(), data, optimisers={"nfo": Search(NFO())}, seed=4) for _ in range(2))
    assert np.array_equal(first.runs["nfo"].x, second.runs["nfo"].x)
    assert np.array_equal(first.linear, second.linear)


def test_light_mode_is_the_same_fit_without_nfo_and_ipopt(fit):
    light = identify(Leg(), [record(noise=5.0, outliers=0.1, samples=700, step=0.05)], optimisers=())
    assert np.array_equal(light.linear, fit.linear)
    assert light.runs == {}
    assert light.reference is None
    assert light.certificate.holds
    assert len(light.plot().axes) == 4


def test_masked_samples_do_not_matter():
    clean = record(samples=600, step=0.05)
    used = clean.used.copy()
    used[1, 100:200] = False
    torque = np.where(used, clean.torque, 1e6)
    a = identify(Leg(), [replace(clean, used=used)], optimisers=())
    b = identify(Leg(), [replace(clean, used=used, torque=torque)], optimisers=())
    assert np.array_equal(a.linear, b.linear)
    assert np.array_equal(a.rms, b.rms)


def test_a_shape_parameter_is_found_and_called_best_known():
    truth = np.r_[PAPER, 8.0]
    data = [record(Leg(stribeck=True), truth, [0.08], seed=s, samples=700, late=3.0 * s) for s in range(2)]
    fit = identify(Leg(stribeck=True), data, optimisers=())
    assert fit.shape[0] == pytest.approx(0.08, rel=0.1)
    assert inside(fit, [*truth, 0.08]) >= 0.7
    assert fit.best_known
    assert "best known" in repr(fit)
    assert "best-known shape" in fit.certificate.scope
    fixed = identify(Leg(stribeck=True), data, optimisers=(), shape=[0.3])
    assert fixed.shape[0] == 0.3
    assert fixed.loss > fit.loss


def test_a_shape_at_its_bound_is_said():
    data = [record(Leg(stribeck=True), np.r_[PAPER, 30.0], [0.6], noise=0.1)]
    fit = identify(Leg(stribeck=True), data, optimisers=())
    assert any(f.check == "edge" and "stribeck:knee.v_s" in f.where for f in fit.plausibility)


def test_a_torque_fed_back_into_the_model_settles():
    truth = np.r_[PAPER, 0.15]
    data = [record(Leg(load=True), truth, seed=s, samples=700, late=3.0 * s) for s in range(2)]
    fit = identify(Leg(load=True), data, optimisers=())
    assert inside(fit, truth) >= 0.7
    assert fit.linear[8] == pytest.approx(0.15, abs=0.01)
    assert not any(f.check == "fixed_point" for f in fit.plausibility)
    again = identify(Leg(load=True), data, optimisers=(), delta=fit.delta)
    assert np.allclose(again.linear, fit.linear, rtol=1e-9)


def test_what_cannot_be_determined_is_said():
    still = record(samples=400)
    motion = replace(still.motion, dq=np.zeros((400, 2)), sign=np.zeros((400, 2)))
    fit = identify(Leg(), [replace(still, motion=motion)], optimisers=())
    finding = next(f for f in fit.plausibility if f.check == "unexcited")
    assert "coulomb:hip" in finding.where
    assert fit.to_json()["parameters"]["coulomb:hip"]["low"] is None
    json.dumps(fit.to_json(), allow_nan=False)


def test_too_little_data_is_refused():
    with pytest.raises(NotEnoughDataError, match="no recording"):
        identify(Leg(), [])
    with pytest.raises(NotEnoughDataError, match="hip: only 6 usable samples"):
        identify(Leg(), [record(samples=6)])


def test_progress_names_the_step():
    said = []
    identify(Leg(), [record(samples=200)], optimisers=(), progress=said.append)
    assert said == ["least squares", "Huber"]


def test_grid_keeps_choices_and_stays_small():
    shapes = [Shape("1", 1.0, 12.0, choices=(1.0, 2.0, 12.0)), *[Shape("rad", 0.0, 1.0, points=15)] * 3]
    nodes = grid(shapes)
    assert len(nodes) <= 400
    assert {n[0] for n in nodes} == {1.0, 2.0, 12.0}
    assert {min(n[1] for n in nodes), max(n[1] for n in nodes)} == {0.0, 1.0}


@pytest.mark.parametrize("spacing", ["linear", "log"])
def test_unit_coordinates_go_both_ways(spacing):
    shape = Shape("s", 0.01, 0.4, spacing=spacing)
    for unit in (0.0, 0.3, 1.0):
        assert to_unit(shape, from_unit(shape, unit)) == pytest.approx(unit, abs=1e-12)


def test_two_shapes_and_a_choice_are_refined():
    shapes = [
        Shape("1", -1.0, 1.0, choices=(-1.0, 1.0)),
        Shape("s", 0.0, 1.0),
        Shape("s", 0.01, 1.0, spacing="log"),
    ]

    def valley(x):
        return (x[0] - 1.0) ** 2 + (x[1] - 0.618) ** 2 + np.log(x[2] / 0.0773) ** 2

    found = search_shape(valley, shapes)
    assert np.allclose(found.best, [1.0, 0.618, 0.0773], rtol=1e-3)
    assert search_shape(lambda x: np.nan, shapes[:1]).value == np.inf
