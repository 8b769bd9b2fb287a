"""Thresholds of the search lie where they are said to: moves with made-up candidates, whose gains are just so large."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from synthetic import recording
from test_rules_of_evidence import at, block, candidate, noise

from exoid.diagnosis.evidence import simulated
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.stretches import searched_stretches
from exoid.diagnosis.rules import RULES
from exoid.diagnosis.search import choice, engine
from exoid.diagnosis.search.choice import contains, outlives_noise, refitted, shortlist
from exoid.diagnosis.search.doubt import made_by_the_filter
from exoid.diagnosis.search.exchange import _rivals
from exoid.diagnosis.search.state import State
from exoid.optimisation.preparation.cutoff import CutoffChoice
from exoid.optimisation.preparation.prepare import Prepared
from exoid.symbolic.motion import Motion


def score(name: str, share: float, numbers: int = 1, **more) -> SimpleNamespace:
    """A score of a candidate of so many numbers, none of them a shape."""
    one = candidate(name=name, numbers=numbers)
    one.term.effect.shape = {}
    return SimpleNamespace(name=name, share=share, candidate=one, **more)


@pytest.mark.shows("most")
def test_what_comes_near_the_best_is_refitted(monkeypatch):
    monkeypatch.setattr(choice, "look_alikes", lambda *asked: {})
    context = SimpleNamespace(rules=RULES, refined=lambda evidence, extension, one: (one, []))
    scores = [score("best", 0.5), score("near", 0.45), score("not", 0.35)]
    assert [one.name for one in shortlist(context, None, None, scores)[0]] == ["best", "near"]


@pytest.mark.shows("half")
def test_what_gains_less_than_half_of_a_term_is_no_rival_of_it():
    scores = [score("term", 0.5), score("rival", 0.3), score("not", 0.2)]
    assert _rivals(SimpleNamespace(rules=RULES, ranked={(): (None, scores)}), scores[0]) == ["rival"]


def chosen(losses, monkeypatch, failed=()):
    """What a refit chooses of candidates with these numbers and losses in 16 blocks, {name: (numbers, losses)}."""

    def with_term(extension, one):
        fitted = SimpleNamespace(joint_losses=lambda scale, rules: losses[one.name][1][None])
        return choice.Extension(fitted, one)

    # What a score was refined to has one node, the columns that are kept have all: only the library's goes with them.
    context = SimpleNamespace(
        rules=RULES, with_term=with_term, unseen_gain=lambda before, after: 1.0, doubt=lambda before, after: "",
        library=SimpleNamespace(find="all nodes of {}".format),
    )  # fmt: skip
    monkeypatch.setattr(choice, "outlives_noise", lambda *asked: True)
    monkeypatch.setattr(choice, "contains", lambda *asked: not asked[3].startswith("all nodes of"))
    monkeypatch.setattr(choice, "_twins", lambda *asked: [])
    monkeypatch.setattr(choice, "on_bound", lambda *asked: "")
    monkeypatch.setattr(choice, "undetermined", lambda *asked: "")
    rivals = [score(name, 0.5, numbers, folds=np.full(3, hash_of(name))) for name, (numbers, _) in losses.items()]
    extension = SimpleNamespace(fitted=SimpleNamespace(scale=np.ones(1)))
    return refitted(context, extension, None, rivals, (), failed)


def hash_of(name: str) -> float:
    return float(sum(map(ord, name)))


def behind(lag: float) -> np.ndarray:
    """Losses in 16 blocks that lie `lag` standard errors above those of the best, which are 9 each."""
    return 9.0 + lag / 4.0 + np.tile([1.0, -1.0], 8)


@pytest.mark.shows("tied")
@pytest.mark.parametrize(("lag", "found"), [(0.7, "plain"), (1.4, "best")])
def test_the_plainer_of_two_that_tie_is_taken(lag, found, monkeypatch):
    assert chosen({"best": (2, np.full(16, 9.0)), "plain": (1, behind(lag))}, monkeypatch).added.name == found


@pytest.mark.shows("clear")
@pytest.mark.parametrize(("lag", "alike"), [(2.0, ("rival",)), (3.0, ())])
def test_a_refit_distinguishes_what_lags_clearly(lag, alike, monkeypatch):
    assert chosen({"best": (1, np.full(16, 9.0)), "rival": (1, behind(lag))}, monkeypatch).alike == alike


@pytest.mark.parametrize("lag", [2.0, 3.0])
def test_what_failed_its_placebos_is_not_chosen_and_stays_a_look_alike(lag, monkeypatch):
    """What hardly varies resembles itself when it is shifted: no placebo can tell it from chance."""
    losses = {"best": (1, np.full(16, 9.0)), "other": (1, behind(lag)), "worse": (1, behind(9.0))}
    found = chosen(losses, monkeypatch, failed=("best",))
    assert found.added.name == "other" and found.alike == ("best",)


@pytest.mark.shows("refitted")
@pytest.mark.parametrize(("before", "found"), [(4, "best"), (5, "0")])
def test_five_rivals_are_refitted(before, found, monkeypatch):
    losses = {str(k): (1, behind(9.0)) for k in range(before)} | {"best": (1, np.full(16, 9.0))}
    assert chosen(losses, monkeypatch).added.name == found


@pytest.mark.shows("negligible")
@pytest.mark.parametrize(("missed", "inside"), [(1.5e-3, True), (3e-3, False)])
def test_an_effect_contains_a_plainer_one_of_which_it_misses_next_to_nothing(missed, inside):
    """At the limit of its shape, the first of three nodes, the rival is the plainer effect but for a part."""
    own, other = noise(1), noise(2)
    own /= np.linalg.norm(own)
    other -= own * (own @ other)
    other /= np.linalg.norm(other)
    plain, rival = score("plain", 0.5, coefficients=[1.0]), score("rival", 0.5)
    rival.candidate.nodes = np.array([[[0.0], [1.0], [2.0]]])
    nodes = np.array([np.sqrt(1.0 - missed) * own + np.sqrt(missed) * other, noise(3), noise(4)])
    columns = [Columns((0,), nodes[:, None, :, None])]
    library = SimpleNamespace(columns=lambda one, fitted: columns, find=lambda name: rival.candidate)
    context = SimpleNamespace(library=library, columns_of=lambda one, fitted: at(own))
    evidence = Evidence([block(noise(5))], [], seed=0, draws=0)
    assert contains(context, SimpleNamespace(fitted=None), evidence, rival.candidate, plain) is inside


@pytest.mark.shows("artefact")
@pytest.mark.parametrize(("without", "stays"), [(0.04, True), (0.05, False)])
def test_a_term_gains_more_than_twice_what_it_gains_where_it_is_certainly_not(without, stays, monkeypatch):
    """A gain of 10 %, at least a hundredth of it beyond what recordings show that the model without it made itself."""
    made = SimpleNamespace(evidence=lambda **asked: SimpleNamespace(fold_losses=np.ones(1)))
    monkeypatch.setattr(simulated, "replace", lambda one, **changes: one)
    monkeypatch.setattr(simulated, "columns_at", lambda *asked: [])
    gains = iter([0.5 * without, 1.5 * without])
    monkeypatch.setattr(simulated, "weigh", lambda *asked: SimpleNamespace(share=next(gains)))
    context = SimpleNamespace(rules=RULES, simulated=lambda extension: (made, made))
    evidence = SimpleNamespace(fold_losses=np.ones(1), sigma=np.ones(1), rules=RULES)
    one = score("it", 0.1, shape=np.zeros((1, 0)))
    assert outlives_noise(context, SimpleNamespace(fitted=None), evidence, one) is stays


@pytest.mark.shows("many_numbers")
@pytest.mark.parametrize(("numbers", "found"), [(3, "many"), (4, "plain")])
def test_an_effect_of_many_numbers_is_compared_with_plainer_ones(numbers, found, monkeypatch):
    def state(name, count):
        return State((SimpleNamespace(added=None), SimpleNamespace(added=score(name, 0.5, count))))

    monkeypatch.setattr(
        engine,
        "search_without_proxies",
        lambda context, begun: state("plain", 2) if begun.banned else state("many", numbers),
    )
    context = SimpleNamespace(rules=RULES, rank=lambda start, step: (None, ()), unseen_gain=lambda before, after: 0.0)
    assert engine.run_search(context, SimpleNamespace(added=None)).state.names == (found,)


@pytest.mark.shows("rounds")
@pytest.mark.parametrize(("proxies", "ended"), [(3, True), (4, False)])
def test_the_search_goes_on_four_times_after_it_took_back_a_proxy(proxies, ended, monkeypatch):
    """A search that ends by itself has looked at what is left in its last round; one that is cut short looks then."""
    start = State((SimpleNamespace(added=None), SimpleNamespace(added=score("it", 0.5))))
    taken = iter([*(replace(start, extensions=start.extensions[:1]) for _ in range(proxies)), *[start] * 9])
    monkeypatch.setattr(engine, "add_and_drop", lambda context, state: start)
    monkeypatch.setattr(engine, "drop_unsteady", lambda context, state: state)
    monkeypatch.setattr(engine, "take_back", lambda context, state: next(taken))
    monkeypatch.setattr(engine, "left_over", lambda context, extension: "cut short")
    assert (engine.search_without_proxies(SimpleNamespace(rules=RULES), start).left is None) is ended


@pytest.mark.shows("artefact")
@pytest.mark.parametrize(("times", "doubted"), [(1.7, True), (2.4, False)])
def test_a_term_takes_off_more_than_the_filter_gets_wrong(times, doubted):
    joint = SimpleNamespace(name="knee", unit=lambda kind: "N·m")
    prepared = SimpleNamespace(filter_error=np.array([0.1]))
    model = SimpleNamespace(joints=[joint])
    before = SimpleNamespace(fitted=SimpleNamespace(evaluation_rms=np.array([np.hypot(0.5, 0.1 * times)])))
    fitted = SimpleNamespace(evaluation_rms=np.array([0.5]), prepared=prepared, model=model)
    after = SimpleNamespace(fitted=fitted, added=None)
    assert bool(made_by_the_filter(before, after, RULES)) is doubted


# -- long recordings ------------------------------------------------------------------------------------------


def long_recording(seconds: float):
    one = recording("run", 0, {})
    count = int(seconds * one.rate)
    still, flags = np.zeros((count, 2)), np.ones((count, 2), bool)
    motion = Motion(np.arange(count) / one.rate, still, still, still, still)
    return replace(
        one, motion=motion, torque=still.T, wide_tau=still, used=flags.T, stuck=~flags, kept=np.arange(count)
    )  # fmt: skip


@pytest.mark.shows("whole_seconds", "stretch_seconds", "searched_seconds")
def test_long_recordings_are_searched_in_stretches():
    def prepared(fitted: float, aside: float) -> Prepared:
        return Prepared(
            (long_recording(fitted),), (long_recording(aside),), CutoffChoice(5.0, "fixed"), np.ones(2),
            filter_error=np.zeros(2), acceleration_noise=0.0,
        )  # fmt: skip

    short = prepared(600.0, 280.0)
    assert searched_stretches(short) is short
    cut = searched_stretches(prepared(1000.0, 500.0))
    assert len(cut.train) == 600 / 30 and len(cut.verify) == 300 / 30
    assert cut.train[0].t[-1] - cut.train[0].t[0] == pytest.approx(30.0, abs=0.1)
    assert len(searched_stretches(prepared(700.0, 250.0)).train) == 20  # a little more than is searched whole


def test_what_is_left_has_its_turn_where_all_that_came_near_have_failed(monkeypatch):
    """The best by far fails its placebos; the others do not come near it."""
    best = score("best", 0.9, eligible=True, significant=False)
    first, other = (score(name, 0.5, eligible=True, significant=True) for name in ("first", "other"))
    context = SimpleNamespace(rules=RULES, tested=lambda extension, one: one, sure=lambda one: False)
    monkeypatch.setattr(choice, "shortlist", lambda *asked: ([max(asked[3], key=lambda one: one.share)], {}))
    turns = []

    def refits(context, extension, evidence, near, alike, failed):
        turns.append([one.name for one in near])
        return choice.Extension(None, best) if near[0] is best else None

    monkeypatch.setattr(choice, "refitted", refits)
    found = choice.choose(context, None, None, [first, best, other], frozenset())
    assert found.found is None and turns == [["best"], ["first"], ["other"]]
