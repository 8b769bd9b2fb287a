"""The decision over splits: the algebra against a plain refit, which splits there are, what speaks against a term."""

from __future__ import annotations

from dataclasses import replace
from math import comb

import numpy as np
import pytest
from synthetic import search, state_with

from exoid.diagnosis.evidence.agreement import Agreement
from exoid.diagnosis.evidence.enough_motion import fitted_seconds, little_motion
from exoid.diagnosis.evidence.gain import robust_weight
from exoid.diagnosis.evidence.look_alikes import columns_at
from exoid.diagnosis.evidence.model_error import Repeats, noise_with
from exoid.diagnosis.evidence.stability import Splits, splits_of
from exoid.diagnosis.results import stability_of
from exoid.diagnosis.rules import RULES
from exoid.diagnosis.search.doubt import Objection, doubt, known_with_shape, on_bound, undetermined
from exoid.diagnosis.search.engine import run_search
from exoid.diagnosis.search.possible import agreements_of, possible_of
from exoid.diagnosis.verdict import sentence_of
from exoid.symbolic.motion import Motion

OFFSET = {"torque_offset:knee": ([0.6], [])}


def test_all_splits_where_there_are_few_and_random_ones_where_there_are_many():
    assert splits_of(1, 0, RULES) == ()
    assert splits_of(2, 1, RULES) == ((0,), (1,))
    assert splits_of(5, 0, RULES) == ((0,), (1,), (2,), (3,), (4,))
    assert len(splits_of(9, 3, RULES)) == comb(9, 3)
    many = splits_of(30, 10, RULES)
    assert len(many) == len(set(many)) == RULES.most_splits
    assert splits_of(30, 10, RULES) == many


def weighted(blocks, sigma, columns, which):
    """Return the weighted columns and residual of the recordings `which`."""
    rows, right = [], []
    for k in which:
        root = np.sqrt(robust_weight(blocks[k], sigma)) / sigma[:, None]
        rows.append((columns[k] * root[:, :, None]).reshape(-1, columns[k].shape[2]))
        right.append((blocks[k].residual * root).ravel())
    return np.concatenate(rows), np.concatenate(right)


def test_a_split_is_a_refit_without_the_recordings_set_aside():
    context = search(OFFSET, ["torque_offset:knee"], scales=(1.0, 0.9, -0.2, 1.1))
    start = state_with(context).last
    evidence = context.evidence(start, draws=0)
    score = context.weighed(start, evidence, context.library.find("torque_offset:knee"))
    columns = columns_at(score.candidate, score.shape, start.fitted)
    agreement = Splits(evidence).candidate(score, columns)
    values = []
    for aside in range(4):
        fit = [k for k in range(4) if k != aside]
        both = [np.concatenate([b.columns, c.full(0)], axis=2) for b, c in zip(evidence.blocks, columns, strict=True)]
        a, y = weighted(evidence.blocks, evidence.sigma, both, fit)
        values.append(np.linalg.lstsq(a, y, rcond=None)[0][-1])
    assert agreement.ranges["c"] == pytest.approx((min(values), max(values)), rel=1e-6)
    assert agreement.of == 4
    assert agreement.accepted == 3
    assert 2 in agreement.against


def test_a_term_is_judged_like_the_candidate_it_was():
    context = search(OFFSET, ["torque_offset:knee"])
    state = state_with(context, "torque_offset:knee")
    term = agreements_of(context, state)["torque_offset:knee"]
    assert (term.accepted, term.of) == (4, 4)
    assert term.ranges["c"][0] <= state.last.fitted.linear[-1] <= term.ranges["c"][1]
    assert 0.5 < term.ranges["c"][0] <= term.ranges["c"][1] < 0.7


def test_a_split_that_cannot_tell_does_not_count():
    """The effect is in one recording alone: what is fitted or what is judged never shows it."""
    context = search({"end_stop:hip": ([25.0], [1.0, 1.0])}, ["end_stop:hip"], scales=(1.0, 1.0, 1.0, 1.0))
    state = state_with(context, "end_stop:hip")
    agreement = agreements_of(context, state)["end_stop:hip"]
    assert agreement.of <= 4
    assert Agreement().share is None and Agreement().enough(RULES)


def test_a_single_recording_has_no_splits():
    context = search(OFFSET, ["torque_offset:knee"], scales=(1.0,), verify=0)
    state = state_with(context, "torque_offset:knee")
    assert agreements_of(context, state)["torque_offset:knee"].share is None


def test_a_candidate_of_a_single_recording_is_not_asked_of_splits():
    context = search(OFFSET, ["torque_offset:knee"], scales=(1.0,), verify=0)
    start = state_with(context).last
    evidence = context.evidence(start, draws=0)
    score = context.weighed(start, evidence, context.library.find("torque_offset:knee"))
    assert Splits(evidence).candidate(score, columns_at(score.candidate, score.shape, start.fitted)) == Agreement()


@pytest.mark.parametrize(
    ("accepted", "recordings", "repeats"), [(96, 7, True), (92, 7, False), (96, 5, False), (100, 5, False)]
)
def test_what_nearly_all_splits_of_many_recordings_support_repeats(accepted, recordings, repeats):
    """Splits that cannot tell count against it."""
    assert Agreement(accepted, accepted, {}, (), 100, recordings).repeats(RULES) is repeats


def test_two_recordings_do_not_veto_what_nearly_all_splits_of_eight_support():
    """They lose by an offset that is larger in all others; lost in N·m it must be little beside what those gain."""
    name, loud = "torque_offset:knee", [1.0] * 6
    context = search(OFFSET, [name], scales=(*loud, 0.3, 0.3), verify=2)
    start = state_with(context).last
    (score,) = context.rank(start, 1)[1]
    assert score.unseen < 0.0 and score.eligible and score.repeats(RULES)
    found = run_search(context, start).state
    assert found.names == (name,) and start.unseen_gain(found.last, context.rules) < 0.0
    few = replace(context, rules=replace(context.rules, many_recordings=9), ranked={}, doubts={})
    assert run_search(few, start).state.names == ()
    lost = search(OFFSET, [name], scales=(*loud, -0.4, -0.4), verify=2)
    assert run_search(lost, state_with(lost).last).state.names == ()


def test_what_splits_say_in_words():
    text = stability_of(Agreement(83, 84, {"c": (0.0031, 0.0042)}, (5,)), {"c": "kg·m²"}, ["run_05"])
    assert text == (
        "accepted in 83 of 84 splits of the recordings, c 0.0031 to 0.0042 kg·m²; it loses where run_05 is held out"
    )
    assert stability_of(Agreement(), {}) == ""


def test_a_number_on_its_bound_is_another_effect():
    context = search({"stribeck:hip": ([1.5], [0.15])}, ["stribeck:hip"])
    after = state_with(context, "stribeck:hip").last
    assert on_bound(after.fitted, "stribeck:hip", RULES) == ""
    shape = after.fitted.model.shapes[0].shape
    for end, word in ((shape.min, "lowest"), (shape.max, "highest")):
        moved = replace(after.fitted, fit=replace(after.fitted.fit, shape=np.array([end])))
        assert f"is the {word} value" in on_bound(moved, "stribeck:hip", RULES)


def test_an_interval_around_zero_is_nothing():
    context = search(OFFSET, ["torque_offset:knee", "torque_offset:hip"])
    assert undetermined(state_with(context, "torque_offset:knee").last.fitted, "torque_offset:knee") == ""
    hip = state_with(context, "torque_offset:hip").last
    estimate = hip.fitted.fit.estimate("torque_offset:hip.c")
    fit = replace(hip.fitted.fit, estimates=(replace(estimate, low=-1.0, high=1.0),))
    assert "contains zero" in undetermined(replace(hip.fitted, fit=fit), "torque_offset:hip")


@pytest.mark.parametrize(("correlation", "shown"), [(0.0, False), (0.99, True)])
def test_a_peak_of_which_only_the_flank_shows_is_there_all_the_same(correlation, shown):
    context = search({"stribeck:hip": ([1.5], [0.15])}, ["stribeck:hip"])
    after = state_with(context, "stribeck:hip").last.fitted
    fit, own, shape = after.fit, len(after.linear) - 1, len(after.linear)
    value, width = fit.estimate("stribeck:hip.c").value, fit.covariance[shape, shape] ** 0.5
    spread = fit.covariance.copy()
    spread[own, own] = value**2
    spread[own, shape] = spread[shape, own] = correlation * value * width
    wide = replace(fit.estimate("stribeck:hip.c"), low=-value, high=3.0 * value)
    after = replace(after, fit=replace(fit, estimates=(wide,), covariance=spread))
    assert (undetermined(after, "stribeck:hip") == "") is shown
    unknown = known_with_shape(after, "stribeck:hip")
    said = sentence_of(after.model.terms[-1], {"c": wide}, unknown)
    assert ("not known by itself" in said) is shown is bool(unknown)


def test_what_few_splits_support_is_listed_as_possible():
    context = search(OFFSET, ["torque_offset:knee"], scales=(1.0, 1.0, 1.0, 1.0, -0.7, -0.7), verify=2)
    state = state_with(context)
    context.rank(state.last, 1)
    possible = possible_of(context, state, True)
    assert [p.name for p in possible] == ["torque_offset:knee"]
    assert 0.2 <= possible[0].agreement.share < 0.8
    entry = possible[0].to_json()
    assert set(entry) >= {"effect", "joint", "accepted_in", "parameters"}
    assert entry["parameters"]["c"]["low"] < entry["parameters"]["c"]["high"]
    assert possible_of(context, state, False) == ()


def test_nothing_is_accepted_on_a_few_periods_and_enough_is_said():
    context = search(OFFSET, ["torque_offset:knee"], scales=(1.0,), verify=0)
    text = little_motion(context.prepared, RULES)
    assert "s of motion" in text
    assert "75 periods, 15 s, are enough" in text
    assert little_motion(search(OFFSET, ["torque_offset:knee"]).prepared, RULES) == ""
    after = state_with(context, "torque_offset:knee").last
    assert doubt(after, after, context.prepared.noise_floor, RULES) == Objection(text)


def slowed(prepared, times):
    """Return recordings as they would be if everything had taken `times` as long."""
    def one(each):
        path = each.motion
        slow = Motion(path.t * times, path.q, path.dq / times, path.ddq / times**2, path.sign)
        return replace(each, motion=slow, cutoff=each.cutoff / times, rate=each.rate / times)

    choice = replace(prepared.choice, cutoff=prepared.choice.cutoff / times)
    return replace(prepared, train=tuple(map(one, prepared.train)), choice=choice)


@pytest.mark.parametrize("times", [0.1, 1.0, 10.0])
def test_the_same_motion_is_as_much_however_fast_it_was(times):
    prepared = slowed(search(OFFSET, ["torque_offset:knee"]).prepared, times)
    assert fitted_seconds(prepared) == pytest.approx(33.0 * times, rel=0.02)
    assert little_motion(prepared, RULES) == ""


def test_stops_on_the_way_are_no_turns():
    prepared = search(OFFSET, ["torque_offset:knee"]).prepared

    def stepped(each):
        t = np.linspace(0.0, 6.0, len(each.motion.t))
        q, dq = each.motion.q.copy(), each.motion.dq.copy()
        q[:, 1], dq[:, 1] = np.floor(t) + np.minimum(2.0 * (t % 1.0), 1.0), 2.0 * (t % 1.0 < 0.5)
        return replace(each, motion=replace(each.motion, q=q, dq=dq))

    part = replace(prepared, train=tuple(map(stepped, prepared.train[:1])), choice=replace(prepared.choice, cutoff=9.0))
    assert "hold 1 stroke of the knee" in little_motion(part, RULES, (1,))


def test_what_a_joint_showed_in_few_strokes_is_not_accepted_there():
    """The knee goes one way and back, and stays; the hip moves all the time."""
    prepared = search(OFFSET, ["torque_offset:knee"]).prepared

    def lazy(each):
        path, end = each.motion, len(each.motion.t) // 2
        q, dq = path.q.copy(), path.dq.copy()
        q[:, 1] = np.sin(np.pi * np.minimum(np.arange(len(q)), end) / end) ** 2
        dq[:, 1] = np.gradient(q[:, 1], path.t)
        return replace(each, motion=replace(path, q=q, dq=dq))

    part = replace(prepared, train=tuple(map(lazy, prepared.train[:2])), choice=replace(prepared.choice, cutoff=9.0))
    assert little_motion(part, RULES) == "" and little_motion(part, RULES, (0,)) == ""
    assert "4 strokes of the knee" in little_motion(part, RULES, (1,))
    assert little_motion(part, replace(RULES, least_strokes=4), (1,)) == ""


def test_what_does_not_come_again_with_the_motion_counts_as_noise():
    context = search(OFFSET, ["torque_offset:knee"])
    sensors = noise_with(None, context.prepared)
    again = Repeats(np.zeros(2), np.array([2.0, 0.5]) * sensors, "from run to run")
    assert np.allclose(noise_with(again, context.prepared), np.array([2.0, 1.0]) * sensors)
