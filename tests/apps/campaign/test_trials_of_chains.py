"""Evidence and blind trials on machines that are not the leg."""

from dataclasses import replace

import numpy as np
import pytest

from exoid.apps.campaign.trials.cases import Case, cases, hide, simulated, singles, subject, visible
from exoid.apps.campaign.trials.chains import CHAINS
from exoid.apps.campaign.trials.count import HEADS, counted, describe_miss
from exoid.diagnosis.discovery import discover
from exoid.diagnosis.evidence.columns import Columns, stacked
from exoid.diagnosis.evidence.fitted import fitted_model
from exoid.diagnosis.evidence.library import Library, build_library
from exoid.diagnosis.rules import RULES
from exoid.diagnosis.search.context import SearchContext
from exoid.diagnosis.search.engine import forward
from exoid.diagnosis.search.state import State
from exoid.measurement.bench.hidden import Hidden
from exoid.measurement.bench.simulation import Bench, run_bench
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.joints import LEVER, Joint
from exoid.symbolic.model import Model
from exoid.symbolic.term import Term

DRIVE = Model("drive", joints=(Joint("axis"),))
SLIDE = Model("slide", gravity=0.0, joints=(Joint("axis", "prismatic"),))


def test_what_a_term_with_a_choice_leaves_is_weighed_on_one_joint():
    model = DRIVE.with_effect("end_stop:axis")
    runs = [run_bench(DRIVE, seed=1, index=k, bench=Bench(duration=6.0)).recording for k in range(2)]
    prepared = prepare(model, runs, cutoff=6.0)
    fitted = fitted_model(identify(model, prepared.train, optimisers=()), prepared)
    evidence = fitted.evidence(seed=0, draws=0)
    assert [block.columns.shape[::2] for block in evidence.blocks] == [(1, len(model.parameters) + 2)] * 2


def test_noise_is_estimated_where_the_joint_moves():
    run = run_bench(DRIVE, seed=2, bench=Bench(duration=12.0)).recording
    one = prepare(DRIVE, [run], cutoff=8.0)
    chatter = np.where(one.train[0].stuck, 3.0 * np.sin(2.5 * np.arange(len(one.train[0].stuck)))[:, None], 0.0)
    assert len(chatter) == len(run.tau) and chatter.any(axis=0).all()
    rough = prepare(DRIVE, [replace(run, tau=run.tau + chatter)], cutoff=8.0)
    np.testing.assert_allclose(rough.noise_floor, one.noise_floor, rtol=0.2)


def test_shapes_of_a_sliding_joint_are_those_of_a_drum():
    for name in ("stribeck", "torque_ripple", "backlash", "hysteresis", "end_stop", "time_delay", "joint_elasticity"):
        turning, sliding = (Term(m.find_effect(name), "axis", m.joints).placed_shape for m in (DRIVE, SLIDE))
        for key, shape in turning.items():
            scale = sliding[key].max / shape.max
            wanted = {"v_s": LEVER, "n": 1.0 / LEVER, "h": LEVER, "sigma": 1.0 / LEVER}.get(key, 1.0)
            assert scale == pytest.approx(wanted) and sliding[key].min == pytest.approx(wanted * shape.min), key
    assert Term(SLIDE.find_effect("torque_ripple"), "axis", SLIDE.joints).placed_shape["n"].unit == "1/m"


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["drive", "slide"])
def test_what_is_hidden_in_other_machines_can_be_seen(kind):
    names = [case.name for case in cases([kind], 1, first=3)]
    assert names == [case.name for case in cases([kind], 1, first=3)] and names[-1] == f"{kind}/nothing/3"
    case = Case.named(names[0])
    rng = np.random.default_rng(case.number)
    model, machine = subject(case, rng)
    (hidden,) = hide(case, model, machine, rng)
    assert hidden.name in singles(model) and visible(hidden, model, machine) > 0.05
    term = Term(hidden.effect, hidden.joint, model.joints)
    for key, shape in term.placed_shape.items():
        assert shape.min <= hidden.values[key] <= shape.max


def test_machines_with_nothing_hidden_are_counted_apart():
    line = {"kind": "drive", "verdict": "adequate", "accepted": [], "covered_true": [True], "hidden": {}}
    line |= {"case": "drive/nothing/1", "rms": {"base": [1.0], "found": [1.0], "true": [1.0]}}
    wrong = {**line, "hidden": {"stribeck:axis": {}}}
    rows = counted([line, wrong])
    assert [row[:3] for row in rows] == [("drive", "1", "0.0 %"), ("drive, nothing hidden", "1", "100.0 %")]


def test_what_would_not_have_lowered_the_error_is_a_miss_that_could_not_be_told():
    line = {"kind": "drive", "verdict": "adequate", "accepted": [], "covered_true": [], "hidden": {"stribeck:axis": {}}}
    line |= {"case": "drive/stribeck:axis/1", "unexplained": {"significant": False}}
    lines = [{**line, "rms": {"base": [1.0], "found": [1.0], "true": [true]}} for true in (0.999, 0.9)]
    column = HEADS.index("could not be told")
    assert [row[column - 1 : column + 1] for row in counted(lines)] == [("2", "1")]
    assert [text.endswith("could not be told") for text in map(describe_miss, lines)] == [True, False]
    spring = {"name": "joint_spring:axis", "look_alikes": []}
    for found, told in ((0.9, False), (0.95, True)):  # what was named instead predicts unseen motion as well, or not
        named = {**lines[1], "accepted": [spring], "rms": {"base": [1.0], "found": [found], "true": [0.9]}}
        assert describe_miss(named).endswith("could not be told") is not told


def test_sizes_are_drawn_with_the_sign_of_their_typical_value():
    case = Case.named("drive/cuff_interaction/300")
    rng = np.random.default_rng(case.number)
    (hidden,) = hide(case, *subject(case, rng), rng)
    assert hidden.values["k"] > 0.0 and hidden.values["d"] > 0.0


def test_every_kind_of_machine_is_drawn_anew():
    for draw in CHAINS.values():
        one, other = (draw(np.random.default_rng(seed)) for seed in (0, 1))
        assert one.joint_names == other.joint_names and one.motion_limits != other.motion_limits


@pytest.mark.slow
def test_a_cuff_on_one_joint_is_the_look_alike_of_the_mass_off_axis_that_it_is():
    names = ["encoder_offset:axis", "com_offset:axis", "cuff_interaction", "gravity_tilt"]
    hidden = [Hidden(DRIVE.find_effect("com_offset"), "axis", {"m_y": 0.08})]
    runs = [
        run_bench(DRIVE, effects=hidden, seed=4, index=k, bench=Bench(duration=20.0)).recording for k in range(3)
    ]
    prepared = prepare(DRIVE, runs[:2], runs[2:], cutoff=6.0)
    library = build_library(DRIVE, prepared.all)
    context = SearchContext(prepared, Library(tuple(map(library.find, names))), rules=replace(RULES, placebos=199))
    found = forward(context, State((context.fit(DRIVE),)))
    assert {*found.names, *found.last.alike} == {*names} and len(found.names) == 1
    assert {*found.last.never} == {*found.last.alike}


@pytest.mark.slow
def test_friction_that_builds_up_slowly_is_no_late_torque():
    """It lags behind the direction of motion as a late torque does; the entry explains more than another timing."""
    case = Case.named("drive/hysteresis:axis/900")
    rng = np.random.default_rng(case.number)
    model, machine = subject(case, rng)
    runs = [run.recording for run in simulated(case, model, machine, rng)[1]]
    assert discover(model, runs[:2], runs[2:]).verdict == "missing"


def test_columns_in_other_units_count_beside_each_other():
    """A ridge is relative to the largest column, and would hide an effect that explains nearly all."""
    rng = np.random.default_rng(1)
    noise = rng.standard_normal((2, 2, 1, 1, 400, 1))
    parts = [[Columns((0,), size * one) for one in each] for size, each in zip((1e-2, 1e7), noise, strict=True)]
    rows = stacked(parts, 1)
    assert [one.values.shape for one in rows] == [(1, 1, 400, 2)] * 2
    whole = np.concatenate([one.values[0, 0] for one in rows])
    np.testing.assert_allclose(np.sqrt(np.mean(whole**2, axis=0)), 1.0)
    for k, part in enumerate(parts):
        ratio = rows[1].values[0, 0, :, k] / rows[0].values[0, 0, :, k]
        np.testing.assert_allclose(ratio, part[1].values.ravel() / part[0].values.ravel())
