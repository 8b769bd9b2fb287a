"""What is installed: the packages at the top of the repository, as parts of `exoid`; all else is in pyproject.toml."""

import shutil

from setuptools import find_namespace_packages, setup
from setuptools.command.build_py import build_py

PARTS = ("ground", "symbolic", "measurement", "optimisation", "diagnosis", "workbench")


class FreshBuild(build_py):
    """setuptools installs whatever lies in build/lib, what an older version left there as well."""

    def run(self) -> None:
        """Build into an empty folder."""
        if not self.editable_mode:
            shutil.rmtree(self.build_lib, ignore_errors=True)
        super().run()


everything = [pattern for part in PARTS for pattern in (part, f"{part}.*")]
found = find_namespace_packages(include=everything, exclude=["*.__pycache__"])  # folders of data are packages too
setup(
    packages=["exoid", *(f"exoid.{name}" for name in found)],
    package_dir={f"exoid.{part}": part for part in PARTS},
    cmdclass={"build_py": FreshBuild},
)
