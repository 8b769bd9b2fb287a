"""The shape of the code: imports point down, the command line stays light, everything public is documented."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
LAYERS = ("ground", "symbolic", "measurement", "optimisation", "diagnosis", "workbench", "exoid")
"""Lowest first; a package may import itself and what stands before it."""

HEAVY = ("sympy", "casadi", "scipy", "matplotlib", "pandas", "rich", "jinja2", "h5py", "numpy")
CHEAP = ("symbolic/effect.py", "symbolic/catalogue.py", "ground/errors.py", "symbolic/quantity.py",
         "symbolic/language/parser.py", "symbolic/effects/*.py")  # fmt: skip
"""What the catalogue and `exoid --help` import besides workbench/."""

SOURCES = sorted(path for layer in LAYERS for path in (ROOT / layer).rglob("*.py"))
CHEAP_SOURCES = sorted((ROOT / "workbench").rglob("*.py")) + [p for pattern in CHEAP for p in ROOT.glob(pattern)]
FORBIDDEN_CALLS = ("eval", "exec", "compile", "sympify", "parse_expr", "__import__")
FORBIDDEN_MODULES = ("pickle", "dill", "cloudpickle", "shelve", "marshal")


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text("utf-8"), filename=str(path))


def imported(node: ast.AST) -> list[str]:
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom) and node.level == 0:
        return [node.module or ""]
    return []


def top_level(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """Statements that run when the module is imported, those for type checkers left out."""
    for node in body:
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            yield from top_level(node.orelse)
        elif isinstance(node, (ast.If, ast.Try, ast.With)):
            yield from top_level([n for n in ast.walk(node) if isinstance(n, (ast.Import, ast.ImportFrom))])
        else:
            yield node


def test_there_is_something_to_look_at():
    assert len(SOURCES) > 50


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_imports_point_down(path):
    layer = LAYERS.index(path.relative_to(ROOT).parts[0])
    above = LAYERS[layer + 1 :]
    found = [module for node in ast.walk(tree_of(path)) for module in imported(node)]
    assert [module for module in found if module.split(".")[0] in above] == []


@pytest.mark.parametrize("path", CHEAP_SOURCES, ids=name_of)
def test_nothing_heavy_is_imported_at_the_top(path):
    found = [module for node in top_level(tree_of(path).body) for module in imported(node)]
    assert [module for module in found if module.split(".")[0] in HEAVY] == []


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_user_text_is_never_executed(path):
    for node in ast.walk(tree_of(path)):
        if isinstance(node, ast.Call):
            called = node.func
            name = called.id if isinstance(called, ast.Name) else None
            assert name not in FORBIDDEN_CALLS, f"line {node.lineno}: {name}"
        assert not {m.split(".")[0] for m in imported(node)} & set(FORBIDDEN_MODULES)


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_everything_public_is_documented_and_annotated(path):
    tree = tree_of(path)
    assert ast.get_docstring(tree), "the module has no docstring"
    for node in public(tree.body):
        assert is_protocol_member(node) or ast.get_docstring(node), f"line {node.lineno}: {node.name} has no docstring"
        if isinstance(node, ast.FunctionDef):
            assert node.returns is not None, f"line {node.lineno}: {node.name} does not say what it returns"


def public(body: list[ast.stmt]) -> Iterator[ast.FunctionDef | ast.ClassDef]:
    for node in body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not node.name.startswith("_"):
            yield node
            if isinstance(node, ast.ClassDef):
                yield from public(node.body)


def is_protocol_member(node: ast.FunctionDef | ast.ClassDef) -> bool:
    """`def name(self) -> str: ...` declares; its Protocol has the words."""
    last = node.body[-1]
    return (
        isinstance(node, ast.FunctionDef)
        and isinstance(last, ast.Expr)
        and isinstance(last.value, ast.Constant)
        and last.value.value is ...
    )


@pytest.mark.parametrize("path", [p for p in SOURCES if p.relative_to(ROOT).parts[0] != "workbench"], ids=name_of)
def test_nothing_below_the_workbench_prints(path):
    calls = [n.func for n in ast.walk(tree_of(path)) if isinstance(n, ast.Call)]
    assert [c.lineno for c in calls if isinstance(c, ast.Name) and c.id == "print"] == []


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_no_default_argument_can_be_changed(path):
    for node in ast.walk(tree_of(path)):
        if isinstance(node, (ast.FunctionDef, ast.Lambda)):
            defaults = [*node.args.defaults, *(d for d in node.args.kw_defaults if d is not None)]
            assert not [d for d in defaults if isinstance(d, (ast.List, ast.Dict, ast.Set))]
