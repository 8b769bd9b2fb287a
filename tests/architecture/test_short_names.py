"""`from exoid.optimisation import identify` works, whoever imported what before, and costs nothing until it is used."""

from __future__ import annotations

import importlib
import subprocess
import sys
from types import ModuleType

import pytest

from tests.waiting import HUNG

PACKAGES = ("exoid.symbolic", "exoid.measurement", "exoid.optimisation", "exoid.diagnosis", "exoid.workbench")
HEAVY = ("numpy", "sympy", "casadi", "scipy", "pandas", "matplotlib")
SHADOWED = [
    ("exoid.diagnosis", "compare"),
    ("exoid.diagnosis", "discover"),
]
"""Functions that live in a file of their own name."""


@pytest.mark.parametrize("package", PACKAGES)
def test_every_short_name_is_the_thing_itself(package):
    module = importlib.import_module(package)
    for name in module.__all__:
        value = getattr(module, name)
        assert callable(value) and not isinstance(value, ModuleType), name
        assert value.__name__ == name and value.__module__.startswith(f"{package}.")
        assert name in dir(module)


@pytest.mark.parametrize("package", PACKAGES)
def test_a_wrong_name_is_an_attribute_error(package):
    with pytest.raises(AttributeError, match=f"module '{package}' has no attribute 'no_such_thing'"):
        _ = importlib.import_module(package).no_such_thing


@pytest.mark.parametrize("before", ["", "import {package}.{name}; ", "from {package}.{name} import {name}; "])
def test_a_file_of_the_same_name_does_not_hide_the_function(before):
    """Each order of imports in a process of its own."""
    script = "same = []\n" + "".join(
        before.format(package=package, name=name)
        + f"from {package} import {name} as short; from {package}.{name} import {name} as long; "
        + "same.append(short is long)\n"
        for package, name in SHADOWED
    )
    assert run(script + "print(same)") == str([True] * len(SHADOWED))


def test_importing_the_packages_is_cheap():
    script = f"import sys, {', '.join(PACKAGES)}; print([m for m in {HEAVY!r} if m in sys.modules])"
    assert run(script) == "[]"


def run(script):
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=HUNG)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()
