"""The paper made again: every file of the folder is an item, and what is said of it was found."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from exoid.apps.paper import items
from exoid.apps.paper.commands.paper import _plain
from exoid.apps.paper.experiments import ERRORS, Experiments
from exoid.apps.paper.item import FAILS, HOLDS, IN_PART, ItemAnswer, PaperTable, is_file
from exoid.apps.paper.items import equation_regressor, figure_2, figure_4, figure_9, figure_10, table_delta
from exoid.apps.paper.page import anchor, heading
from exoid.apps.paper.reproduce import PaperError, paper_items, reproduce_paper
from exoid.ground.engines.engine import EngineError, completed
from exoid.ground.folder import modules_in, names_in
from exoid.optimisation.contest.motion import MotionEntrant, motion_contest
from exoid.optimisation.contest.problem import paper_contest
from exoid.optimisation.excitation.design import design
from exoid.optimisation.fitting.settings import Search
from exoid.optimisation.linear.solve import solve_sse
from exoid.optimisation.optimisers.nfo import NFO
from exoid.workbench.command import main

PAGE = Path(__file__).resolve().parents[3] / "docs" / "paper.md"
QUICK = ("1", "13", "coriolis", "parameters")
"""Equations that need no recording."""


@pytest.fixture(scope="module")
def quick():
    return reproduce_paper(equation=QUICK, table=1, figure=("1", 2, "4"))


@pytest.mark.parametrize("name", names_in(items))
def test_a_file_of_the_folder_is_an_item(name):
    module = modules_in(items)[name]
    assert is_file(name)
    assert module.TITLE and module.SAYS.endswith(".") and callable(module.answer)


def test_every_number_and_word_is_one_item_of_its_kind():
    named = [(item.kind, number) for item in paper_items() for number in item.numbers]
    assert len(named) == len(set(named))
    assert {number for kind, number in named if kind == "figure" and number.isdecimal()} == set(map(str, range(1, 11)))
    assert {("table", "1"), ("equation", "1"), ("equation", "4"), ("equation", "16")} <= set(named)


def test_items_asked_for_come_in_the_order_of_the_paper(quick):
    names = [one.item.name for one in quick.answered]
    assert names == ["Figure 1", "Figure 2", "Figure 4", "Table 1", "Equation 1", "Equation 13", "Equation: coriolis",
                     "Equation: parameters"]  # fmt: skip


def test_each_line_says_what_the_paper_says_what_comes_out_and_whether_it_holds(quick):
    for one in quick.answered:
        for words in (one.item.says, one.answer.found, one.answer.holds, one.answer.why):
            assert words in one.line
        assert one.answer.why == "" if one.answer.holds == HOLDS else one.answer.why
        for picture in one.answer.pictures:
            assert picture.alt.endswith(".") and picture.figure.axes
    assert "Table 1" in quick._repr_html_() and json.dumps(quick.to_json())


def test_a_verdict_without_a_reason_is_refused():
    for holds, why in ((HOLDS, "because"), (FAILS, ""), ("perhaps", "because")):
        with pytest.raises(ValueError, match="has a reason"):
            ItemAnswer("something.", holds, why)


def test_what_is_not_in_the_paper_is_refused_with_what_is():
    with pytest.raises(PaperError, match=r"no figure 'x'(.|\n)*there are 1, 2") as refused:
        reproduce_paper(figure="x")
    assert refused.value.where == "--figure"
    with pytest.raises(PaperError, match="regressor"):
        reproduce_paper(equation="regresor")
    with pytest.raises(PaperError, match="two at least"):
        reproduce_paper(table=1, seeds=1)


def test_a_table_in_markdown_keeps_its_columns():
    lines = PaperTable(("a", "b"), [("1|2", "3")], "Of two:").markdown().splitlines()
    assert lines == ["Of two:", "", "| a | b |", "| --- | --- |", "| 1\\|2 | 3 |"]


@pytest.fixture(scope="module")
def two():
    experiments = Experiments(seeds=2)
    yield experiments
    experiments.close()


def test_a_power_in_a_formula_is_kept_in_the_terminal():
    assert _plain("`2*dtheta1*dtheta2**2`") == "2*dtheta1*dtheta2**2"
    assert _plain("**1.01** (`a**b` to **2**)") == "1.01 (a**b to 2)"


@pytest.mark.slow
def test_the_misprint_is_found_and_costs_error_at_the_hip(two):
    found = equation_regressor.answer(two)
    assert found.holds == IN_PART and "(1, 3)" in found.why and "15 of 16" in found.found
    assert two.printed_regressor["printed"][0] > two.printed_regressor["derived"][0]


def test_the_rule_for_the_thresholds_leaves_its_share_outside(two):
    assert table_delta.answer(two).holds == HOLDS
    for several in two.fits.values():
        for one in several:
            assert np.mean(np.abs(one.data.residual(one.sse)) > one.delta[:, None]) == pytest.approx(0.14, abs=1e-3)
            assert one.proof.holds


def test_errors_of_every_kind_spoil_only_what_is_measured(two):
    truths = [several[0].truth.tau for several in two.fits.values()]
    assert len(two.fits) == len(ERRORS)
    for truth in truths[1:]:
        np.testing.assert_array_equal(truth, truths[0])


def test_a_formula_elsewhere_than_at_the_knee_would_be_noticed(two):
    assert "from the knee" in figure_2.answer(two).found


def test_limits_that_are_broken_are_said_to_be(two, monkeypatch):
    monkeypatch.setattr(Experiments, "published", lambda self, period=10.0: _published_fast(self))
    found = figure_4.answer(two)
    assert found.holds == FAILS and "does not hold" in found.found


def _published_fast(experiments):
    from exoid.measurement.trajectories.trajectory import paper_trajectory
    from exoid.optimisation.excitation.design import evaluate

    return evaluate(paper_trajectory(8.0), experiments.leg)


@pytest.mark.slow
def test_infinite_thresholds_are_the_sum_of_squares():
    squared = paper_contest(individuals=8, generations=20, delta=np.full(2, np.inf))
    best = solve_sse(squared.data)
    assert squared.function == "sse" and paper_contest().function == "huber"
    assert squared.best == pytest.approx(float(np.sum(squared.data.residual(best) ** 2)), rel=1e-12)
    problem, start = squared.setting(Search(NFO()), 0)
    assert np.all((problem.low < best) & (best < problem.high))
    values = problem.fitness(start)
    np.testing.assert_allclose(values, [squared.value(x, Search(NFO())) for x in start], rtol=1e-9)
    assert np.all(squared.gap(values) >= 0.0) and squared.gap(squared.best) == 0.0


def test_a_motion_may_be_sought_in_a_box_of_any_width():
    from tests.optimisation.test_motion_contest import contest

    for half, found in ((0.05, True), (1.0, False)):
        problem, first = contest().setting(MotionEntrant(NFO(), penalised=True, half=half), 3)
        assert np.all(problem.high == half) and np.abs(first).max() <= half
        assert np.isfinite(problem.fitness(first)).any() == found


def test_the_names_of_entrants_say_how_they_search():
    names = [figure_9.written_entrant(name) for name in ("cma_es_penalty", "pso")]
    assert names == ["CMA-ES, ∞ outside", "PSO"]


def short(experiments, monkeypatch):
    """Let everything that competes have the fewest generations that can be drawn."""
    from exoid.apps.paper import experiments as module

    quick = design(individuals=6, generations=20)
    experiments.__dict__["designs"] = {"condition": quick}
    small = motion_contest(individuals=6, generations=3, found=quick)
    monkeypatch.setattr(module, "motion_contest", lambda *a, **k: small)
    monkeypatch.setattr(module, "paper_contest", lambda *a, **k: paper_contest(individuals=6, generations=3, **k))
    return experiments


@pytest.mark.slow
def test_what_competes_is_judged_by_what_it_found(two, monkeypatch):
    """In three generations nobody is near an optimum, and who is ahead is said."""
    few = short(Experiments(seeds=2), monkeypatch)
    motions, fits = figure_9.answer(few), figure_10.answer(few)
    assert fits.holds in (HOLDS, FAILS) and "proven optimum" in fits.found and len(fits.tables) == 2
    ends = {name: float(np.median(figure_9.run_conditions(few.on_motions, name))) for name in few.on_motions.outcomes}
    ahead = min(("nfo", "pso", "ga"), key=lambda name: ends[name])
    assert motions.holds == (HOLDS if ahead == "nfo" else FAILS) or ahead.upper() in motions.why
    assert {row[0] for row in motions.tables[0].rows} == {"NFO", "PSO", "GA", "DE", "CMA-ES"}
    shared = few.engine
    few.close()
    with pytest.raises(EngineError, match="takes no more jobs"):
        list(completed(shared, abs, [1], lambda one: (one,)))


def test_what_needs_no_processes_starts_none(two):
    two.close()
    assert table_delta.answer(two) and "engine" not in two.__dict__


def test_the_page_has_every_item_with_its_command():
    page = PAGE.read_text(encoding="utf-8")
    for item in paper_items():
        assert f"```sh\n{item.command}\n```" in page and item.says in page, "run python benchmarks/paper.py"


def test_what_needs_no_chance_is_on_the_page_as_it_comes_out(quick):
    from exoid.apps.paper.page import section

    page = PAGE.read_text(encoding="utf-8")
    for one in quick.answered:
        assert section(one) in page, f"{heading(one)}: run python benchmarks/paper.py"
        assert f"(#{anchor(one)})" in page


def test_the_command_lists_all(capsys):
    assert main(["paper", "--list"]) == 0
    said = capsys.readouterr().out
    for item in paper_items():
        assert item.command.split()[-1] in said
    assert main(["paper", "--list", "--figure", "1"]) == 2
    assert "leave out --list" in " ".join(capsys.readouterr().err.split())


@pytest.mark.slow
def test_the_command_writes_a_page_its_pictures_and_a_report(tmp_path, capsys):
    out = tmp_path / "paper"
    assert main(["paper", "--figure", "4", "--table", "1", "--out", str(out), "--json", str(tmp_path / "p.json")]) == 0
    said = capsys.readouterr().out
    assert "every limit holds" in " ".join(said.split()) and "±1.92" in said
    page = (out / "paper.md").read_text(encoding="utf-8")
    assert "paper_excitation.png" in page and (out / "paper_excitation.png").read_bytes()[:4] == b"\x89PNG"
    assert (out / "report.html").exists()
    result = json.loads((tmp_path / "p.json").read_text(encoding="utf-8"))
    assert result["schema"] == "exoid.paper/1" and [one["item"]["numbers"] for one in result["items"]] == [["4"], ["1"]]


def test_the_command_refuses_what_the_paper_does_not_have(capsys):
    assert main(["paper", "--table", "9"]) == 2
    assert "there is no table '9'" in capsys.readouterr().err
