"""What an answer says beside the effect that it names: how much is left, what else does as well, and why not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from synthetic import search, state_with

from benchmarks.arena.cases import draw
from exoid.diagnosis.discovery import discover
from exoid.diagnosis.evidence.agreement import Agreement
from exoid.diagnosis.evidence.model_error import Repeats, model_error
from exoid.diagnosis.results import Accepted
from exoid.diagnosis.rules import RULES
from exoid.diagnosis.search import doubt as doubts
from exoid.diagnosis.search.engine import run_search
from exoid.diagnosis.search.possible import leading_of, possible_of
from exoid.diagnosis.search.state import State
from exoid.diagnosis.sureness import FAIRLY, UNSURE, VERY
from exoid.diagnosis.verdict import conclude
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.symbolic.model import Model
from tests.made_recordings import motion, recording

BOTH = ["torque_offset:hip", "torque_offset:knee"]
ONE = Accepted("stribeck", "hip", {}, (), (), 0.001, np.ones(2), 0.5 * np.ones(2), "A", Agreement(4, 4))
ALIKE = replace(ONE, effect="joint_spring", sentence="B", look_alikes=("hardening_spring:hip",))


@pytest.fixture(scope="module")
def plain():
    """The answer of recordings in which nothing is missing."""
    return discover(Model.standard(), [recording(seed) for seed in (1, 2, 3)], [recording(4)])


# -- adequate is near the noise -------------------------------------------------------------------------------


def test_nothing_is_adequate_far_above_the_noise_however_short_the_recordings_are():
    context = search({"torque_offset:knee": ([1.0], [])}, BOTH, scales=(0.0, 0.0, 0.0, 1.0))
    last = state_with(context).last.fitted
    few = replace(RULES, least_periods=1000.0)
    assert np.all(last.train_rms < 3.0 * last.prepared.noise_floor)
    for rules in (RULES, few):
        found = conclude((), None, last, last, True, 4, rules)
        assert found.verdict == "unexplained" and "times the noise" in found.sentence
    assert "so few leave the numbers open" in found.sentence and "fit more motion" in found.next_experiment
    near = state_with(search({}, BOTH)).last.fitted
    assert conclude((), None, near, near, True, 4, few).verdict == "adequate"


# -- two statements -------------------------------------------------------------------------------------------


def test_nobody_is_very_sure_of_the_whole_where_more_is_missing(plain):
    assert plain.error is None and plain.verdict == "adequate"
    found = replace(plain, verdict="missing", accepted=(ONE,))
    assert found.sureness == VERY and found.headline == "Found: A; very sure"
    context = search({"torque_offset:knee": ([1.0], [])}, BOTH)
    left = model_error(state_with(context).last.fitted)
    assert left is not None and left.times > 3.0
    more = replace(found, error=left)
    assert more.sureness == FAIRLY
    size = f"the {left.joint} keeps {left.times:.2g} times the noise"
    assert more.headline == f"Found: A; fairly sure; more is missing: {size}"
    assert more.accepted[0].sureness == VERY  # of the effect itself, whose own joint is near the noise
    assert replace(ONE, left=3.1).sureness == FAIRLY


def test_what_explains_nothing_where_it_shows_is_not_accepted():
    context = search({"torque_offset:knee": ([1.0], [])}, BOTH)
    before, after = state_with(context, "torque_offset:knee").extensions
    assert doubts.explains_nothing(before, after, RULES) == ""
    assert "explains 0 %" in doubts.explains_nothing(after, replace(before, added=after.added), RULES)
    assert before.explained(after) > 0.9


# -- each effect is told by itself ----------------------------------------------------------------------------


def test_what_lowers_another_joints_error_is_no_look_alike():
    context = search({name: ([0.6], []) for name in BOTH}, BOTH)
    state = run_search(context, state_with(context).last).state
    assert sorted(state.names) == BOTH
    assert [extension.alike for extension in state.extensions[1:]] == [(), ()]


def test_one_effect_with_a_look_alike_leaves_the_others_as_sure_as_they_are(plain):
    last = state_with(search({}, BOTH)).last.fitted
    both = conclude((ONE, ALIKE), None, last, last, True, 4)
    assert both.verdict == "missing"
    assert "cannot distinguish Joint spring at the hip from Hardening spring at the hip" in both.sentence
    assert conclude((ALIKE,), None, last, last, True, 4).verdict == "ambiguous"
    found = replace(plain, verdict="missing", accepted=(ONE, ALIKE))
    assert found.sureness == VERY
    assert found.headline == "Found: A; very sure; B; cannot tell which of its look-alikes it is"
    alone = replace(plain, verdict="ambiguous", accepted=(ALIKE,))
    assert alone.sureness == UNSURE and alone.headline == "Found: B; cannot tell which of its look-alikes it is"


# -- a veto is told, or is none -------------------------------------------------------------------------------


@pytest.mark.parametrize(("recordings", "accepted", "stands"), [(10, 93, False), (10, 60, True), (4, 93, True)])
def test_what_does_not_come_again_outvotes_few_splits_only(monkeypatch, recordings, accepted, stands):
    monkeypatch.setattr(doubts, "repeats", lambda fitted: Repeats(np.zeros(2), np.full(2, 9.0), "from run to run"))
    context = search({"torque_offset:knee": ([1.0], [])}, BOTH)
    before, after = state_with(context, "torque_offset:knee").extensions
    agreement = Agreement(accepted, 98, {}, (), 98, recordings)
    after = replace(after, added=replace(after.added, agreement=agreement))
    assert bool(doubts.less_than_chance(before, after, RULES)) is stands


def test_what_leads_the_suspects_and_is_not_accepted_has_its_reason():
    context = search({"torque_offset:knee": ([1.0], [])}, BOTH)
    state = state_with(context)
    _, first = context.rank(state.last, 1)
    context.doubts[context.key(state.last), "torque_offset:knee"] = doubts.Objection("what acts from outside is larger")
    before = state.last.fitted.evaluation_rms
    found = leading_of(context, state, first, before)
    assert found.name == "torque_offset:knee" and found.reason == "what acts from outside is larger"
    told = conclude((), None, state.last.fitted, state.last.fitted, True, 4, leading=found)
    assert "Torque offset at the knee" in told.sentence and "what acts from outside is larger" in told.sentence
    for change, reason in (
        ({"banned": frozenset([found.name])}, "without physics"), ({"unsteady": frozenset([found.name])}, "splits")
    ):  # fmt: skip
        context.doubts.clear()
        assert reason in leading_of(context, replace(state, **change), first, before).reason
    weak = [replace(score, significant=False, p_value=0.3) for score in first]
    assert "p = 0.3" in leading_of(context, state, weak, before).reason
    assert leading_of(context, State(state.extensions), (), before) is None


def test_what_was_refused_before_another_effect_came_is_still_possible_with_its_reason():
    numbers = {"torque_offset:knee": ([1.0], []), "torque_offset:hip": ([1.0], [])}
    context = search(numbers, BOTH)
    state = state_with(context, "torque_offset:hip")
    reason = doubts.Objection("held-out motion does not have it")
    context.doubts[context.key(state.extensions[0]), "torque_offset:knee"] = reason
    context.rank(state.last, 2)
    (found,) = possible_of(context, state, True)
    assert found.name == "torque_offset:knee" and found.reason == "held-out motion does not have it"


# -- a machine that cannot be ---------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_torque_that_is_a_constant_times_the_speed_is_no_machine():
    def made(seed):
        one, path = recording(seed), motion(seed)
        noise = 0.3 * np.random.default_rng(seed).standard_normal(path.q.shape)
        return replace(one, tau=path.dq * [12.0, 9.0] + noise)

    found = discover(Model.standard(), [made(seed) for seed in (1, 2, 3)], [made(4)])
    assert found.verdict == "check_channels" and not found.accepted
    assert "No weight and no inertia show" in found.sentence and "do not carry an answer" in found.sentence


@pytest.mark.slow
@pytest.mark.parametrize(("joint", "names"), [(0, {"gravity_tilt"}), (1, {"encoder_offset_knee", "com_offset_shank"})])
def test_a_zero_that_is_far_off_is_still_found(joint, names):
    runs = [run.recording for run in simulate_runs(4, seed=3, bench=Bench(duration=20.0))]
    off = 0.35 * np.eye(2)[joint]
    runs = [replace(one, q=one.q + off) for one in runs]
    found = discover(Model.standard(), runs[:3], runs[3:])
    (one,) = found.accepted
    assert {one.name, *one.look_alikes} >= names



@pytest.mark.slow
def test_a_bump_that_no_catalogue_has_is_no_ripple_with_a_stop_beside_it():
    """Four effects described it as well as its three numbers do."""
    task = draw("equations/1j@0.5,200/angle_bump:axis/2").task
    found = discover(task.model, task.recordings[:3], task.recordings[3:])
    assert found.verdict == "unexplained" and not found.accepted
