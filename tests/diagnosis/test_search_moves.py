"""Each move of the search alone, on a library of a few candidates: what it changes, and that it returns a new state."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from synthetic import search, state_with

from exoid.diagnosis.evidence.look_alikes import refine
from exoid.diagnosis.machine_answer import settle
from exoid.diagnosis.question import Searched
from exoid.diagnosis.search import choice
from exoid.diagnosis.search import take_back as module
from exoid.diagnosis.search.choice import contains
from exoid.diagnosis.search.doubt import refuted
from exoid.diagnosis.search.engine import Found, drop_unsteady, exchange, forward, prune, run_search
from exoid.diagnosis.search.take_back import take_back
from exoid.symbolic.model import Model

STRIBECK = {"stribeck:hip": ([1.5], [0.15])}
OFFSET = {"torque_offset:knee": ([0.6], [])}


@pytest.fixture(scope="module")
def plain():
    """A Stribeck friction at the hip and an offset at the knee, and candidates that resemble the friction."""
    names = ["stribeck:hip", "viscous_quadratic:hip", "viscous_cubic:hip", "torque_offset:knee"]
    return search({**STRIBECK, **OFFSET}, names)


def with_rules(context, **rules):
    """`context` as it was begun, with other thresholds."""
    fresh = {name: {} for name in ("ranked", "doubts", "fits")}
    return replace(context, rules=replace(context.rules, **rules), **fresh)


def test_forward_adds_what_is_hidden_and_stops(plain):
    start = state_with(plain)
    found = forward(plain, start)
    assert set(found.names) == {"stribeck:hip", "torque_offset:knee"}
    assert start.names == ()


def test_a_model_is_fitted_once_from_the_same_start(plain):
    base = state_with(plain).last.fitted.model
    assert plain.fit(base) is plain.fit(base.with_effect("torque_offset:knee").without("torque_offset:knee"))
    more = base.with_effect("stribeck:knee")
    assert plain.fit(more, np.array([0.05])) is not plain.fit(more, np.array([0.5]))


def test_forward_passes_over_what_is_banned_and_keeps_to_its_limit(plain):
    start = replace(state_with(plain), banned=frozenset({"torque_offset:knee"}))
    assert "torque_offset:knee" not in forward(plain, start).names
    assert len(forward(replace(plain, rules=replace(plain.rules, most_terms=1)), state_with(plain)).names) == 1


def test_prune_drops_what_the_later_terms_made_superfluous(plain):
    state = state_with(plain, "viscous_cubic:hip", "stribeck:hip")
    assert prune(plain, state).names == ("stribeck:hip",)
    assert prune(with_rules(plain, strict_level=1.0, least_share=-1.0), state) is state
    assert state.names == ("viscous_cubic:hip", "stribeck:hip")


def test_a_term_that_came_to_nothing_is_no_answer(plain):
    real = ("stribeck:hip", "torque_offset:knee")
    state = state_with(plain, *real, "viscous_cubic:hip")
    assert refuted(state.extensions, plain.rules)[0] == "viscous_cubic:hip"
    settled, extensions = settle(Searched(plain.prepared, state.extensions[0].fitted, plain, Found(state, ())))
    assert set(settled.found.state.names) == set(real) and len(extensions) == 3
    assert "contains zero" in plain.doubts[(), "viscous_cubic:hip"].reason
    assert refuted(extensions, plain.rules) is None


def test_prune_leaves_two_real_terms_alone(plain):
    state = state_with(plain, "torque_offset:knee", "stribeck:hip")
    assert prune(plain, state) is state


def test_exchange_takes_the_rival_that_is_better_beside_the_others():
    names = ["viscous_quadratic:hip", "viscous_cubic:hip", "torque_offset:knee"]
    context = search({"viscous_cubic:hip": ([1.2], []), **OFFSET}, names)
    state = state_with(context, "viscous_quadratic:hip", "torque_offset:knee")
    context.rank(state.extensions[0], 1)
    assert set(exchange(context, state).names) == {"viscous_cubic:hip", "torque_offset:knee"}


def test_exchange_keeps_the_right_term(plain):
    state = state_with(plain, "stribeck:hip", "torque_offset:knee")
    plain.rank(state.extensions[0], 1)
    assert exchange(plain, state).names == state.names


def test_take_back_unmasks_the_nearest_thing_to_what_the_catalogue_does_not_have():
    context = search({"torque_ripple:hip": ([1.5, 1.0], [4.0])}, ["hardening_spring:hip", "viscous_cubic:hip"])
    state = state_with(context, "hardening_spring:hip")
    found = take_back(context, state)
    assert found.names == ()
    assert "hardening_spring:hip" in found.banned
    assert found.left is not None
    assert found.left.joint == "hip"


def test_take_back_leaves_the_right_term_alone(plain):
    state = state_with(plain, "torque_offset:knee", "stribeck:hip")
    found = take_back(plain, state)
    assert found.names == state.names
    assert found.left is None


@pytest.mark.parametrize("order", [1, -1])
def test_of_terms_that_a_curve_beats_the_weaker_one_goes_first(order, plain, monkeypatch):
    """Whichever was accepted first: what imitates a true effect is beaten by what that effect leaves as well."""
    winner = SimpleNamespace(supersedes=lambda columns: False)
    monkeypatch.setattr(
        module, "beaten", lambda now, evidence, joint, term, numbers, several: None if several else winner
    )
    state = state_with(plain, *["stribeck:hip", "viscous_cubic:hip"][::order])
    assert take_back(plain, state).names == ("stribeck:hip",)


def test_what_only_some_recordings_support_is_dropped():
    context = search({"torque_offset:hip": ([1.0], [])}, ["torque_offset:hip"], scales=(2.0, 1.5, -0.5, 1.0, -1.0))
    state = state_with(context, "torque_offset:hip")
    found = drop_unsteady(context, state)
    assert found.names == ()
    assert found.unsteady == {"torque_offset:hip"}


def test_a_term_whose_interval_contains_zero_is_possible_and_not_accepted(plain):
    state = state_with(plain, "stribeck:hip", "viscous_cubic:hip", "torque_offset:knee")
    last = state.last.fitted
    wide = tuple(
        replace(e, low=e.value - 9.0, high=e.value + 9.0) if e.name.startswith("viscous_cubic") else e
        for e in last.fit.estimates
    )
    vague = replace(state.last, fitted=replace(last, fit=replace(last.fit, estimates=wide)))
    found = drop_unsteady(plain, state.grown(*state.extensions[:-1], vague))
    assert set(found.names) == {"stribeck:hip", "torque_offset:knee"}
    assert "contains zero" in plain.doubts[plain.key(found.last), "viscous_cubic:hip"].reason


def test_what_every_recording_supports_stays(plain):
    state = state_with(plain, "torque_offset:knee", "stribeck:hip")
    assert drop_unsteady(plain, state) is state


def test_a_quiet_recording_does_not_veto_what_loud_ones_show():
    """One recording hardly moves: it loses much of its own small error, and nearly nothing in N·m."""
    names = ["torque_offset:knee", "stribeck:hip"]
    context = search(OFFSET, names, scales=(1.0, 1.0, 1.0, 1.0, 0.8, 1.2), noise=0.1)
    assert run_search(context, context.fit(state_with(context).last.fitted.model)).state.names == (
        "torque_offset:knee",
    )


def test_the_engine_finds_nothing_where_nothing_is_hidden():
    context = search({}, ["stribeck:hip", "torque_offset:knee", "viscous_cubic:hip"])
    found = run_search(context, state_with(context).last)
    assert found.state.names == ()
    assert found.state.left is None


def test_a_recording_without_a_usable_sample_says_nothing_and_stops_nothing():
    context = search(OFFSET, ["torque_offset:knee", "viscous_cubic:hip"])
    first, *others = context.prepared.train
    unusable = replace(first, used=np.zeros_like(first.used))
    context = replace(context, prepared=replace(context.prepared, train=(unusable, *others)))
    _, scores = context.rank(state_with(context).last, 1)
    assert scores[0].name == "torque_offset:knee" and scores[0].share > 0.1


def test_a_spring_stands_for_the_backlash_without_a_gap_that_is_the_same():
    context = search({"joint_spring:knee": ([3.0, 0.2], [])}, ["joint_spring:knee", "backlash:knee"])
    found = forward(context, state_with(context))
    assert found.names == ("joint_spring:knee",)
    assert found.last.alike == found.last.never == ()


def test_a_drift_and_a_spring_contain_an_offset_and_friction_does_not():
    names = ["torque_offset:knee", "torque_drift:knee", "joint_spring:knee", "viscous_quadratic:knee"]
    context = search(OFFSET, names)
    start = state_with(context).last
    evidence = context.evidence(start, draws=0)
    offset, drift, spring, friction = (context.weighed(start, evidence, context.library.find(name)) for name in names)
    assert contains(context, start, evidence, drift.candidate, offset)
    assert contains(context, start, evidence, spring.candidate, offset)
    assert not contains(context, start, evidence, friction.candidate, offset)
    refined, _ = refine(evidence, drift, start.fitted)
    assert refined.candidate.nodes.shape[1] == 1
    assert contains(context, start, evidence, refined.candidate, offset)
    found = forward(context, state_with(context))
    assert found.names == ("torque_offset:knee",)
    assert found.last.alike == ()


@pytest.mark.parametrize("objection", ["on_bound", "undetermined"])
def test_what_fits_only_on_its_bound_or_may_be_absent_is_no_look_alike(objection, monkeypatch):
    context = search({"joint_spring:hip": ([3.0, 0.2], [])}, ["joint_spring:hip", "hardening_spring:hip"], noise=0.4)
    found = forward(context, state_with(context))
    assert found.names == ("joint_spring:hip",) and found.last.alike == ("hardening_spring:hip",)
    monkeypatch.setattr(choice, objection, lambda fitted, name, *rules: "so it is" * (name == found.last.alike[0]))
    assert forward(context, state_with(context)).last.alike == ()


def test_a_spring_is_named_where_an_offset_does_not_do():
    context = search({"joint_spring:knee": ([3.0, 0.2], [])}, ["torque_offset:knee", "joint_spring:knee"])
    assert forward(context, state_with(context)).names == ("joint_spring:knee",)


def test_nothing_is_named_that_is_no_larger_than_what_the_filter_gets_wrong():
    fresh = search({**STRIBECK, **OFFSET}, ["stribeck:hip", "torque_offset:knee"])
    context = replace(fresh, prepared=replace(fresh.prepared, filter_error=np.full(2, 5.0)))
    found = forward(context, state_with(context))
    assert found.names == ()
    assert any("filter and derivatives alone get 5" in one.reason for one in context.doubts.values())
    assert take_back(context, found).left is None


def test_an_offset_is_no_proxy_for_a_curve_that_contains_it():
    hidden = {"torque_offset:hip": ([2.5], []), "torque_ripple:hip": ([0.25, 0.15], [9.0])}
    context = search(hidden, ["torque_offset:hip"])
    found = take_back(context, state_with(context, "torque_offset:hip"))
    assert found.names == ("torque_offset:hip",)
    assert found.left is not None


@pytest.mark.parametrize("moment", [0.2, 0.29])
def test_a_wrong_zero_at_the_end_of_its_range_stays_the_look_alike_of_a_mass_off_axis(moment):
    context = search({"com_offset_shank": ([moment], [])}, ["encoder_offset_knee", "com_offset_shank"])
    found = forward(context, state_with(context))
    assert {*found.names, *found.last.alike} == {"com_offset_shank", "encoder_offset_knee"}
    assert found.last.never == found.last.alike


def test_a_mass_too_far_off_axis_for_any_wrong_zero_is_no_look_alike_of_one():
    context = search({"com_offset_shank": ([2.0], [])}, ["encoder_offset_knee", "com_offset_shank"])
    found = forward(context, state_with(context))
    assert (found.names, found.last.alike) == (("com_offset_shank",), ())


@pytest.mark.parametrize("hidden", [{"joint_elasticity:hip": ([], [0.002])}, {"torque_offset:hip": ([0.5], [])}])
def test_what_is_found_is_told_whatever_else_is_left(hidden):
    """Beside a ripple at the other joint, which is no candidate and far larger."""
    context = search({**hidden, "torque_ripple:knee": ([1.0, 0.6], [9.0])}, list(hidden))
    found = run_search(context, context.fit(Model.standard())).state
    assert found.names == tuple(hidden)
    assert found.left is not None and found.left.joint == "knee" and found.left.share > 0.5


def test_a_drift_is_no_offset_for_what_is_left_at_another_joint():
    """Most of the drift is a mean, as an offset is; what that leaves is nearly all a ripple at the hip."""
    hidden = {"torque_drift:knee": ([0.2], [0.0]), "torque_ripple:hip": ([1.5, 0.6], [9.0])}
    context = search(hidden, ["torque_drift:knee"])
    assert forward(context, state_with(context)).names == ("torque_drift:knee",)
