"""Blind trials with a person in the leg, and with a foot on the ground."""

import numpy as np
import pytest

from exoid.apps.campaign.trials.cases import CHAINS_PER_SEED, KINDS, Case, cases, simulated, subject
from exoid.apps.campaign.trials.count import counted, right
from exoid.apps.campaign.trials.people import PEOPLE, UNMEASURED, WALKING, as_measured, as_read, bench_of

COLUMNS = {
    "walk_plate": {"grf_x", "grf_z"}, "walk_switch": {"contact"}, "walk_nothing": set(), "worn_cuffs": {"f1", "f2"},
    "worn_nothing": set(),
}  # fmt: skip


@pytest.fixture(scope="module")
def runs():
    made = {}
    for kind in PEOPLE:
        case = Case(kind, (), 3)
        rng = np.random.default_rng(case.number)
        made[kind] = simulated(case, *subject(case, rng), rng)
    return made


@pytest.mark.slow
@pytest.mark.parametrize("kind", PEOPLE)
def test_recordings_of_a_kind_have_what_it_measures_and_all_of_it_acts(runs, kind):
    hidden, made = runs[kind]
    assert hidden == ()
    assert {*made[0].recording.columns()} - {"t", "q1", "q2", "tau1", "tau2"} == COLUMNS[kind]
    assert {*as_measured(made)[0].forces} == {*made[0].true.model.channels}
    assert np.ptp(made[0].motion.force, axis=0).min() > 5.0
    used = np.mean([one.torque_valid.all(axis=1).mean() for one in as_read(made)])
    assert 0.3 < used < 0.5 if kind == "walk_switch" else used == 1.0


@pytest.mark.parametrize("kind", PEOPLE)
def test_each_leg_is_another(kind):
    first, second = (bench_of(kind, np.random.default_rng(seed)) for seed in range(2))
    assert (first.walk or first.wearer) != (second.walk or second.wearer)
    assert (first.walk is not None) == (kind in WALKING)


def test_each_kind_is_part_of_a_campaign_with_effects_and_with_nothing():
    names = [case.name for case in cases([*PEOPLE], 2)]
    assert {*PEOPLE} <= {*KINDS} and len(names) == len({*names}) == 2 * len(PEOPLE) * (CHAINS_PER_SEED + 1)
    assert {Case.named(name).kind for name in names} == {*PEOPLE}


def line(kind, **told):
    usual = {"case": f"{kind}/nothing/0", "hidden": {}, "accepted": [], "verdict": "adequate", "says": ""}
    rms = {"base": [1.0, 1.0], "found": [1.0, 1.0], "true": [0.5, 1.0]}
    return {"kind": kind, "rms": rms, "covered_true": [], **usual, **told}


def test_what_is_not_measured_must_be_suspected_and_nothing_named():
    pushed = "Something outside the model pushes in part of the time."
    one = {"name": "stribeck:knee", "look_alikes": []}
    assert right(line("walk_nothing", verdict="unexplained", says=pushed))
    assert not right(line("walk_nothing", verdict="unexplained", says="It follows the hip angle."))
    assert not right(line("walk_nothing", verdict="unexplained", says=pushed, accepted=[one]))
    assert not right(line("walk_nothing"))
    assert right(line("worn_nothing", verdict="unexplained"))
    assert not right(line("worn_nothing"))
    assert right(line("worn_cuffs")) and right(line("walk_plate"))
    assert right(line("walk_switch", hidden={"stribeck:knee": {}}, accepted=[one], verdict="missing"))


def test_rows_of_these_kinds_stand_apart_from_those_with_nothing_hidden():
    hidden = {"stribeck:knee": {}}
    rows = counted([line("worn_cuffs"), line("worn_cuffs", hidden=hidden), *(line(kind) for kind in UNMEASURED)])
    assert [row[:3] for row in rows] == [
        ("walk_nothing, nothing hidden", "1", "0.0 %"),
        ("worn_cuffs", "1", "0.0 %"),
        ("worn_cuffs, nothing hidden", "1", "100.0 %"),
        ("worn_nothing, nothing hidden", "1", "0.0 %"),
    ]
    assert rows[1][4:6] == ("1", "0")
