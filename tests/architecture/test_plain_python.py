"""What a newcomer need not learn: no trick where Python has a plain way."""

from __future__ import annotations

import ast

import pytest

from tests.architecture.source import PACKAGE, ROOT, SOURCES, faults, tree_of

TRICKS = {"_getframe", "get_source", "fork", "memfd_create", "finalize", "__signature__", "__class__"}
"""Frames and sources that are looked at, processes forked by hand, objects that become others."""


def test_the_package_is_a_plain_folder():
    assert [path for path in PACKAGE.rglob("*") if path.is_symlink()] == []
    assert not (ROOT / "setup.py").exists()


def test_no_module_uses_a_trick():
    def tricks(path):
        nodes = [node for node in ast.walk(tree_of(path)) if isinstance(node, (ast.Attribute, ast.Assign))]
        used = {n.attr for n in nodes if isinstance(n, ast.Attribute) and n.attr in TRICKS - {"__class__"}}
        targets = [t for n in nodes if isinstance(n, ast.Assign) for t in n.targets]
        return sorted(used | {t.attr for t in targets if isinstance(t, ast.Attribute) and t.attr in TRICKS})

    assert faults(SOURCES, tricks) == {}


def test_no_package_says_where_its_modules_lie():
    def moved(path):
        stores = (n for n in ast.walk(tree_of(path)) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store))
        return [name.id for name in stores if name.id == "__path__"]

    assert faults(SOURCES, moved) == {}


@pytest.mark.parametrize("link", ["symbolic", "optimisation"])
def test_the_two_links_at_the_top_lead_into_the_package(link):
    at = ROOT / link
    if at.is_symlink():  # an archive without links works as well
        assert at.resolve() == PACKAGE / link
