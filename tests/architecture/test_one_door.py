"""`import exoid` gives everything a notebook needs, under one name, from a checkout and installed."""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys

import pytest

import exoid
from tests.architecture.source import LAYERS, ROOT
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


def test_what_its_docstring_names_is_there():
    named = exoid.__doc__.split("the leg")[1].split("`dir(exoid)`")[0].split("`")[1::2]
    assert named and set(named) <= set(exoid.__all__)


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
    assert out.split() == ["exoid.symbolic.model", "exoid.diagnosis.discover"], err


def test_a_package_imported_by_itself_is_refused_with_the_right_import(tmp_path):
    """From a checkout its folder is found; loaded a second time, a Model would be no Model."""
    tried = f"""
import importlib
for name in {PARTS!r}:
    try:
        importlib.import_module(name)
    except ImportError as error:
        print(name, f"write `from exoid.{{name}} import ...` instead" in str(error))
"""
    out, err = python(tried, tmp_path)
    assert out.split() == [word for part in PARTS for word in (part, "True")], err


def test_every_file_is_loaded_once_and_under_one_name(tmp_path):
    script = f"""
import importlib, pkgutil, sys
from collections import Counter
import exoid
for part in {PARTS!r}:
    package = importlib.import_module(f"exoid.{{part}}")
    for found in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if not found.name.endswith("__main__"):
            importlib.import_module(found.name)
files = {{name: module.__spec__.origin for name, module in sys.modules.items() if name.startswith("exoid.")}}
home = exoid.__file__.removesuffix("exoid/__init__.py")
folders = tuple(home + part + "/" for part in (*{PARTS!r}, "exoid"))
ours = [name for name, module in sys.modules.items() if (getattr(module, "__file__", "") or "").startswith(folders)]
print(len(files) > 400, [name for name in ours if name != "exoid" and name not in files])
print([one for one, count in Counter(files.values()).items() if count > 1])
print([one for one in files.values() if one.startswith(home + "exoid/") and not one.endswith("places.py")])
"""
    out, err = python(script, tmp_path)
    assert out.splitlines() == ["True []", "[]", "[]"], err


def test_what_is_installed_what_is_layered_and_what_editors_are_led_to_are_the_same_packages():
    assert set(PARTS) == set(LAYERS) - {"exoid"}
    said = (ROOT / "setup.py").read_text("utf-8")
    assert f"PARTS = {PARTS!r}".replace("'", '"') in said
    for part in PARTS:
        link = ROOT / "exoid" / part
        target = os.readlink(link) if link.is_symlink() else link.read_text("utf-8")  # a clone without links
        assert target == f"../{part}"


@pytest.mark.parametrize("kind", ["a clone without links", "installed"])
def test_the_packages_are_found_without_links(kind, tmp_path):
    (tmp_path / "exoid").mkdir()
    for path in (ROOT / "exoid").glob("*.py"):
        shutil.copy(path, tmp_path / "exoid")
    for part in PARTS:
        if kind == "installed":
            shutil.copytree(ROOT / part, tmp_path / "exoid" / part)
        else:
            shutil.copytree(ROOT / part, tmp_path / part)
            (tmp_path / "exoid" / part).write_text(f"../{part}")
    script = "import exoid, exoid.ground.import_path as p; print(exoid.Model.__name__, exoid.symbolic.__file__, p.HOME)"
    out, err = python(script, tmp_path, path=tmp_path)
    inside = tmp_path / "exoid" if kind == "installed" else tmp_path
    assert out.split() == ["Model", str(inside / "symbolic" / "__init__.py"), str(tmp_path)], err
