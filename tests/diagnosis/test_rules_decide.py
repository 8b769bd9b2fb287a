"""Thresholds of the search lie where they are said to: on one side one decision, on the other the other one."""

from __future__ import annotations

import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from synthetic import search, state_with

import exoid.diagnosis.discovery  # noqa: F401
from exoid.diagnosis.evidence.agreement import Agreement
from exoid.diagnosis.evidence.score import admissible, harmless
from exoid.diagnosis.evidence.stability import Splits
from exoid.diagnosis.results import Accepted, Possible
from exoid.diagnosis.rules import RULES
from exoid.diagnosis.search.doubt import (
    DELAY,
    Objection,
    beside_standstill,
    on_bound,
    torque_before_motion,
)
from exoid.diagnosis.search.possible import possible_of
from exoid.diagnosis.verdict import _deciding, _nearest, conclude
from exoid.symbolic.effect import Coefficient, Shape
from exoid.symbolic.effect_catalogue import catalogue
from exoid.symbolic.term import Term


@pytest.mark.shows("little")
@pytest.mark.parametrize(("lost", "passes"), [(0.15, True), (0.25, False)])
def test_what_some_recordings_lose_is_small_beside_what_others_gain(lost, passes):
    assert harmless(RULES, np.array([0.7, -lost, 0.3])) is passes


@pytest.mark.shows("artefact")
@pytest.mark.parametrize(("value", "possible"), [(1.5, True), (2.5, False)])
def test_a_tangent_may_reach_beyond_a_bound_for_it_shows_only_the_direction(value, possible):
    effect = SimpleNamespace(coefficients={"c": Coefficient("N·m", max=1.0)})
    candidate = SimpleNamespace(change=False, tangent=True, term=SimpleNamespace(effect=effect))
    assert admissible(candidate, np.array([[value]]), RULES).tolist() == [possible]
    candidate.tangent = False
    assert admissible(candidate, np.array([[value]]), RULES).tolist() == [False]


def counted(rows):
    splits = SimpleNamespace(rules=RULES, held_out=tuple((k,) for k in range(len(rows))))
    found = Splits._agreement(splits, np.array(rows), {})
    return found.accepted, found.of


@pytest.mark.shows("little")
@pytest.mark.parametrize(("gain", "agree"), [(0.25, 4), (0.15, 3)])
def test_a_split_agrees_that_shows_a_good_part_of_the_gain(gain, agree):
    assert counted([(1.0, 1.0, 1.0)] * 3 + [(gain, 1.0, 1.0)]) == (agree, 4)


@pytest.mark.shows("little")
@pytest.mark.parametrize(("shown", "told"), [(0.22, 4), (0.12, 3)])
def test_a_split_in_which_a_term_hardly_shows_cannot_tell(shown, told):
    assert counted([(1.0, 1.0, 1.0)] * 3 + [(-1.0, shown, 1.0)]) == (3, told)
    assert counted([(1.0, 1.0, 1.0)] * 3 + [(-1.0, 1.0, shown)]) == (3, told)


@pytest.mark.shows("half")
@pytest.mark.parametrize(
    ("delay", "left", "doubted"), [(-0.02, 2.0, False), (-0.02, 2.6, True), (0.02, 2.6, False), (-0.02, 0.8, False)]
)
def test_torque_before_its_motion_must_explain_most(delay, left, doubted):
    """Of 3 N·m with a noise of 1 N·m; the other joint does not count."""
    term = SimpleNamespace(effect=SimpleNamespace(id=DELAY), name="time_delay:hip", reaches=(0,))
    model = SimpleNamespace(shapes=[SimpleNamespace(term="time_delay:hip")])

    def at(error):
        return SimpleNamespace(evaluation_rms=np.array([error, 9.0]), model=model, fit=SimpleNamespace(shapes=delays))

    delays = np.array([[delay], [delay], [0.05]])
    before, after = SimpleNamespace(fitted=at(3.0)), SimpleNamespace(fitted=at(left))
    after.added = SimpleNamespace(candidate=SimpleNamespace(term=term))
    assert bool(torque_before_motion(before, after, np.ones(2), RULES)) is doubted
    after.added.candidate.term = SimpleNamespace(effect=SimpleNamespace(id="stribeck"))
    assert torque_before_motion(before, after, np.ones(2), RULES) == ""


@pytest.mark.parametrize(("blocks", "doubted"), [(0, True), (3, True), (20, False)])
def test_what_shows_only_beside_standstill_is_no_elastic_drive(blocks, doubted):
    """The joint sticks for the first 0.5 s of 20.5 s at 100 Hz; a little is gained later too, in some of 20 parts."""
    rows = np.arange(2050)
    stuck, kept = (rows < 50)[:, None], rows[50:]
    one = SimpleNamespace(used=np.ones((1, 2000), bool), stuck=stuck, kept=kept, rate=100.0)
    one.starts = lambda seconds: np.arange(0, 2000, 100)
    later = (kept % 100 == 0) & (kept < 50 + 100 * blocks)
    old = np.where(kept < 55, 1.0, np.where(later, 0.1 + 0.02 * np.sin(kept), 0.0))
    fitted = [SimpleNamespace(prepared=SimpleNamespace(all=(one,)), residuals=[r[None]]) for r in (old, 0.0 * old)]
    before, after = (SimpleNamespace(fitted=each) for each in fitted)
    after.added = SimpleNamespace(candidate=SimpleNamespace(term=Term(catalogue()["joint_elasticity"], "hip")))
    assert bool(beside_standstill(before, after, RULES)) is doubted
    after.added.candidate.term = Term(catalogue()["stribeck"], "hip")
    assert beside_standstill(before, after, RULES) == ""


@pytest.mark.parametrize("delay", [0.02, -0.02])
def test_a_filter_is_asked_about_where_a_torque_is_late(monkeypatch, delay):
    asked, module = [], sys.modules["exoid.diagnosis.discovery"]
    monkeypatch.setattr(module, "filtered", lambda without, joints, rules: asked.append((without, joints)))
    context = search({"time_delay:knee": ([], [delay])}, ["time_delay:knee", "time_delay:hip"])
    state = state_with(context, "time_delay:knee")
    module._filtered(context, state, RULES)
    if delay < 0.0:
        assert asked == []
    else:
        ((without, joints),) = asked
        assert joints == [1] and without.model.shapes == ()


def test_no_experiment_separates_what_is_no_entry():
    also = ("a filter of first order on the torque (8 Hz)",)
    one = Accepted("time_delay", "hip", {}, also, (), 0.001, 1.0, 0.5, "", outside=also)
    assert "--separate" not in _deciding([one])
    assert "--separate time_delay:hip,stribeck:hip finds" in _deciding([replace(one, look_alikes=("stribeck:hip",))])


def test_a_model_is_not_adequate_where_only_an_early_torque_helps():
    context = search({}, ["torque_offset:knee"])
    last = state_with(context).last.fitted
    early = Possible(DELAY, "hip", Agreement(4, 4), {}, 0.04, "the torque would come 0.03 s before", early=True)
    found = conclude((), None, last, last, True, 4, possible=(early,))
    assert found.verdict == "unexplained" and "drive" in found.next_experiment
    assert "Time delay at the hip, 4 %" in found.sentence
    assert conclude((), None, last, last, True, 4, possible=(replace(early, early=False),)).verdict == "adequate"


def test_a_model_is_not_adequate_where_what_is_missing_shows_in_fitted_recordings_only():
    context = search({"torque_offset:knee": ([1.0], [])}, ["torque_offset:knee"], scales=(1.0, -1.0, 1.0, 0.0))
    last = state_with(context).last.fitted
    near = replace(last, prepared=replace(last.prepared, noise_floor=np.maximum(last.evaluation_rms, 0.1) / 2.0))
    assert np.any(near.train_rms > 3.0 * near.prepared.noise_floor)
    offset = Possible("torque_offset", "knee", Agreement(1, 2), {}, 0.48, "supported by 1 of 2 splits")
    found = conclude((), None, near, near, True, 4, possible=(offset,))
    assert found.verdict == "unexplained"
    assert "the knee keeps" in found.sentence and "(run_0, run_1, run_2)" in found.sentence
    assert "Torque offset at the knee, 48 %" in found.sentence and "hold out a recording" in found.next_experiment
    little = replace(offset, explained_share=0.04)
    assert conclude((), None, near, near, True, 4, possible=(little,)).verdict == "adequate"
    assert conclude((), None, near, near, True, 4).verdict == "adequate"


@pytest.mark.parametrize(("after", "recordings", "said"), [(1.1, 9, True), (0.9, 9, False), (1.1, 4, False)])
def test_it_is_said_where_the_recordings_held_out_lose_by_what_nearly_all_splits_support(after, recordings, said):
    last = state_with(search({}, ["torque_offset:knee"])).last.fitted
    agreement = Agreement(81, 83, {}, (), 84, recordings)
    one = Accepted(
        "rotor_inertia", "knee", {}, (), (), 0.001, np.ones(2), np.array([1.0, after]), "Rotor inertia", agreement
    )
    found = conclude((one,), None, last, last, True, recordings)
    assert ("lose a little by Rotor inertia at the knee" in found.sentence) is said
    assert ("though not on those held out" in found.rule) is said and found.verdict == "missing"


@pytest.mark.shows("negligible")
@pytest.mark.parametrize(
    ("width", "sharp", "doubted"),
    [(0.103, False, False), (0.1007, False, True), (0.1, True, False), (1.1, True, True)],
)
def test_a_value_on_its_bound_is_another_effect_unless_it_is_its_sharpest_form(width, sharp, doubted):
    shape = Shape("rad", 0.1, 1.1, sharp=sharp)
    entry = SimpleNamespace(term="stop:knee", name="stop:knee.w", shape=shape)
    fitted = SimpleNamespace(
        model=SimpleNamespace(shapes=[entry], parameters=[]), shape=[width], shapes=np.array([[width]]), linear=[]
    )
    assert bool(on_bound(fitted, "stop:knee", RULES)) is doubted


def possible(share):
    return Possible("stribeck", "knee", Agreement(1, 4), {}, share, "supported by 1 of 4 splits")


@pytest.mark.shows("worth_telling")
@pytest.mark.parametrize(("share", "named"), [(0.07, True), (0.04, False)])
def test_the_nearest_entry_is_named_where_it_explains_something(share, named):
    assert bool(_nearest([possible(share), possible(0.01)], RULES)) is named


@pytest.mark.shows("little", "most_possible")
@pytest.mark.parametrize(("accepted", "listed"), [(15, 0), (25, 6)])
def test_what_a_fifth_of_the_splits_supports_is_listed_as_possible(accepted, listed):
    term = SimpleNamespace(effect=SimpleNamespace(id="o", coefficients={}), joint="hip")
    scores = [
        SimpleNamespace(
            name=f"offset{k}",
            share=0.1,
            caution="",
            agreement=Agreement(accepted, 100),
            coefficients=[],
            candidate=SimpleNamespace(term=term),
        )
        for k in range(9)
    ]
    context = SimpleNamespace(
        rules=RULES,
        key=lambda _: "now",
        ranked={"now": (None, scores)},
        doubts={("now", score.name): Objection("its interval contains zero") for score in scores},
    )
    assert len(possible_of(context, SimpleNamespace(last=None, banned=()), True)) == listed
