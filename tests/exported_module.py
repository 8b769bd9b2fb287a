"""Exported Python, imported as its user would import it."""

from __future__ import annotations

import importlib.util


def python_module(text: str, folder, name: str):
    """Write `text` to `name`.py in `folder`, and return it as a module."""
    path = folder / f"{name}.py"
    path.write_text(text, encoding="utf-8")
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
