"""The production code as the tests of its shape read it: every file parsed and walked once."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "exoid"
LAYERS = ("ground", "symbolic", "measurement", "optimisation", "diagnosis", "workbench", "apps", "exoid")
"""Lowest first; a package may import itself and what stands before it."""

SOURCES = sorted(PACKAGE.rglob("*.py"))


def module_of(path: Path) -> str:
    """Return the name under which the file is imported."""
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def layer_named(module: str) -> str:
    """Return the layer that a module belongs to; "" where it is not ours, "exoid" for the files at its top."""
    house, *rest = module.split(".")
    if house != "exoid":
        return ""
    return rest[0] if rest and rest[0] in LAYERS else "exoid"


def layer_of(path: Path) -> str:
    return layer_named(module_of(path))


def name_of(path: Path) -> str:
    return path.relative_to(PACKAGE).as_posix()


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text("utf-8"), filename=str(path))


@cache
def telling_nodes(path: Path) -> tuple[ast.AST, ...]:
    """Return imports, calls, functions and classes anywhere in the file: what the tests ask about."""
    kinds = (ast.Import, ast.ImportFrom, ast.Call, ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.ClassDef)
    return tuple(node for node in ast.walk(tree_of(path)) if isinstance(node, kinds))


def imported(node: ast.AST) -> list[str]:
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom) and node.level == 0:
        return [node.module or ""]
    return []


def faults(paths: Iterable[Path], find: Callable[[Path], Iterable[Any]]) -> dict[str, list[Any]]:
    """Return {file: what `find` finds there} of the files where it finds something."""
    found = {name_of(path): list(find(path)) for path in paths}
    return {name: one for name, one in found.items() if one}
