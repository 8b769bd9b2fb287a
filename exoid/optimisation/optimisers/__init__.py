"""The optimisers: every file of this folder, and of those that apps add, defines `OPTIMISER`."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Any

from exoid.ground.folder import with_apps


@cache
def optimisers() -> Mapping[str, Any]:
    """Optimiser classes by the name of their file, sorted."""
    found = with_apps(sys.modules[__name__])
    return MappingProxyType({name: importlib.import_module(module).OPTIMISER for name, module in found.items()})
