"""The shape of the code: imports point down, the command line stays light, everything public is documented."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from tests.architecture.source import (
    LAYERS,
    PACKAGE,
    SOURCES,
    faults,
    imported,
    layer_named,
    layer_of,
    module_of,
    telling_nodes,
    tree_of,
)

HEAVY = ("sympy", "casadi", "scipy", "matplotlib", "pandas", "rich", "jinja2", "h5py", "numpy")
CHEAP = ("symbolic/effect.py", "symbolic/effect_catalogue.py", "ground/errors.py", "symbolic/quantity.py",
         "symbolic/language/parser.py", "symbolic/effects/*.py")  # fmt: skip
"""What the catalogue and `exoid --help` import besides workbench/."""

CHEAP_SOURCES = sorted((PACKAGE / "workbench").rglob("*.py")) + [p for pattern in CHEAP for p in PACKAGE.glob(pattern)]
FORBIDDEN_CALLS = ("eval", "exec", "compile", "sympify", "parse_expr", "__import__")
FORBIDDEN_MODULES = ("pickle", "dill", "cloudpickle", "shelve", "marshal")
MOST_PARAMETERS = 9
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


def top_level(body: list[ast.stmt]) -> Iterator[ast.stmt]:
    """Statements that run when the module is imported, those for type checkers left out."""
    for node in body:
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            yield from top_level(node.orelse)
        elif isinstance(node, (ast.If, ast.Try, ast.With)):
            yield from top_level([n for n in ast.walk(node) if isinstance(n, (ast.Import, ast.ImportFrom))])
        else:
            yield node


def modules_of(nodes) -> list[str]:
    return [module for node in nodes for module in imported(node)]


def test_there_is_something_to_look_at():
    assert len(SOURCES) > 50
    assert {layer_of(path) for path in SOURCES} >= {*LAYERS} - {"apps"}


def test_imports_point_down():
    def upwards(path):
        above = LAYERS[LAYERS.index(layer_of(path)) + 1 :]
        return [module for module in modules_of(telling_nodes(path)) if layer_named(module) in above]

    assert faults(SOURCES, upwards) == {}


def app_of(module: str) -> str:
    """Name of the app that a module belongs to, "" for the core."""
    words = module.split(".")
    return words[2] if words[:2] == ["exoid", "apps"] and len(words) > 2 else ""


def test_no_app_imports_another_one():
    def others(path):
        mine = app_of(module_of(path))
        return [m for m in modules_of(telling_nodes(path)) if app_of(m) not in ("", mine)]

    assert faults([*SOURCES, *PACKAGE.rglob("__init__.pyi")], others).keys() <= {"__init__.pyi"}


def test_reading_asks_what_the_samples_say_in_one_place():
    """From file to recording it runs one way; what the audit knows is asked by `read.py`, after it."""
    folder = PACKAGE / "measurement/reading"

    def asked(path):
        return [m for m in modules_of(telling_nodes(path)) if m.startswith("exoid.measurement.auditing")]

    assert faults((p for p in SOURCES if folder in p.parents and p.name != "read.py"), asked) == {}


def test_nothing_heavy_is_imported_at_the_top():
    def heavy(path):
        return [m for m in modules_of(top_level(tree_of(path).body)) if m.split(".")[0] in HEAVY]

    assert faults(CHEAP_SOURCES, heavy) == {}


def test_user_text_is_never_executed():
    def executed(path):
        for node in telling_nodes(path):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in FORBIDDEN_CALLS:
                yield f"line {node.lineno}: {node.func.id}"
            yield from (m for m in imported(node) if m.split(".")[0] in FORBIDDEN_MODULES)

    assert faults(SOURCES, executed) == {}


def test_everything_public_is_documented_and_annotated():
    def bare(path):
        if not ast.get_docstring(tree_of(path)):
            yield "the module has no docstring"
        for node in public(tree_of(path).body):
            if not is_protocol_member(node) and not ast.get_docstring(node):
                yield f"line {node.lineno}: {node.name} has no docstring"
            if isinstance(node, FUNCTIONS) and node.returns is None:
                yield f"line {node.lineno}: {node.name} does not say what it returns"

    assert faults(SOURCES, bare) == {}


def public(body: list[ast.stmt]) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef]:
    for node in body:
        if isinstance(node, (*FUNCTIONS, ast.ClassDef)) and not node.name.startswith("_"):
            yield node
            if isinstance(node, ast.ClassDef):
                yield from public(node.body)


def is_protocol_member(node: ast.AST) -> bool:
    """`def name(self) -> str: ...` declares; its Protocol has the words."""
    last = node.body[-1]
    return (
        isinstance(node, FUNCTIONS)
        and isinstance(last, ast.Expr)
        and isinstance(last.value, ast.Constant)
        and last.value.value is ...
    )


def test_nothing_below_the_workbench_prints():
    def prints(path: Path) -> list[int]:
        calls = [n for n in telling_nodes(path) if isinstance(n, ast.Call)]
        return [c.lineno for c in calls if isinstance(c.func, ast.Name) and c.func.id == "print"]

    assert faults((p for p in SOURCES if layer_of(p) not in ("workbench", "apps")), prints) == {}


def test_no_default_argument_can_be_changed():
    def changeable(path):
        for node in telling_nodes(path):
            if isinstance(node, (*FUNCTIONS, ast.Lambda)):
                defaults = [*node.args.defaults, *(d for d in node.args.kw_defaults if d is not None)]
                yield from (d.lineno for d in defaults if isinstance(d, (ast.List, ast.Dict, ast.Set)))

    assert faults(SOURCES, changeable) == {}


def test_what_belongs_together_is_passed_as_one():
    """Many parameters are a record that is missing; a verb with many settings takes `VerbSettings`."""

    def many(path):
        for node in telling_nodes(path):
            if isinstance(node, FUNCTIONS):
                given = [a.arg for a in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)]
                if len([name for name in given if name not in ("self", "cls")]) > MOST_PARAMETERS:
                    yield f"line {node.lineno}: {node.name} takes {len(given)}"

    assert faults(SOURCES, many) == {}
