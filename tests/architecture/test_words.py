"""The field's words: what the house once said in a language of its own does not come back.

Read are texts that a person may see: all string literals but docstrings, and the pages of documentation; the first
lines of docstrings, and what values are called.
"""

from __future__ import annotations

import ast
import re

import pytest

from tests.architecture.source import ROOT, SOURCES, layer_of, tree_of

INSTEAD = {
    r"\blets? (it|them) be\b": "leaves unchanged",
    r"done it just as well": "indistinguishable",
    r"the lesser one is hardly": "the smaller candidate is unlikely",
    r"hangs from (swings|sways)": "the base oscillates",
    r"(?-i:\bsways\b)": "oscillates",
    r"\bgives? way\b": "compliance",
    r"identified numbers": "identified parameters",
    r"model's numbers": "model's parameters",
}
"""What is not said any more, and what is said in its place."""
INSTEAD_BELOW_THE_VERDICT = {r"\bdoubts?\b": "objection"}
"""The same where no verdict describes what a technician would see."""


WITHOUT_A_NOUN = re.compile(r"(Return )?(what|whether|how|where|which|who|why|when)\b", re.IGNORECASE)


def shown(path):
    docstrings = {id(node.value) for node in ast.walk(tree_of(path)) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
            yield node.value


def said(words, texts):
    return [text[:80] for text in texts if re.search(words, text, re.IGNORECASE)]


@pytest.mark.parametrize("words", INSTEAD)
def test_a_word_of_our_own_does_not_come_back(words):
    found = {str(path.relative_to(ROOT)): said(words, shown(path)) for path in SOURCES}
    found |= {p.name: said(words, p.read_text("utf-8").splitlines()) for p in (ROOT / "docs").glob("*.md")}
    assert {place: texts for place, texts in found.items() if texts} == {}, f"write: {INSTEAD[words]}"


@pytest.mark.parametrize("words", INSTEAD_BELOW_THE_VERDICT)
def test_nor_do_pictures_where_a_term_is_meant(words):
    meant = [p for p in SOURCES if layer_of(p) != "diagnosis"]
    found = {str(path.relative_to(ROOT)): said(words, shown(path)) for path in meant}
    found = {place: texts for place, texts in found.items() if texts}
    assert found == {}, f"write: {INSTEAD_BELOW_THE_VERDICT[words]}"


def test_docstrings_begin_with_a_noun():
    kinds = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    firsts = [ast.get_docstring(n) or "" for p in SOURCES for n in ast.walk(tree_of(p)) if isinstance(n, kinds)]
    found = [first.splitlines()[0] for first in firsts if WITHOUT_A_NOUN.match(first)]
    assert found == [], "write what it is or returns: 'Samples that ...', 'True if ...'"


def test_values_are_called_by_what_they_are():
    stored = [
        (str(path.relative_to(ROOT)), name.lineno)
        for path in SOURCES
        for name in ast.walk(tree_of(path))
        if isinstance(name, ast.Name) and name.id == "one" and isinstance(name.ctx, ast.Store)
    ]
    assert stored == [], "name it: recording, joint, term"
