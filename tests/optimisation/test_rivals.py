"""Comparison of optimisers: the same start for all, exact counts, nothing lost on the way, statistics by hand."""

from __future__ import annotations

import json
import re
import runpy
import sys
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from paper_leg import Leg, record

import exoid.optimisation.contest.problem as contest_module
from exoid.optimisation.contest import store as contest_store
from exoid.optimisation.contest.problem import Contest, ContestError, Outcome, contest_of, race
from exoid.optimisation.contest.rivals import entrants, rivals
from exoid.optimisation.contest.runtime import differences, expected_runtime, holm, runtime_ecdf
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.linear.loss import huber
from exoid.optimisation.linear.problem import Problem
from exoid.optimisation.optimiser import minimise
from exoid.optimisation.optimisers import optimisers
from exoid.optimisation.optimisers.nfo import NFO

SMALL = {"seeds": 4, "individuals": 12, "generations": 15, "jobs": 1}


@pytest.fixture(scope="module")
def fit():
    return identify(Leg(), [record(outliers=0.1, noise=5.0, samples=500, step=0.07)], optimisers=())


@pytest.fixture(scope="module")
def found(fit):
    return rivals(fit, **SMALL)


def test_everything_in_the_folder_competes(found):
    assert set(found.outcomes) == set(optimisers()) | {"nfo_whitened"}
    more = entrants(whitened=True)
    assert {f"{name}_whitened" for name in optimisers()} <= set(more)
    assert more["nfo"].optimiser.alpha == 0.8
    assert not more["nfo"].whitened


def test_all_of_one_seed_start_from_the_same_points(found):
    for seed in found.seeds:
        firsts = {round(runs[seed].at(np.array([12.0]))[0], 12) for runs in found.outcomes.values()}
        assert len(firsts) == 1
    assert len({runs[0].gaps[0] for runs in found.outcomes.values()}) <= 2
    assert found.outcomes["nfo"][0].gaps[0] != found.outcomes["nfo"][1].gaps[0]


def test_everyone_spends_the_budget_and_nobody_is_below_the_optimum(found):
    for runs in found.outcomes.values():
        for run in runs:
            assert run.evaluations == 12 * 15
            assert run.found_at[0] == 1
            assert run.found_at[-1] <= run.evaluations
            assert np.all(np.diff(run.found_at) > 0)
            assert np.all(np.diff(run.gaps) < 0)
            assert run.gap >= 0.0


def test_the_gap_is_that_of_the_parameters(found):
    contest = found.contest
    for runs in found.outcomes.values():
        again = contest.gap(huber(contest.data.residual(runs[0].x), contest.delta))
        assert runs[0].gap == pytest.approx(float(again), rel=1e-9, abs=1e-13)


def test_the_whole_box_is_searched_in_whitened_coordinates_too(fit):
    contest = contest_of(fit)
    physical = contest.problem()
    image = contest_module._image(physical, contest.data.factor.forward)
    corners = np.array(np.meshgrid(*zip(physical.low, physical.high, strict=True))).reshape(8, -1).T
    z = corners @ contest.data.factor.forward.T
    slack = 1e-9 * (image.high - image.low)
    assert np.all((z >= image.low - slack) & (z <= image.high + slack))
    assert np.allclose(image.physical(z), corners)


def test_improvements_are_counted_to_the_single_evaluation():
    values = iter([5.0, 7.0, 4.0, 4.0, 9.0, 3.0, 8.0, 2.0])
    problem = Problem(lambda x: np.array([next(values) for _ in x]), np.zeros(1), np.ones(1), ("a",), ("1",))
    run = minimise(problem, NFO(), individuals=4, generations=2)
    assert run.found_at.tolist() == [1, 3, 6, 8]
    assert run.found.tolist() == [5.0, 4.0, 3.0, 2.0]


@pytest.mark.parametrize("name", sorted(optimisers()))
def test_a_run_does_not_depend_on_the_others(fit, found, name):
    alone = race(found.contest, name, found.searches[name], 2)
    assert np.array_equal(alone.gaps, found.outcomes[name][2].gaps)


@pytest.mark.slow
def test_processes_find_what_one_process_finds(fit, found):
    two = rivals(fit, **{**SMALL, "jobs": 2})
    for name, runs in found.outcomes.items():
        for one, other in zip(runs, two.outcomes[name], strict=True):
            assert np.array_equal(one.gaps, other.gaps)


def test_any_executor_can_be_chosen_from_outside(fit, found):
    with ThreadPoolExecutor(2) as executor:
        two = rivals(fit, **{**SMALL, "engine": executor})
    assert all(np.array_equal(two.gaps(name), found.gaps(name)) for name in found.outcomes)


def stopped_after(count, monkeypatch):
    """Let the comparison be interrupted after `count` runs."""
    real, left = race, iter(range(count))

    def once_more(*arguments):
        if next(left, None) is None:
            raise KeyboardInterrupt
        return real(*arguments)

    # The package lends the function under the name of its module.
    monkeypatch.setattr(sys.modules["exoid.optimisation.contest.rivals"], "race", once_more)


def test_what_was_stopped_goes_on_where_it_was(fit, found, tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        stopped_after(7, patch)
        with pytest.raises(KeyboardInterrupt):
            rivals(fit, folder=tmp_path, **SMALL)
    kept = sorted(tmp_path.glob("*.json"))
    assert len(kept) == 7
    again = rivals(fit, folder=tmp_path, **SMALL)
    assert again.resumed == 7
    for name, runs in found.outcomes.items():
        assert [r.gap for r in runs] == [r.gap for r in again.outcomes[name]]
        assert np.array_equal(runs[0].found_at, again.outcomes[name][0].found_at)
    stopped_after(0, monkeypatch)
    assert rivals(fit, folder=tmp_path, **SMALL).resumed == SMALL["seeds"] * len(found.outcomes)


def test_files_that_are_broken_or_of_other_settings_are_not_believed(fit, tmp_path):
    small = {**SMALL, "seeds": 2, "competing": {"nfo": entrants()["nfo"]}}
    rivals(fit, folder=tmp_path, **small)
    one, two = sorted(tmp_path.glob("*.json"))
    one.write_text("{", "utf-8")
    content = json.loads(two.read_text("utf-8"))
    two.write_text(json.dumps({**content, "key": "0" * 64}), "utf-8")
    with pytest.warns(UserWarning, match="2 of the runs"):
        assert rivals(fit, folder=tmp_path, **small).resumed == 0
    assert rivals(fit, folder=tmp_path, **small).resumed == 2
    assert rivals(fit, folder=tmp_path, **{**small, "generations": 16}).resumed == 0
    other = identify(Leg(), [record(noise=5.0, samples=500, step=0.07, seed=1)], optimisers=())
    assert rivals(other, folder=tmp_path, **small).resumed == 0
    assert not list(tmp_path.glob(".*"))


def test_an_infinite_fitness_survives_the_file(fit, tmp_path):
    contest = contest_of(fit)
    search = entrants()["nfo"]
    store = contest_store.RunStore(tmp_path, contest)
    gap = float(contest.gap(huber(contest.data.residual(np.zeros(8)), contest.delta)))
    run = Outcome("nfo", 3, np.array([1.0, 5.0]), np.array([np.inf, gap]), np.zeros(8), 480, 0.1)
    store.write(run, search)
    back = store.read("nfo", search, 3)
    assert back.to_json() == run.to_json()


def test_meaningless_comparisons_are_refused(fit):
    with pytest.raises(ContestError, match="run-to-run variation"):
        rivals(fit, seeds=1)
    with pytest.raises(ContestError, match="at least 4 individuals"):
        rivals(fit, individuals=2, jobs=1)


def outcome(found_at, gaps, budget=100):
    return Outcome("a", 0, np.array(found_at, float), np.array(gaps, float), np.zeros(1), budget, 0.0)


def test_a_hit_is_the_first_evaluation_at_or_below_the_target():
    run = outcome([1, 4, 9], [10.0, 1e-2, 1e-5])
    assert [run.hit(t) for t in (100.0, 1e-2, 1e-3, 1e-6)] == [1, 4, 9, np.inf]
    assert run.at(np.array([1, 3, 4, 8, 9, 50.0])).tolist() == [10, 10, 1e-2, 1e-2, 1e-5, 1e-5]


def test_ert_counts_the_budget_of_runs_that_failed():
    rng = np.random.default_rng(0)
    known = expected_runtime(np.array([10.0, 30.0, np.inf]), 100.0, 1e-2, rng)
    assert known.ert == (10 + 30 + 100) / 2
    assert (known.hits, known.runs) == (2, 3)
    assert known.low <= known.ert <= known.high
    never = expected_runtime(np.array([np.inf, np.inf]), 100.0, 1e-2, rng)
    assert never.ert == np.inf and never.low == np.inf
    sure = expected_runtime(np.array([20.0, 20.0]), 100.0, 1e-2, rng)
    assert (sure.low, sure.ert, sure.high) == (20, 20, 20)


@pytest.mark.slow
def test_the_bootstrap_interval_covers_what_it_should():
    rng = np.random.default_rng(1)
    inside = 0
    for _ in range(200):
        hits = rng.exponential(50.0, 51)
        one = expected_runtime(np.where(hits <= 100.0, hits, np.inf), 100.0, 1e-2, rng)
        # Exponential times cut off at the budget: what is spent on average, θ(1 - e^(-b/θ)), over the share of
        # successes, 1 - e^(-b/θ), is θ.
        inside += one.low <= 50.0 <= one.high
    assert inside / 200 == pytest.approx(0.95, abs=0.05)


@given(st.lists(st.floats(0.0, 1.0), max_size=12))
def test_holm_never_lowers_a_p_value_and_keeps_their_order(p):
    corrected = holm(p)
    assert all(c >= min(1.0, x) for c, x in zip(corrected, p, strict=True))
    order = np.argsort(p, kind="stable")
    assert all(corrected[a] <= corrected[b] for a, b in pairwise(order))
    assert all(c <= 1.0 for c in corrected)


def test_holm_by_hand():
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])


def test_differences_are_found_where_they_are():
    rng = np.random.default_rng(0)
    base = np.exp(rng.normal(size=51))
    found = differences(
        {"a": base, "same": base * np.exp(rng.normal(0.0, 0.1, 51)), "worse": base * 3, "equal": base}, "a", "gap"
    )
    by_name = {d.first: d for d in found}
    assert by_name["worse"].p_holm < 1e-6 and by_name["worse"].losses == 51
    assert by_name["same"].p_holm > 0.01
    assert by_name["equal"].p == 1.0


def test_ecdf_is_the_share_of_pairs_solved():
    hits = np.array([[1.0, 5.0], [2.0, np.inf]])
    assert runtime_ecdf(hits, np.array([1.0, 2.0, 10.0])).tolist() == [0.25, 0.5, 0.75]


@pytest.mark.slow
def test_the_result_shows_itself(found):
    assert "certified optimum" in repr(found)
    assert all(name in found._repr_html_() for name in found.outcomes)
    frame = found.to_frame()
    assert len(frame) == 9 * len(found.outcomes)
    json.dumps(found.to_json())
    figure = found.plot()
    assert [a.get_title(loc="left") for a in figure.axes] == [
        "Way to the optimum",
        "Targets solved",
        "Expected running time",
    ]
    assert all(a.get_xlabel() and a.get_ylabel() for a in figure.axes)


@pytest.mark.slow
def test_iohinspector_reads_the_logs(found, tmp_path):
    inspector = pytest.importorskip("iohinspector")
    found.write_logs(tmp_path)
    manager = inspector.DataManager()
    manager.add_folder(str(tmp_path))
    overview = manager.overview
    assert len(overview) == 4 * len(found.outcomes)
    assert set(overview["algorithm_name"]) == set(found.outcomes)
    assert overview["best_y"].min() == pytest.approx(min(found.gaps(name).min() for name in found.outcomes))
    rows = manager.load(monotonic=True, include_meta_data=True)
    for name, runs in found.outcomes.items():
        mine = rows.filter(rows["algorithm_name"] == name)
        assert len(mine) == sum(len(run.gaps) for run in runs)
        assert np.allclose(sorted(mine["raw_y"]), sorted(np.concatenate([run.gaps for run in runs])))


@pytest.mark.slow
def test_the_paper_s_problem_is_proven_and_has_the_paper_s_size():
    contest = contest_module.paper_contest()
    assert isinstance(contest, Contest)
    assert contest.certificate.holds
    assert contest.data.tau.shape == (2, 3500)
    assert contest.budget == 16_000
    assert contest.fingerprint() == contest_module.paper_contest().fingerprint()
    assert contest.fingerprint() != contest_module.paper_contest(seed=1).fingerprint()


@pytest.mark.slow
def test_whitened_nfo_is_at_the_optimum_within_half_the_budget_on_every_seed():
    found = rivals(contest_module.paper_contest(), seeds=100, competing={"nfo_whitened": entrants()["nfo_whitened"]})
    assert np.all(found.hits("nfo_whitened", np.array([1e-12])) <= 8000)


@pytest.mark.slow
def test_the_example_of_the_page_runs(capsys, tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "add_an_optimiser.md").read_text(encoding="utf-8")
    (script,) = re.findall(r"^```python\n(.*?)^```", page, flags=re.S | re.M)
    (tmp_path / "page.py").write_text(script, "utf-8")
    runpy.run_path(str(tmp_path / "page.py"))
    assert "shrinking_whitened" in capsys.readouterr().out
