"""Thresholds of what is left, and of channels, lie where they are said to: on either side the answer is another one."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from synthetic import search, state_with
from test_rules_of_evidence import block, candidate, noise

from exoid.diagnosis.evidence import proxies, remainder, soft_drive
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.curves import splines_along
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.proxies import BetterCurve, beaten
from exoid.diagnosis.evidence.remainder import CurveData, Remainder, remainders, significant
from exoid.diagnosis.rules import RULES

CURVE, TERM, BOTH, BUMP = "curve", "term", "curve and term", "bump"


@pytest.fixture(scope="module")
def bare():
    """Recordings of which the model knows everything, and the evidence against it."""
    context = search({}, ["torque_offset:knee"])
    last = state_with(context).last
    return last.fitted, context.evidence(last, draws=0)


@pytest.mark.shows("knots")
def test_a_curve_has_a_dozen_functions(bare):
    splines = splines_along(bare[0], "q1", 0, "", bare[1].rules.knots)
    assert splines.basis.shape[1] == splines.columns[0].values.shape[3] == 12


@pytest.mark.shows("curve_ridge")
def test_a_part_of_a_curve_that_the_model_nearly_contains_is_held_back():
    """Of a column three hundredths are new to the model: of its coefficient half is left."""
    own, new = np.sin(0.37 * np.arange(1000)), noise(1)
    own /= np.linalg.norm(own)
    new -= own * (own @ new)
    column = np.sqrt(0.97) * own + np.sqrt(0.03) * new / np.linalg.norm(new)
    evidence = Evidence([block(column)] * 2, [], seed=0, draws=0, sigma=np.full(1, 1e3))
    part = CurveData(evidence, (0, 1))
    gain = part.gain([Columns((0,), column[None, None, :, None])] * 2)
    assert gain.coefficients[0, 0] == pytest.approx(0.5, abs=0.05)


@pytest.mark.shows("artefact", "least_share", "strict_level")
@pytest.mark.parametrize(
    ("share", "p_value", "said"), [(0.025, 0.007, True), (0.015, 0.007, False), (0.025, 0.014, False)]
)
def test_a_curve_is_reported_that_explains_enough_and_is_not_chance(share, p_value, said):
    nothing = np.zeros(0)
    one = Remainder("knee", "q2", "", share, share, p_value, nothing, nothing, nothing)
    assert significant(one) is said


@pytest.mark.shows("most")
@pytest.mark.parametrize(("own", "first"), [(0.55, False), (0.65, True)])
def test_a_curve_of_its_own_for_each_recording_earns_that_freedom(own, first, bare, monkeypatch):
    """Half of what is left follows a common curve, a little more one of each recording's own."""

    def weighs(parts, splines, index, of_its_own):
        share = own if of_its_own else 0.5
        return {key: [0.0] for key in ("x", "y", "band")} | {"own": of_its_own, "share": share, "unseen": share}

    monkeypatch.setattr(remainder, "_weigh", weighs)
    assert remainders(*bare, ["knee"], placebos=0)[0].own is first


def contest(monkeypatch, shares, lead=0.0, numbers=1):
    """Who wins at a joint where columns explain these `shares`, the curve's losses in 16 blocks `lead` deviations
    below those of the term.
    """
    losses = {TERM: np.full(16, 9.0), CURVE: 9.0 - lead / 4.0 + np.tile([1.0, -1.0], 8)}
    moving = SimpleNamespace(values=np.arange(8.0)[None, None, :, None])
    named = {id(moving): TERM}

    def name(columns):
        return columns[0] if isinstance(columns[0], str) else named[id(columns[0])]

    monkeypatch.setattr(proxies, "curve_data_per_recording", lambda now, evidence: [])
    monkeypatch.setattr(proxies, "tried_curves", lambda joints: (("dq1", ""),) if CURVE in shares else ())
    monkeypatch.setattr(proxies, "splines_along", lambda *asked: SimpleNamespace(columns=(CURVE,)))
    monkeypatch.setattr(proxies, "_share", lambda parts, columns, ridge=None: shares[name(columns)])
    monkeypatch.setattr(proxies, "_blocks", lambda parts, columns, ridge=None: losses[name(columns)])
    monkeypatch.setattr(proxies, "stacked", lambda parts, joints: [BOTH])
    bump = candidate(numbers=1)
    monkeypatch.setattr(proxies, "_bumps", lambda now, joint: [bump] if BUMP in shares else [])
    monkeypatch.setattr(proxies, "candidate_columns", lambda *asked: SimpleNamespace(node=lambda n: BUMP))
    found = SimpleNamespace(share=shares.get(BUMP), nodes=np.zeros(1, int))
    monkeypatch.setattr(proxies, "weigh", lambda *asked: found)
    now = SimpleNamespace(
        model=SimpleNamespace(joint_names=("hip",), joints=()), prepared=SimpleNamespace(all=[None])
    )  # fmt: skip
    return beaten(now, SimpleNamespace(rules=RULES, blocks=[None], sigma=[1.0]), "hip", [moving], numbers)


@pytest.mark.shows("clear", "most", "half")
@pytest.mark.parametrize(
    ("share", "lead", "beside", "wins"),
    [
        (0.66, 3.0, 0.1, True),
        (0.6, 3.0, 0.1, False),
        (0.66, 2.0, 0.1, False),
        (0.66, 3.0, 0.2, True),
        (0.66, 3.0, 0.3, False),
    ],
)
def test_a_curve_unmasks_a_term_that_it_beats_and_that_adds_little_to_it(share, lead, beside, wins, monkeypatch):
    """The term explains half, `beside` the curve a part of the loss."""
    shares = {TERM: 0.5, CURVE: share, BOTH: share + beside}
    assert (contest(monkeypatch, shares, lead) is not None) is wins


@pytest.mark.shows("most")
@pytest.mark.parametrize(
    ("share", "numbers", "wins"), [(0.66, 2, True), (0.6, 2, False), (0.66, 1, False), (0.3, 2, False)]
)
def test_a_bump_of_fewer_numbers_unmasks_a_term_that_explains_less_than_most_of_it(share, numbers, wins, monkeypatch):
    shares = {TERM: 0.5, BUMP: share, BOTH: share + 0.1}
    assert (contest(monkeypatch, shares, numbers=numbers) is not None) is wins


@pytest.mark.shows("most")
@pytest.mark.parametrize(("share", "gone"), [(0.3, True), (0.45, False)])
def test_a_curve_takes_the_place_of_a_constant_only_where_it_gains_clearly_more(share, gone, monkeypatch):
    monkeypatch.setattr(proxies, "_share", lambda parts, columns, ridge=None: share)
    judge = SimpleNamespace(evidence=SimpleNamespace(rules=RULES))
    constant = SimpleNamespace(values=np.ones((1, 1, 8, 1)))
    assert BetterCurve((), (judge,), None, 0.5).supersedes([constant]) is gone


# -- channels -------------------------------------------------------------------------------------------------


@pytest.mark.shows("most")
@pytest.mark.parametrize(("left", "others", "found"), [(0.75, True, True), (0.85, True, False), (0.75, False, False)])
def test_a_soft_drive_among_several_effects_need_not_explain_more_than_all(left, others, found, monkeypatch):
    """One soft drive alone leaves this part of what all accepted effects leave; it is one of them, or the only one."""
    names = [f"{soft_drive.ENTRY}:hip", *(["stribeck:hip"] if others else [])]
    none = SimpleNamespace(terms=[], joints=[None])
    base = SimpleNamespace(model=none, prepared=None, evaluation_rms=np.full(1, 9.0))
    last = SimpleNamespace(
        model=SimpleNamespace(terms=[SimpleNamespace(name=n) for n in names], joints=[None]),
        evaluation_rms=np.ones(1), train_rms=np.ones(1),
    )  # fmt: skip
    rest = np.full(1, np.sqrt(left))
    best = soft_drive.SoftDrive("hip", 0.01, "rad/(N·m)", "N·m/rad", 3.0, np.ones(1), rest, np.ones(1, bool), rest)
    monkeypatch.setattr(soft_drive, "swinging", lambda fitted: None)
    monkeypatch.setattr(soft_drive, "little_motion", lambda prepared, rules: "")
    monkeypatch.setattr(soft_drive, "_best", lambda fitted, joint: best if fitted is base else None)
    assert (soft_drive.soft_drive(base, last, np.full(1, 0.1)) is not None) is found
