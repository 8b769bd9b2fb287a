"""Thresholds are numbers that say what they prevent; the table has each once, and a test shows each of them."""

import runpy
import sys
from pathlib import Path

from exoid.diagnosis.thresholds import every_threshold
from exoid.ground.thresholds import home_of

ROOT = Path(__file__).resolve().parents[2]


def test_the_table_has_every_threshold_once_and_says_what_it_prevents():
    rules = list(every_threshold())
    assert len({rule.name for rule in rules}) == len(rules)
    assert all(len(rule.prevents) > 10 for rule in rules)
    declared = [rule for rule in rules if "." in rule.name]
    for module, name in map(home_of, declared):
        assert isinstance(getattr(sys.modules[module], name), float | int), name
    assert [getattr(sys.modules[module], name) for module, name in map(home_of, declared)] == [
        rule.value for rule in declared
    ]


def test_a_test_shows_what_each_threshold_prevents():
    shown = runpy.run_path(str(ROOT / "benchmarks" / "make_rules_table.py"))["shown"]()
    assert set(shown) == {rule.name for rule in every_threshold()}, "mark a test with pytest.mark.shows"
