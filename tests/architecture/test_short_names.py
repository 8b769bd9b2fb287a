"""`from exoid.optimisation import identify` works, whoever imported what before, and costs nothing until it is used."""

from __future__ import annotations

import importlib
import pkgutil
import subprocess
import sys
from types import ModuleType

import pytest

from tests.waiting import HUNG

PACKAGES = ("exoid.symbolic", "exoid.measurement", "exoid.optimisation", "exoid.diagnosis", "exoid.workbench")
HEAVY = ("numpy", "sympy", "casadi", "scipy", "pandas", "matplotlib")

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
    with pytest.raises(AttributeError, match="no_such_thing"):
        _ = importlib.import_module(package).no_such_thing


@pytest.mark.parametrize("package", PACKAGES)
def test_no_file_or_folder_of_a_package_has_the_name_of_a_function(package):
    """Importing it would put the module in the function's place."""
    module = importlib.import_module(package)
    assert not {found.name for found in pkgutil.iter_modules(module.__path__)} & set(module.__all__)


def test_importing_the_packages_is_cheap():
    script = f"import sys, {', '.join(PACKAGES)}; print([m for m in {HEAVY!r} if m in sys.modules])"
    assert run(script) == "[]"


def run(script):
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=HUNG)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()
