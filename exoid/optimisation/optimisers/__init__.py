"""The optimisers: every file of this folder defines `OPTIMISER`; there is nothing to register."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Any

from exoid.ground.folder import modules_in


@cache
def optimisers() -> Mapping[str, Any]:
    """Return {file name: optimiser class} of this folder, sorted by name."""
    found = modules_in(sys.modules[__name__])
    return MappingProxyType({name: module.OPTIMISER for name, module in found.items()})
