"""The optimisers: every file of this folder defines `OPTIMISER`; there is nothing to register."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Any


@cache
def optimisers() -> Mapping[str, Any]:
    """Return {file name: optimiser class} of this folder, sorted by name."""
    names = sorted(info.name for info in pkgutil.iter_modules(__path__))
    return MappingProxyType({n: importlib.import_module(f"{__name__}.{n}").OPTIMISER for n in names})
