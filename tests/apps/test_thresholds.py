"""Thresholds are numbers that say what they prevent; the table has each once."""

import sys

from exoid.diagnosis.thresholds import every_threshold


def test_the_table_has_every_threshold_once_and_says_what_it_prevents():
    rules = list(every_threshold())
    assert len({rule.name for rule in rules}) == len(rules)
    assert all(len(rule.prevents) > 10 for rule in rules)
    declared = [rule for rule in rules if rule.module]
    assert declared
    for rule in declared:
        assert rule.module.endswith(rule.name.rpartition(".")[0])
        assert getattr(sys.modules[rule.module], rule.name.rpartition(".")[2]) == rule.value


def test_every_number_that_is_declared_to_decide_is_in_the_table():
    known = {(rule.module, rule.name.rpartition(".")[2]) for rule in every_threshold()}
    for path, module in list(sys.modules.items()):
        if path.startswith("exoid."):
            notes = getattr(module, "__annotations__", {})
            assert all((path, name) in known for name, kind in notes.items() if kind == "Threshold"), path
