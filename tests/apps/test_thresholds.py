"""Thresholds are numbers that say what they prevent; the table has each once, and a test shows each of them."""

import json
import pickle
import runpy
from pathlib import Path

from exoid.diagnosis.thresholds import every_threshold
from exoid.ground.thresholds import Threshold

ROOT = Path(__file__).resolve().parents[2]


def test_a_threshold_is_a_number_wherever_it_goes():
    limit = Threshold(2.5, "nothing, in a test")
    assert limit > 2 and f"{limit:g} {limit!r}" == "2.5 2.5" and json.dumps(limit) == "2.5"
    copy = pickle.loads(pickle.dumps(limit))  # noqa: S301 - findings carry their limits to other processes
    assert copy == limit and copy.prevents == limit.prevents and limit.module == __name__


def test_the_table_has_every_threshold_once_and_says_what_it_prevents():
    rules = list(every_threshold())
    assert len({rule.name for rule in rules}) == len(rules)
    assert all(len(rule.prevents) > 10 for rule in rules)
    names = {rule.name for rule in rules}
    assert names >= {"gaps.LONG", "least_share", "cutoff.BIAS_LIMIT", "where.SLOW", "alarm.LEAST_POWER"}


def test_a_test_shows_what_each_threshold_prevents():
    shown = runpy.run_path(str(ROOT / "benchmarks" / "make_rules_table.py"))["shown"]()
    assert set(shown) == {rule.name for rule in every_threshold()}, "mark a test with pytest.mark.shows"
