"""Thresholds are numbers that say what they prevent; the table has each once."""

import sys

from exoid.diagnosis.thresholds import every_threshold
from exoid.ground.thresholds import home_of


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
