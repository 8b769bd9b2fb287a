"""One word for how sure it is, from placebos, splits and look-alikes."""

from __future__ import annotations

from exoid.diagnosis.evidence.agreement import Agreement
from exoid.diagnosis.rules import RULES
from exoid.diagnosis.sureness import AGREEING, FAIRLY, MEANINGS, RARE, UNSURE, VERY, least_sure, meanings_of, sureness

ALL, MOST, HALF = Agreement(4, 4), Agreement(17, 20), Agreement(2, 4)


def test_very_sure_needs_rare_placebos_and_agreeing_splits():
    assert sureness(RARE, ALL) == VERY
    assert sureness(2 * RARE, ALL) == FAIRLY  # one in a few hundred by chance alone
    assert RULES.most <= 17 / 20 < AGREEING and sureness(RARE, MOST) == FAIRLY
    # What shows in one recording of four is told of by a split alone, with which nobody disagrees.
    assert sureness(RARE, Agreement(2, 2, splits=4)) == VERY and sureness(RARE, Agreement(1, 1, splits=4)) == FAIRLY


def test_what_chance_or_another_does_as_well_cannot_be_told():
    assert sureness(2 * RULES.level, ALL) == UNSURE
    assert sureness(None, ALL) == UNSURE
    assert sureness(RARE, HALF) == UNSURE
    assert sureness(RARE, ALL, doubted=True) == UNSURE


def test_one_recording_makes_nobody_very_sure():
    assert sureness(RARE) == FAIRLY and sureness(RARE, Agreement()) == FAIRLY


def test_an_answer_is_as_sure_as_its_weakest_part_and_each_word_is_explained():
    assert least_sure([VERY, FAIRLY]) == FAIRLY and least_sure([UNSURE, VERY]) == UNSURE and least_sure([]) == ""
    assert [text.partition(":")[0] for text in meanings_of([UNSURE, "", VERY, VERY])] == [VERY, UNSURE]
    assert list(MEANINGS) == [VERY, FAIRLY, UNSURE]
