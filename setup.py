"""What is installed: the packages at the top of the repository, as parts of `exoid`; all else is in pyproject.toml."""

from setuptools import find_packages, setup

PARTS = ("ground", "symbolic", "measurement", "optimisation", "diagnosis", "workbench")

found = find_packages(include=[pattern for part in PARTS for pattern in (part, f"{part}.*")])
setup(
    packages=["exoid", *(f"exoid.{name}" for name in found)],
    package_dir={f"exoid.{part}": part for part in PARTS},
)
