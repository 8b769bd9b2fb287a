"""`import exoid` gives everything a notebook needs, and says so where another package stands in the way."""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import exoid
from exoid.own_packages import OWN, check_own_packages

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("package", ["symbolic", "measurement", "optimisation", "diagnosis"])
def test_every_name_of_the_packages_is_behind_the_door(package):
    module = importlib.import_module(package)
    assert set(module.__all__) <= set(exoid.__all__)
    for name in module.__all__:
        assert getattr(exoid, name) is getattr(module, name)


def test_no_two_packages_lend_one_name():
    assert len(exoid.__all__) == len(set(exoid.__all__))
    lent = [name for p in ("symbolic", "measurement", "optimisation", "diagnosis") for name in sys.modules[p].__all__]
    assert len(lent) == len(set(lent)) and set(lent) < set(exoid.__all__)


def test_what_its_docstring_names_is_there():
    named = exoid.__doc__.split("the leg")[1].split("`dir(exoid)`")[0].split("`")[1::2]
    assert named and set(named) <= set(exoid.__all__)


def test_a_name_that_is_not_there_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no_such_thing"):
        _ = exoid.no_such_thing


def python(script, folder):
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)}, timeout=60,
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done.stdout, done.stderr


def test_the_door_costs_nothing_until_something_is_fetched():
    script = "import sys, exoid; print({'numpy', 'sympy', 'casadi', 'scipy', 'pandas'} & set(sys.modules))"
    assert python(script, ROOT)[0].strip() == "set()"


@pytest.mark.parametrize("package", OWN)
def test_a_file_of_the_same_name_is_noticed(package, tmp_path):
    (tmp_path / f"{package}.py").write_text("pi = 3\n")
    _, err = python("import exoid", tmp_path)
    last = err[err.index("ImportError") :]
    assert f"its own package {package!r}" in last and str(tmp_path / f"{package}.py") in last and "rename" in last


def test_a_package_overwritten_by_another_distribution_is_noticed(tmp_path):
    for package in (*OWN, "exoid"):
        (tmp_path / package).mkdir()
        shutil.copy(ROOT / package / "__init__.py", tmp_path / package)
    shutil.copy(ROOT / "exoid" / "own_packages.py", tmp_path / "exoid")
    (tmp_path / "measurement" / "__init__.py").write_text("class Measurement: ...\n")
    _, err = python("import exoid", tmp_path)
    assert "its own package 'measurement'" in err and "an environment of its own" in err


def test_a_package_that_is_missing_is_noticed(monkeypatch):
    monkeypatch.setattr("exoid.own_packages.OWN", (*OWN, "no_such_package"))
    with pytest.raises(ImportError, match=r"'no_such_package'.* is not there"):
        check_own_packages()
