"""Python source reduced to what it computes: without comments, docstrings, layout, and the texts of errors.

Two versions of a file that differ in nothing else have the same reduced form, so that rewording a message leaves every
compiled model valid.
"""

from __future__ import annotations

import ast
from typing import Any

WARNINGS = ("warn", "warn_slow")
"""Functions that only tell a person something."""


def computing_part(source: str) -> str:
    """Return the syntax tree of Python `source` as text, without docstrings and what only error messages use."""
    tree = _Pruning().visit(ast.parse(source))
    _drop_unused_helpers(tree)
    return ast.dump(tree)


class _Pruning(ast.NodeTransformer):
    def visit_Expr(self, node: ast.Expr) -> Any:
        """Drop a text that stands by itself: a docstring."""
        if isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            return None
        return self.generic_visit(node)

    def visit_Raise(self, node: ast.Raise) -> Any:
        """Keep that something is raised, and what; drop its text."""
        raised = node.exc.func if isinstance(node.exc, ast.Call) else node.exc
        return ast.Raise(exc=raised, cause=None)

    def visit_Call(self, node: ast.Call) -> Any:
        """Drop what a warning says."""
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        return ast.Call(node.func, [], []) if name in WARNINGS else self.generic_visit(node)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> Any:
        """Drop the body of a function that makes an error, and texts that only errors of this function use."""
        if node.returns is not None and ast.unparse(node.returns).endswith("Error"):
            node.body = []
            return node
        self.generic_visit(node)
        used = _loaded(node)
        node.body = [part for part in node.body if not _is_unused_text(part, used)]
        return node


def _is_unused_text(node: ast.stmt, used: frozenset[str]) -> bool:
    if not (isinstance(node, ast.Assign) and len(node.targets) == 1 and isinstance(node.targets[0], ast.Name)):
        return False
    texts = any(isinstance(part, ast.Constant) and isinstance(part.value, str) for part in ast.walk(node.value))
    return texts and node.targets[0].id not in used


def _drop_unused_helpers(tree: ast.Module) -> None:
    """Drop private functions that nothing uses any more once the texts of errors are gone."""
    while True:
        used = _loaded(tree)
        kept = [part for part in tree.body if not (_is_private_function(part) and part.name not in used)]  # type: ignore[attr-defined]
        if len(kept) == len(tree.body):
            return
        tree.body = kept


def _is_private_function(node: ast.stmt) -> bool:
    return isinstance(node, ast.FunctionDef) and node.name.startswith("_")


def _loaded(tree: ast.AST) -> frozenset[str]:
    names = (part.id for part in ast.walk(tree) if isinstance(part, ast.Name) and isinstance(part.ctx, ast.Load))
    return frozenset(names)
