"""The Gram algebra of the evidence against the obvious computation: refit with lstsq, predict, count."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from synthetic import CUTOFF, recording, search

from exoid.diagnosis.evidence.candidates import candidate_columns
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.fitted import fitted_model
from exoid.diagnosis.evidence.gain import Evidence, RecordingEvidence
from exoid.diagnosis.evidence.gram import inverse_of
from exoid.diagnosis.evidence.library import build_library
from exoid.diagnosis.evidence.look_alikes import leaves_joints
from exoid.diagnosis.rules import RULES, Rules
from exoid.diagnosis.search.context import SearchContext
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import CutoffChoice, Prepared
from exoid.symbolic.model import Model


def block(rng: np.random.Generator, samples: int, width: int, fold: np.ndarray | None = None) -> RecordingEvidence:
    columns = rng.normal(size=(2, samples, width))
    columns[1, :, 0] = 0.0
    residual = rng.normal(size=(2, samples))
    use = rng.uniform(size=(2, samples)) > 0.1
    motion = np.cumsum(rng.normal(size=(samples, 2)), axis=0)
    units = np.zeros(samples, int) if fold is None else fold
    starts = lambda seconds: np.arange(0, samples, int(50.0 * seconds))  # noqa: E731
    return RecordingEvidence(columns, residual, use, motion, 50.0, units, starts)


def refit(blocks, extra, fit, held, sigma):
    """Return the fall of the weighted loss on `held` when `extra` (J, K, m) columns join, refitted on `fit`."""

    def stack(which, with_extra):
        rows, right = [], []
        for i, mask in which:
            b = blocks[i]
            for j in (0, 1):
                keep = mask & b.use[j]
                parts = [b.columns[j][keep]] + ([extra[i][j][keep]] if with_extra else [])
                # Beyond two robust deviations a present residual counts linearly (Huber): weight 2 σ/|r|.
                away = np.abs(b.residual[j][keep]) / sigma[j]
                root = np.sqrt(np.where(away > 2.0, 2.0 / away, 1.0)) / sigma[j]
                rows.append(np.concatenate(parts, axis=1) * root[:, None])
                right.append(b.residual[j][keep] * root)
        return np.concatenate(rows), np.concatenate(right)

    losses = []
    for with_extra in (False, True):
        a, y = stack(fit, with_extra)
        x = np.linalg.lstsq(a, y, rcond=None)[0]
        a, y = stack(held, with_extra)
        losses.append(np.sum((y - a @ x) ** 2))
    return losses[0] - losses[1], x


@pytest.mark.parametrize("width", [1, 2])
def test_gain_is_what_a_refit_gains_on_held_out_recordings(width):
    rng = np.random.default_rng(1)
    train = [block(rng, n, 3) for n in (200, 151, 180)]
    verify = [block(rng, 170, 3)]
    blocks = train + verify
    extra = [rng.normal(size=(2, b.residual.shape[1], width)) for b in blocks]
    evidence = Evidence(train, verify, seed=0, draws=5)
    columns = [Columns((0, 1), e[None]) for e in extra]
    gain = evidence.gain(evidence.plain(columns), ridge=0.0)
    whole = [(i, np.ones(b.residual.shape[1], bool)) for i, b in enumerate(blocks)]
    for held in range(3):
        fall, _ = refit(blocks, extra, [whole[i] for i in range(3) if i != held], [whole[held]], evidence.sigma)
        assert gain.folds[held, 0] == pytest.approx(fall, rel=1e-8, abs=1e-8)
    fall, fitted = refit(blocks, extra, whole[:3], [whole[3]], evidence.sigma)
    assert gain.unseen[0] == pytest.approx(fall, rel=1e-8, abs=1e-8)
    assert gain.coefficients[0] == pytest.approx(fitted[3:], rel=1e-8)


def test_one_recording_is_judged_on_blocks_of_itself():
    rng = np.random.default_rng(2)
    fold = np.arange(240) * 4 // 240
    only = block(rng, 240, 2, fold)
    extra = [rng.normal(size=(2, 240, 1))]
    evidence = Evidence([only], [], seed=0, draws=3)
    gain = evidence.gain(evidence.plain([Columns((0, 1), extra[0][None])]), ridge=0.0)
    for held in range(4):
        fall, _ = refit([only], extra, [(0, fold != held)], [(0, fold == held)], evidence.sigma)
        assert gain.folds[held, 0] == pytest.approx(fall, rel=1e-8, abs=1e-8)


def test_a_placebo_is_the_candidate_rolled_in_time():
    rng = np.random.default_rng(3)
    train = [block(rng, n, 3) for n in (160, 140)]
    extra = [rng.normal(size=(1, b.residual.shape[1], 2)) for b in train]
    evidence = Evidence(train, [], seed=4, draws=6)
    columns = [Columns((1,), e[None]) for e in extra]
    shifted = evidence.gain(evidence.shifted(columns, 0), ridge=0.0)
    for draw in range(6):
        rolled = [Columns((1,), np.roll(e, evidence.shifts[i][draw], axis=1)[None]) for i, e in enumerate(extra)]
        plain = evidence.gain(evidence.plain(rolled), ridge=0.0)
        np.testing.assert_allclose(shifted.folds[:, draw], plain.folds[:, 0], rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("width", [1, 2, 3])
@pytest.mark.parametrize("alone", [False, True])
def test_which_placebos_gain_enough_is_told_without_the_splits_of_the_others(width, alone):
    rng = np.random.default_rng(width)
    blocks = [block(rng, 240, 3, np.arange(240) * 4 // 240)] if alone else [block(rng, n, 3) for n in (160, 140, 120)]
    prior = np.array([0.0, 5.0, 0.3])
    evidence = Evidence(blocks[:2], blocks[2:], seed=4, draws=300, prior=prior)
    columns = [Columns((0, 1), rng.normal(size=(1, 2, b.residual.shape[1], width))) for b in blocks]
    whole = evidence.gain(evidence.shifted(columns, 0))
    for part in (0.02, 0.2, 0.7, 0.99):
        least = float(np.quantile(whole.total, part))
        for sign in (whole.coefficients[:, 0] > 0.0, np.ones(300, dtype=bool)):
            found = evidence.exceed(
                evidence.shifted(columns, 0, trained=True),
                least,
                lambda values, sign=sign: values[:, 0] > 0.0 if not sign.all() else sign,
            )
            np.testing.assert_array_equal(found, (whole.total >= least) & sign)


def test_placebos_stay_away_from_zero_and_from_repeats_of_the_motion():
    t = np.arange(1500) / 50.0
    motion = np.column_stack([np.sin(2 * np.pi * t / 10), np.cos(2 * np.pi * t / 10)])
    rng = np.random.default_rng(0)
    one = RecordingEvidence(
        rng.normal(size=(2, 1500, 2)),
        rng.normal(size=(2, 1500)),
        np.ones((2, 1500), bool),
        motion,
        50.0,
        np.zeros(1500, int),
        lambda seconds: np.arange(0, 1500, int(50.0 * seconds)),
    )
    shifts = Evidence([one, one], [], seed=1, draws=400).shifts[0] / 50.0
    distance = np.abs(shifts[:, None] - np.array([0.0, 10.0, 20.0, 30.0])).min()
    assert distance > 1.0


def test_noise_is_called_significant_as_often_as_it_should_be():
    """Pure noise against placebos of itself: the p-value is uniform."""
    from exoid.diagnosis.evidence.candidates import Candidate
    from exoid.diagnosis.evidence.ranking import placebo
    from exoid.diagnosis.evidence.score import Score
    from exoid.symbolic.effect_catalogue import find_effect
    from exoid.symbolic.term import Term

    candidate = Candidate(Term(find_effect("viscous_asymmetry"), "hip"), np.zeros((2, 1, 0)), False)
    values = []
    for seed in range(60):
        rng = np.random.default_rng(100 + seed)
        train = [block(rng, n, 3) for n in (300, 260)]
        columns = [Columns((0,), rng.normal(size=(1, 1, b.residual.shape[1], 1))) for b in train]
        evidence = Evidence(train, [], seed=seed, draws=99)
        gain = evidence.gain(evidence.plain(columns))
        share = float(gain.total[0] / evidence.fold_losses.sum())
        score = Score(candidate, np.zeros(2, int), share, gain.folds[:, 0], 0.0, gain.coefficients[0])
        values.append(placebo(evidence, score, columns).p_value)
    low = np.mean(np.array(values) <= 0.2)
    assert 0.05 <= low <= 0.37


def test_every_recording_has_a_delay_of_its_own():
    """A common delay hides behind friction; what differs from file to file does not."""
    delays = [0.01, 0.06, 0.03, 0.045]
    made = [recording(f"run_{k}", k, {"time_delay:knee": ([], [d])}, noise=0.02) for k, d in enumerate(delays)]
    choice = CutoffChoice(CUTOFF, "fixed")
    prepared = Prepared(tuple(made[:3]), tuple(made[3:]), choice, np.full(2, 0.01), np.zeros(2), 0.0)
    context = SearchContext(prepared, build_library(Model.standard(), prepared.all), rules=Rules(placebos=99))
    extension = context.fit(Model.standard())
    evidence = context.evidence(extension, draws=0)
    score = context.tested(extension, context.weighed(extension, evidence, context.library.find("time_delay:knee")))
    np.testing.assert_allclose(score.shape[:, 0], delays, atol=0.011)
    assert score.p_value == 0.01 and score.share > 0.8
    found = context.with_term(extension, score).fitted
    np.testing.assert_allclose(found.shapes[:, 0], delays, atol=2e-3)


def test_one_among_the_entries_of_a_large_machine_can_be_significant():
    """Three joints have more candidates than 1499 placebos resolve at the false-discovery rate."""
    from types import SimpleNamespace

    from exoid.diagnosis.rules import RULES
    from exoid.diagnosis.search.context import SearchContext

    for count in (56, 95, 300):
        context = SimpleNamespace(library=SimpleNamespace(effects=[None] * count), rules=RULES)
        draws = SearchContext._draws(context)
        assert draws >= RULES.placebos and 1 / (1 + draws) < RULES.level / count
    assert SearchContext._draws(SimpleNamespace(library=SimpleNamespace(effects=[None] * 56), rules=RULES)) == 1499


def test_a_column_of_rounding_has_no_part_in_an_inverse():
    x = np.random.default_rng(0).normal(size=(500, 3))
    x[:, 1] *= 1e-17
    inverse = inverse_of(x.T @ x)
    np.testing.assert_array_equal(inverse[1], 0.0)
    np.testing.assert_allclose(
        inverse[np.ix_([0, 2], [0, 2])], np.linalg.inv(x[:, [0, 2]].T @ x[:, [0, 2]]), rtol=1e-6, atol=1e-12
    )


@pytest.mark.parametrize("part", ["contained", "rounding"])
def test_what_the_model_contains_has_no_number_and_so_no_sign(part):
    rng = np.random.default_rng(5)
    blocks = [block(rng, 150, 4) for _ in range(4)]
    evidence = Evidence(blocks, (), seed=0, draws=0)
    new = [rng.normal(size=(2, 150)) for _ in blocks]
    also = [2.0 * b.columns[:, :, 1] if part == "contained" else 1e-12 * rng.normal(size=(2, 150)) for b in blocks]
    columns = [Columns((0, 1), np.stack([x, y], axis=2)[None]) for x, y in zip(new, also, strict=True)]
    alone = [Columns((0, 1), x[None, :, :, None]) for x in new]
    both, step = evidence.fitted(evidence.plain(columns))
    own, wanted = evidence.fitted(evidence.plain(alone))
    assert both[1] == 0.0 and both[0] == pytest.approx(own[0], rel=1e-6)
    np.testing.assert_allclose(step, wanted, rtol=1e-5, atol=1e-9)


def test_the_middle_of_a_spring_is_tried_where_the_joint_gets_to_and_beyond():
    """The grid of a range of 4 rad is too coarse for a joint that moves by a fraction of it."""
    context = search({}, ["hardening_spring:knee"])
    nodes = context.library.find("hardening_spring:knee").nodes[0, :, 0]
    path = np.concatenate([one.motion.q[:, 1] for one in context.prepared.all])
    for level in np.linspace(0.05, 0.95, 19):
        assert np.abs(nodes - np.quantile(path, level)).min() < 0.03 * np.ptp(path)
    assert nodes.min() == -2.0 and nodes.max() == 2.0


def test_a_look_alike_takes_as_much_off_the_error_of_the_same_joints():
    """A rotor of one wrist is no look-alike of that of another, though both lower the error of the whole arm alike."""
    rng = np.random.default_rng(3)
    without = 10.0 + rng.random((2, 40))
    own = without - np.array([[2.0], [0.0]])
    at_knee, at_both = without - np.array([[0.0], [2.0]]), without - np.array([[1.8], [0.1]])
    candidates = build_library(Model.standard(), [recording("run", 0, {})]).candidates
    (hip,) = (candidate for candidate in candidates if candidate.name == "stribeck:hip")
    assert leaves_joints(at_knee, own, without, hip, RULES)
    assert not leaves_joints(at_both, own, without, hip, replace(RULES, clear=1e9))
    assert not leaves_joints(own, own, without, hip, RULES)


@pytest.mark.parametrize("name", ["com_offset_shank", "cuff_interaction", "stribeck:hip", "torque_ripple:knee"])
def test_columns_beside_a_late_sensor_are_those_of_the_whole_model(name):
    model = Model.standard().with_effect("load_friction:hip").with_effect("time_delay:knee")
    made = tuple(recording(f"run_{k}", k, {"time_delay:knee": ([], [0.03])}) for k in range(2))
    prepared = Prepared(made, (), CutoffChoice(CUTOFF, "fixed"), np.full(2, 0.01), np.zeros(2), 0.0)
    fitted = fitted_model(identify(model, prepared.train, optimisers=()), prepared)
    candidate = build_library(model, prepared.all).find(name)
    nodes, (one, _) = candidate.nodes[0][[0, -1]], prepared.all
    longer = model.with_effect(candidate.term.effect, candidate.term.joint)
    many, own = len(model.parameters), len(longer.parameters) - len(model.parameters)
    numbers = np.append(fitted.linear, np.zeros(own))
    for node, columns in zip(nodes, candidate_columns(candidate, nodes, one, fitted).values, strict=True):
        whole = longer.columns(one.motion, np.append(fitted.shape, node), numbers)[:, :, many:]
        expected = one.smooth_columns(whole)[list(candidate.joints)]
        np.testing.assert_allclose(columns, expected, atol=1e-9 * np.abs(expected).max())
