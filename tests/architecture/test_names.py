"""Names: what plug-ins define, and that functions are named in code, not in texts."""

from __future__ import annotations

import ast
import re

from tests.architecture.source import PACKAGE, SOURCES, faults, tree_of

PLUG_INS = {
    "apps/*/commands": {"add_arguments", "run"},
    "workbench/commands": {"add_arguments", "run"},
    "diagnosis/report/sections": {"context"},
    "apps/*/sections": {"context"},
    "workbench/export": {"write"},
    "measurement/auditing/checks": {"check"},
    "measurement/reading/formats": {"read", "is_large", "pieces"},
    "symbolic/effects": {"derive"},
    "apps/paper/items": {"answer"},
    "apps/*/export": {"write", "notes"},
    "diagnosis/hypotheses/readings": {"entry", "what_is_wrong"},
    "diagnosis/hypotheses/recordings": {"claims", "said"},
}
"""What each file of a folder of plug-ins defines for whoever reads the folder."""


def test_every_plug_in_name_is_used():
    for folder, names in PLUG_INS.items():
        trees = [tree_of(path) for path in SOURCES if path.relative_to(PACKAGE).parent.match(folder)]
        defined = [n.name for tree in trees for n in tree.body if isinstance(n, ast.FunctionDef)]
        assert not defined or all(name in defined for name in names), folder


def test_no_function_is_named_in_a_text():
    """`"exoid.package.module:function"` is seen neither by a type checker nor by an editor that renames."""

    def named(path):
        texts = (node for node in ast.walk(tree_of(path)) if isinstance(node, ast.Constant))
        return [text.value for text in texts if re.fullmatch(r"exoid(\.\w+)+:\w+", str(text.value))]

    assert faults(SOURCES, named) == {}
