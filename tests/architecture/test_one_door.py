"""`import exoid` gives everything a notebook needs, under one name, from a checkout and installed."""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys

import pytest

import exoid
from tests.architecture.source import PACKAGE, ROOT, SOURCES, imported, telling_nodes
from tests.waiting import HUNG

DOORS = ("symbolic", "measurement", "optimisation", "diagnosis")
PARTS = ("ground", "symbolic", "measurement", "optimisation", "diagnosis", "workbench")


@pytest.mark.parametrize("package", DOORS)
def test_every_name_of_the_packages_is_behind_the_door(package):
    module = importlib.import_module(f"exoid.{package}")
    assert set(module.__all__) <= set(exoid.__all__)
    for name in module.__all__:
        assert getattr(exoid, name) is getattr(module, name)


def test_no_two_packages_lend_one_name():
    assert len(exoid.__all__) == len(set(exoid.__all__))
    lent = [name for part in DOORS for name in sys.modules[f"exoid.{part}"].__all__]
    assert len(lent) == len(set(lent)) and set(lent) < set(exoid.__all__)


def test_a_name_that_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no_such_thing"):
        _ = exoid.no_such_thing


def python(script, folder, path=ROOT):
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=folder, env={**os.environ, "PYTHONPATH": str(path)}, timeout=HUNG,
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done.stdout, done.stderr


def test_the_door_costs_nothing_until_something_is_fetched():
    script = "import sys, exoid; print({'numpy', 'sympy', 'casadi', 'scipy', 'pandas'} & set(sys.modules))"
    assert python(script, ROOT)[0].strip() == "set()"


def test_a_users_files_of_the_same_names_do_not_disturb(tmp_path):
    for part in PARTS:
        (tmp_path / f"{part}.py").write_text("raise SystemExit('not exoid')\n")
    out, err = python("import exoid; print(exoid.Model.__module__, exoid.discover.__module__)", tmp_path)
    assert out.split() == ["exoid.symbolic.model", "exoid.diagnosis.discovery"], err


def test_a_copy_of_the_folder_runs_and_no_file_in_it_is_a_link(tmp_path):
    """A clone without links, a zip, what is installed: one plain folder is all that Python needs."""
    assert [path for path in PACKAGE.rglob("*") if path.is_symlink()] == []
    shutil.copytree(PACKAGE, tmp_path / "exoid")
    out, err = python("import exoid; print(exoid.Model.__name__, exoid.symbolic.__file__)", tmp_path, path=tmp_path)
    assert out.split() == ["Model", str(tmp_path / "exoid" / "symbolic" / "__init__.py")], err


def test_nothing_is_imported_through_the_links_at_the_top():
    links = [path.name for path in ROOT.iterdir() if path.is_symlink()]
    files = [*SOURCES, *(ROOT / "tests").rglob("*.py"), *(ROOT / "benchmarks").rglob("*.py")]

    def through(path):
        return [module for node in telling_nodes(path) for module in imported(node) if module.split(".")[0] in links]

    assert [str(path) for path in files if through(path)] == []
