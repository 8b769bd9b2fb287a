"""No module needs itself: no circle of imports, those inside functions and those for type checkers included."""

from __future__ import annotations

import ast
from graphlib import CycleError, TopologicalSorter

import pytest

from tests.architecture.source import (
    SOURCES,
    faults,
    imported,
    layer_named,
    layer_of,
    module_of,
    name_of,
    telling_nodes,
)

SLOW_TO_IMPORT = {
    "casadi", "cma", "cycler", "h5py", "jinja2", "joblib", "markupsafe", "matplotlib", "mpmath",
    "numpy", "pandas", "pyarrow", "pymoo", "rich", "scipy", "sympy", "tomli_w",
    "difflib", "distributed", "fcntl", "importlib", "shtab", "statsmodels",
    "submitit", "traceback", "starlette", "uvicorn",
    "lz4", "matio", "nptdms", "polars", "python_calamine", "rosbags", "xarray",
    "paho", "prometheus_client", "rclpy", "sensor_msgs",
}  # fmt: skip
"""What may be imported where it is used, so that a command that does not need it does not wait for it."""

EDGES = ("workbench", "apps", "exoid")
DOORS = (
    "symbolic/model_structure.py", "symbolic/codegen/fingerprint.py", "symbolic/codegen/kernel.py",
    "symbolic/mechanics/payload.py", "symbolic/term.py",
)  # fmt: skip
"""Where our own modules may be imported inside functions: a command loads only what it runs, and these modules are
the doors to the derivation, which a model whose code is compiled already never needs.
"""


def modules():
    """Return {dotted name: path} of every module of ours."""
    return {module_of(p): p for p in SOURCES}


def needs(path, known):
    """Return the modules of ours that the module at `path` imports anywhere."""
    found = set()
    for node in telling_nodes(path):
        if isinstance(node, ast.ImportFrom):
            # `from package import name` needs the module package.name where there is one, else the package.
            for name in (f"{node.module}.{alias.name}" for alias in node.names):
                found.add(name if name in known else node.module)
        else:
            found.update(imported(node))
    return found & set(known)


def test_no_module_needs_itself():
    known = modules()
    graph = {name: needs(path, known) - {name} for name, path in known.items()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as circle:
        pytest.fail(" -> ".join(reversed(circle.args[1])))


def test_imports_inside_functions_are_for_start_up_time():
    def needless(path):
        functions = [n for n in telling_nodes(path) if isinstance(n, (ast.FunctionDef, ast.AsyncFunctionDef))]
        inside = {(n.lineno, m) for f in functions for n in ast.walk(f) for m in imported(n)}
        lazy = layer_of(path) in EDGES or name_of(path) in DOORS
        fine = {m for _, m in inside if (layer_named(m) and lazy) or m.split(".")[0] in SLOW_TO_IMPORT}
        return sorted((n, m) for n, m in inside if m not in fine)

    assert faults(SOURCES, needless) == {}


def test_pictures_draw_data_and_know_no_result():
    """A result calls its picture with arrays and words; a picture that knew the result could draw nothing else."""
    drawn = {name for source in SOURCES for name in classes_with_a_plot(source)}
    assert drawn, "nothing has a plot method"

    def known(path):
        taken = {a.name for n in telling_nodes(path) if isinstance(n, ast.ImportFrom) for a in n.names}
        return sorted(taken & drawn)

    assert faults((p for p in SOURCES if p.stem == "plots"), known) == {}


def classes_with_a_plot(path):
    for node in telling_nodes(path):
        if isinstance(node, ast.ClassDef) and "plot" in [f.name for f in node.body if isinstance(f, ast.FunctionDef)]:
            yield node.name
