"""Thresholds of the evidence lie where they are said to: on either side of each the answer is another one."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from synthetic import search, state_with

from exoid.diagnosis.evidence import look_alikes, placebo, ranking
from exoid.diagnosis.evidence.agreement import Agreement
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gain import Evidence, RecordingEvidence
from exoid.diagnosis.evidence.look_alikes import block_losses, gains_beside, refine
from exoid.diagnosis.evidence.placebo import as_good, searches
from exoid.diagnosis.evidence.score import Score, weigh
from exoid.diagnosis.rules import RULES
from exoid.symbolic.effect import Coefficient, Shape

RATE = 20.0


def block(residual, columns=None, use=None, motion=None) -> RecordingEvidence:
    """A recording of one joint at 20 Hz; without `columns` (K, P) the model has a wave of its own."""
    count = len(residual)
    own = np.sin(0.37 * np.arange(count))[:, None] if columns is None else columns
    path = np.random.default_rng(count).standard_normal((count, 1)) if motion is None else motion
    used = np.ones((1, count), bool) if use is None else use[None]
    units, starts = np.zeros(count, int), lambda seconds: np.arange(0, count, max(1, int(RATE * seconds)))
    return RecordingEvidence(own[None], residual[None], used, path, RATE, units, starts)


def noise(seed: int, count: int = 1000) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(count)


def orthonormal(one: np.ndarray, two: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both of length one, and `two` without what it has of `one`."""
    one = one / np.linalg.norm(one)
    two = two - one * (one @ two)
    return one, two / np.linalg.norm(two)


def candidate(**more) -> SimpleNamespace:
    """A candidate of one coefficient without bounds, at one node for every recording."""
    term = SimpleNamespace(effect=SimpleNamespace(coefficients={"c": Coefficient("N·m")}), placed_shape={})
    usual = {"change": False, "tangent": False, "term": term, "common": np.arange(1), "per_recording": []}
    usual |= {"nodes": np.zeros((1, 1, 0)), "name": "it", "numbers": 1, "joints": (0,)}
    return SimpleNamespace(**(usual | more))


def at(*columns: np.ndarray) -> list[Columns]:
    """One column per recording, at its only joint."""
    return [Columns((0,), one[None, None, :, None]) for one in columns]


def weighed(columns: np.ndarray, residual: np.ndarray, use: np.ndarray | None = None):
    """The score of a column, the same on two recordings."""
    runs = [block(residual, use=use), block(residual, use=use)]
    return weigh(Evidence(runs, [], seed=0, draws=0), candidate(nodes=np.zeros((2, 1, 0))), at(columns, columns))


CONTAINED = "already contain it"


@pytest.mark.parametrize(("new", "refused"), [(0.7e-6, True), (1.4e-6, False)])
def test_what_the_model_contains_is_no_candidate(new, refused):
    own, other = orthonormal(np.sin(0.37 * np.arange(1000)), noise(1))
    score = weighed(own + np.sqrt(new) * other, noise(2))
    assert (CONTAINED in score.caution) is refused


@pytest.mark.shows("negligible")
@pytest.mark.parametrize(("samples", "refused"), [(2, True), (4, False)])
def test_what_acts_on_a_few_samples_is_no_candidate(samples, refused):
    column = np.where(np.arange(1500) < samples, 1.0, 0.0)
    assert (CONTAINED in weighed(column, noise(2, 1500)).caution) is refused


@pytest.mark.shows("least_share")
@pytest.mark.parametrize(("share", "refused"), [(0.007, True), (0.014, False)])
def test_a_peak_where_nothing_is_fitted_is_not_credited_with_its_edge(share, refused):
    inside = np.arange(1000) < 100
    column = np.where(inside, 3.0 * np.sqrt(1.0 - share), np.sqrt(share)) * np.sign(noise(3))
    assert (CONTAINED in weighed(column, noise(2), use=~inside).caution) is refused


@pytest.mark.shows("least_share")
@pytest.mark.parametrize(("share", "helps"), [(0.007, False), (0.014, True)])
def test_a_candidate_helps_from_a_hundredth_of_the_unseen_error(share, helps):
    column, rest = noise(4), np.sign(noise(5))
    rest -= column * (rest @ column) / (column @ column)
    score = weighed(column, np.sqrt(1.0 - share) * rest + np.sqrt(share) * column)
    assert score.helps is helps


@pytest.mark.shows("most_folds")
@pytest.mark.parametrize(("recordings", "splits"), [(8, 8), (9, 8)])
def test_each_of_few_recordings_is_held_out_alone(recordings, splits):
    assert Evidence([block(noise(k, 60)) for k in range(recordings)], [], seed=0, draws=0).folds == splits


@pytest.mark.shows("blocks")
def test_of_a_recording_that_is_alone_each_quarter_is_held_out():
    context = search({}, ["torque_offset:knee"], scales=(1.0,), verify=0)
    (only,) = context.evidence(state_with(context).last, draws=0).blocks
    assert np.unique(only.fold, return_counts=True)[1].tolist() == [len(only.fold) // 4] * 4


@pytest.mark.shows("robust")
def test_a_split_that_shows_nothing_of_a_shape_value_leaves_it_near_where_it_is():
    """A fit to nothing knows a shape value as well as its prior does."""
    context = search({"stribeck:hip": ([1.5], [0.15])}, ["stribeck:hip"])
    fitted: FittedModel = state_with(context, "stribeck:hip").last.fitted
    evidence = context.evidence(state_with(context, "stribeck:hip").last, draws=0)
    known = evidence.fits(np.zeros((1, evidence.count))).inverse[0, -1, -1]
    assert np.sqrt(known) == pytest.approx(2.0 * fitted.slack[-1])


def test_a_column_that_is_hardly_seen_does_not_escape_the_ridge():
    """Of two columns as large as each other one is a hundredth of that where it is fitted: it is held back tenfold."""
    both = np.column_stack([noise(6), 0.01 * noise(7)])
    both[:, 0] /= np.linalg.norm(both[:, 0])
    both[:, 1] *= 0.01 / np.linalg.norm(both[:, 1])
    evidence = Evidence([block(both @ [1.0, 1.0])] * 2, [], seed=0, draws=0, sigma=np.ones(1))
    grams = evidence.plain([Columns((0,), both[None, None])] * 2)
    large, small = evidence.fitted(grams, 0.03)[0]
    held = 1e-4 / (1e-4 + 0.03 * 0.3**2)  # with the ridge in units of 0.3 of the largest
    assert large == pytest.approx(1.0 / 1.03, rel=0.05)
    assert small == pytest.approx(held, rel=0.3)


# -- placebos -------------------------------------------------------------------------------------------------


@pytest.mark.shows("min_shift")
def test_no_placebo_is_nearly_the_candidate():
    (shifts,) = Evidence([block(noise(8))], [], seed=0, draws=999).shifts
    nearest = np.minimum(shifts, 1000 - shifts).min() / RATE
    assert 1.0 <= nearest < 1.3


@pytest.mark.shows("half")
@pytest.mark.parametrize(("alike", "used"), [(0.35, True), (0.65, False)])
def test_a_motion_is_not_shifted_by_its_own_period(alike, used):
    """Every 100 samples the motion comes again, but for a part of it."""
    path = np.sqrt(alike) * np.tile(noise(9, 100), 10) + np.sqrt(1.0 - alike) * noise(10)
    (shifts,) = Evidence([block(noise(8), motion=path[:, None])], [], seed=0, draws=9999).shifts
    assert bool((shifts == 300).any()) is used


@pytest.mark.shows("telegraph")
def test_the_placebo_of_a_constant_changes_its_sign_every_three_seconds():
    asked: list[np.ndarray] = []

    def shifted(columns, node, trained, by):
        asked.append(columns[0].values[0, 0, :, 0])

    count = 60 * round(RATE)
    evidence = SimpleNamespace(
        rules=RULES, blocks=[block(np.zeros(count))], fold_losses=np.ones(1), draws=1, shifted=shifted,
        shifts=[np.zeros(1, int)], exceed=lambda grams, least, allowed: np.ones(1, bool),
    )  # fmt: skip
    part = placebo.PlaceboSearch(np.array([0]), False)
    as_good(evidence, SimpleNamespace(candidate=candidate(), share=0.5), at(np.ones(count)), part)
    changes = np.flatnonzero(np.diff(asked[0])) + 1
    assert np.gcd.reduce(changes) == 3 * RATE


@pytest.mark.shows("placebo_nodes")
@pytest.mark.parametrize(("nodes", "tried"), [(90, 90), (150, 75)])
def test_a_placebo_tries_a_hundred_nodes_at_most(nodes, tried):
    score = SimpleNamespace(candidate=candidate(common=np.arange(nodes)), nodes=np.zeros(1, int))
    parts = searches(SimpleNamespace(rules=RULES), score)
    assert sum(part.nodes.size for part in parts) == tried


@pytest.mark.shows("placebo_for")
def test_the_best_dozen_gets_placebos(monkeypatch):
    several = [candidate(name=str(k), width=1) for k in range(20)]
    library = SimpleNamespace(candidates=several, columns=lambda *asked: [])

    def weighs(evidence, one, columns):
        return Score(one, np.zeros(1, int), 0.9 - 0.01 * int(one.name), np.zeros(1), None, np.zeros(1), 1.0, True)

    monkeypatch.setattr(ranking, "weigh", weighs)
    monkeypatch.setattr(ranking, "agreed", lambda evidence, scores, *asked: scores)
    part = placebo.PlaceboSearch(np.array([0]), False)
    monkeypatch.setattr(ranking, "searches", lambda evidence, score: [part])
    monkeypatch.setattr(ranking, "as_good", lambda *asked: np.zeros(99, bool))
    numbers = {"linear": np.zeros(2), "shapes": np.zeros((1, 0))}
    fitted = SimpleNamespace(model=SimpleNamespace(terms=[]), prepared=None, **numbers)
    scores = ranking.rank(SimpleNamespace(rules=RULES, draws=99), library, fitted)
    assert [score.name for score in scores if score.p_value is not None] == [str(k) for k in range(12)]


# -- look-alikes ----------------------------------------------------------------------------------------------


@pytest.mark.shows("block_seconds")
def test_losses_are_compared_in_blocks_of_two_seconds():
    evidence = Evidence([block(noise(k)) for k in range(2)], [], seed=0, draws=0)
    columns = at(noise(3), noise(4))
    assert block_losses(evidence, evidence.plain(columns), columns).size == 2 * 1000 / RATE / 2.0


@pytest.mark.shows("clear", "practically")
@pytest.mark.parametrize(
    ("lag", "share", "numbers", "alike"),
    [(2.0, 0.5, 2, True), (3.0, 0.5, 2, False), (6.0, 0.985, 1, True), (6.0, 0.97, 1, False), (6.0, 0.985, 2, False)],
)
def test_a_rival_that_lags_clearly_is_no_look_alike_unless_it_is_simpler_and_as_good(
    lag, share, numbers, alike, monkeypatch
):
    """Losses in 16 blocks that differ from the best one's by `lag` standard errors."""
    best = SimpleNamespace(name="best", share=1.0, candidate=candidate(numbers=2))
    rival = SimpleNamespace(name="rival", share=share, candidate=candidate(numbers=numbers))
    losses = {"best": np.full(16, 9.0), "rival": 9.0 + lag / 4.0 + np.tile([1.0, -1.0], 8)}
    monkeypatch.setattr(look_alikes, "gains_beside", lambda *asked: False)
    monkeypatch.setattr(look_alikes, "joint_losses", lambda evidence, grams, columns: losses[columns][None])
    evidence = SimpleNamespace(rules=RULES, plain=lambda columns: None)
    assert ("rival" in look_alikes.look_alikes(evidence, (best, "best"), [(rival, "rival")])) is alike


@pytest.mark.shows("half")
@pytest.mark.parametrize(("kept", "other"), [(0.4, False), (0.6, True)])
def test_what_keeps_half_of_its_gain_beside_the_best_is_another_effect(kept, other):
    """Alone a rival gains 0.9 times as much as the best, beside it `kept` of that."""
    first, new = orthonormal(noise(11), noise(12))
    left = np.sqrt(0.9 * kept)
    angle = np.arctan(left) + np.arccos(np.sqrt(0.9 / (1.0 + left**2)))
    evidence = Evidence([block(first + left * new)] * 2, [], seed=0, draws=0, sigma=np.full(1, 1e3))
    columns = [at(one, one) for one in (first, np.cos(angle) * first + np.sin(angle) * new)]
    best, rival = (weigh(evidence, candidate(nodes=np.zeros((2, 1, 0))), one) for one in columns)
    assert rival.share == pytest.approx(0.9 * best.share, rel=0.05)
    assert gains_beside(evidence, (best, columns[0]), rival, columns[1]) is other


@pytest.mark.shows("refinements")
def test_a_shape_value_is_found_to_an_eighth_of_the_step_of_the_grid(monkeypatch):
    """The gain is highest five eighths of a step beside a node of a grid of five."""
    shape = Shape("", 0.0, 8.0, points=5)
    one = candidate(nodes=np.array([[[2.0]]]))
    one.term.placed_shape["w"] = shape
    tried: list[float] = []

    def score_at(evidence, candidate, chosen, columns, before):
        tried.append(float(chosen[0, 0]))
        return SimpleNamespace(share=-abs(tried[-1] - 3.25), chosen=tried[-1])

    monkeypatch.setattr(look_alikes, "columns_at", lambda *asked: None)
    monkeypatch.setattr(look_alikes, "_one_node", score_at)
    start = SimpleNamespace(candidate=one, shape=np.array([[2.0]]))
    best, _ = refine(SimpleNamespace(rules=RULES), start, None)
    assert best.chosen == pytest.approx(3.25)
    assert len(tried) == 1 + 2 * 3


def sought(monkeypatch, one, start: list[list[float]], gain):
    """Refine the shape values `start` (R, S) of the candidate `one`, where `gain` says what values (R, S) gain."""

    def score_at(evidence, candidate, chosen, columns, before):
        return SimpleNamespace(share=gain(chosen), chosen=chosen)

    monkeypatch.setattr(look_alikes, "columns_at", lambda *asked: None)
    monkeypatch.setattr(look_alikes, "_one_node", score_at)
    begun = SimpleNamespace(candidate=one, shape=np.array(start))
    return refine(SimpleNamespace(rules=RULES), begun, None)[0].chosen


def test_the_places_of_all_recordings_are_refined_together(monkeypatch):
    one = candidate()
    one.term.placed_shape["s"] = Shape("rad", 0.0, 8.0, spacing="position", points=5, per_recording=True)
    found = sought(monkeypatch, one, [[2.0], [2.5]], lambda at: -abs(at[0, 0] - 3.25))
    assert found == pytest.approx(np.array([[3.25], [3.75]]))
    one.term.placed_shape["s"] = Shape("s", 0.0, 8.0, points=5, per_recording=True)
    assert np.array_equal(sought(monkeypatch, one, [[2.0], [2.5]], lambda at: -abs(at[0, 0] - 3.25)), [[2.0], [2.5]])


def test_the_other_choice_is_refined_as_well(monkeypatch):
    """At the node the first law gains more, between the nodes the second one."""
    one = candidate()
    one.term.placed_shape |= {"w": Shape("", 0.0, 8.0, points=5), "law": Shape("", 0.0, 1.0, choices=(0.0, 1.0))}
    found = sought(monkeypatch, one, [[2.0, 0.0]], lambda at: (3.0 if at[0, 1] else 2.0) - abs(at[0, 0] - 4.0))
    assert found == pytest.approx(np.array([[3.75, 1.0]]))


def test_what_hardly_convinces_at_a_node_is_asked_at_its_best_place(monkeypatch):
    """Three of four splits agree at the node, all four at the refined place; what has no place is asked once."""
    one = candidate(nodes=np.zeros((2, 1, 1)))
    score = Score(one, np.zeros(2, int), 0.5, np.zeros(1), None, np.zeros(1), 1.0, True)
    told = {"node": Agreement(3, 4), "between": Agreement(4, 4)}
    asked = SimpleNamespace(candidate=lambda score, columns: told[columns if columns == "between" else "node"])
    monkeypatch.setattr(ranking, "Splits", lambda evidence: asked)
    monkeypatch.setattr(ranking, "refine", lambda evidence, score, fitted: (score, "between"))
    place = Shape("rad", -2.0, 2.0, spacing="position", per_recording=True)
    for shape, steady in ((Shape("rad", -2.0, 2.0), False), (place, True)):
        one.term.placed_shape["s"] = shape
        wave = at(noise(1), noise(2))
        found = ranking.agreed(SimpleNamespace(rules=RULES), [score], {"it": wave}, SimpleNamespace())
        assert found[0].steady is steady
