"""Optimisers on the paper's other problem: the same motions, limits and budget for all, against the best known."""

from __future__ import annotations

import json

import numpy as np
import pytest

from exoid.optimisation.contest.motion import MotionContest, MotionEntrant, motion_entrants
from exoid.optimisation.contest.rivals import entrants, rivals
from exoid.optimisation.contest.subject import ContestError
from exoid.optimisation.excitation.design import design
from exoid.optimisation.optimisers import optimisers
from exoid.optimisation.optimisers.nfo import NFO
from exoid.symbolic.model import Model

LEG = Model.standard()
KNOWN = {"condition": 55.03, "d_optimal": -89.79, "worst": 0.0134}
RESCALED, PENALISED = MotionEntrant(NFO()), MotionEntrant(NFO(), penalised=True)
WEIGHED = MotionEntrant(NFO(), whitened=True)


def contest(criterion="condition", **size):
    known = {"CMA-ES, refined": KNOWN[criterion]}
    return MotionContest(name="motions", model=LEG, criterion=criterion, known=known, **size)


def test_every_optimiser_competes_with_and_without_the_penalty():
    names = entrants(problem="excitation")
    assert set(names) == {*optimisers(), *(f"{name}_penalty" for name in optimisers())}
    assert {f"{name}_whitened" for name in optimisers()} <= set(motion_entrants(optimisers(), whitened=True))


@pytest.mark.parametrize("criterion", KNOWN)
def test_rescaled_motions_are_all_worth_something_and_penalised_ones_few(criterion):
    one = contest(criterion)
    (free, first), (bound, near) = (one.setting(search, 3) for search in (RESCALED, PENALISED))
    assert np.isfinite(free.fitness(first)).all()
    assert np.isinf(bound.fitness(first)).all() and np.isinf(bound.fitness(near)).any()
    assert first.shape == (20, 20) and np.abs(first).max() <= 1.0 and np.abs(near).max() <= 0.2


def test_a_motion_inside_the_limits_is_worth_no_more_with_a_penalty():
    one = contest()
    bound, near = one.setting(PENALISED, 3)
    small = 0.02 * near
    free = one.setting(RESCALED, 3)[0]
    assert np.isfinite(bound.fitness(small)).all() and np.all(free.fitness(small) <= bound.fitness(small))


def test_coordinates_in_which_harmonics_weigh_alike_are_the_same_motions():
    one = contest()
    weighed, points = one.setting(WEIGHED, 0)
    basis = one._search(False).space.basis
    radians = points * np.concatenate([np.diag(each) for each in basis])
    np.testing.assert_allclose(weighed.fitness(points), one.setting(RESCALED, 0)[0].fitness(radians), rtol=1e-9)


def test_distances_are_from_the_best_known():
    assert contest().gap(np.array([55.03, 60.533, 50.0, np.inf])) == pytest.approx([0.0, 0.1, 0.0, np.inf])
    # Eight numbers: a determinant of the information e^16 times smaller makes the ellipsoid's half-axes e times longer.
    assert contest("d_optimal").gap(np.array([-89.79 + 16.0])) == pytest.approx([np.e - 1.0])


def test_they_compete_and_go_on_where_they_were(tmp_path):
    size = {"seeds": 3, "jobs": 1, "folder": tmp_path / "runs"}
    names = ("nfo", "cma_es", "nfo_penalty")
    chosen = {name: search for name, search in entrants(problem="excitation").items() if name in names}
    one = contest(individuals=8, generations=6)
    found = rivals(one, competing=chosen, **size)
    assert found.reference == "nfo" and found.resumed == 0
    assert rivals(one, competing=chosen, **size).resumed == 9
    for name, runs in found.outcomes.items():
        assert all(run.evaluations == 48 for run in runs)
        worth = [one.value(run.x, found.searches[name]) for run in runs]
        np.testing.assert_allclose(one.gap(np.array(worth)), found.gaps(name), rtol=1e-9)
    first = {round(found.outcomes[name][0].at(np.array([8.0]))[0], 12) for name in ("nfo", "cma_es")}
    assert len(first) == 1
    assert found.figures() and "best known" in repr(found)
    told = json.loads(json.dumps(found.to_json()))
    assert told["about"]["criterion"] == "condition" and told["certificate"] is None
    found.write_logs(tmp_path / "ioh")
    log = json.loads((tmp_path / "ioh" / "nfo" / "IOHprofiler_f1_condition.json").read_text("utf-8"))
    assert log["scenarios"][0]["dimension"] == 20


def test_recordings_do_not_belong_to_it():
    with pytest.raises(ContestError, match="a model alone"):
        rivals(LEG, [object()], problem="excitation")


@pytest.mark.slow
def test_motions_compete_with_one_that_was_designed():
    few = {"individuals": 6, "generations": 20}
    found = design(criterion="worst", **few)
    names = {name: one for name, one in entrants(problem="excitation").items() if name in ("nfo", "nfo_penalty")}
    raced = rivals(found, seeds=2, competing=names, jobs=1, **few)
    assert raced.contest.criterion == "worst"
    assert raced.contest.known == {one.name: one.value for one in found.candidates}
    with pytest.raises(ContestError, match=r"period=8\.0"):
        rivals(design(period=8.0, **few), seeds=2)
