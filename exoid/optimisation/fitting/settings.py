"""Settings of the fit of a model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypedDict

from exoid.ground.settings import VerbSettings, setting

if TYPE_CHECKING:
    from exoid.optimisation.optimiser import Optimiser
    from exoid.symbolic.motion import Float

MULTISTART = "multistart"
"""The grid and local searches for shape parameters, in place of an optimiser."""


@dataclass(frozen=True)
class Search:
    """An optimiser and the coordinates it searches in."""

    optimiser: Optimiser
    whitened: bool = False


class FitOptions(TypedDict, total=False):
    """`FitSettings` as keywords."""

    seed: int
    optimisers: Mapping[str, Search] | tuple[()] | None
    shape: Float | None
    start: Float | None
    delta: Float | None
    weighted: bool
    physical: bool
    shape_search: str


@dataclass(frozen=True, kw_only=True, eq=False)
class FitSettings(VerbSettings):
    """Settings of a fit."""

    optimisers: Mapping[str, Search] | tuple[()] | None = setting(
        None, "who solves the problems beside the exact solution, {name: Search}; () for no NFO and no IPOPT"
    )
    shape: Float | None = setting(None, "shape parameters (S,), fixed instead of searched")
    start: Float | None = setting(None, "where shape parameters are searched, (S,) or (R, S), and only from there")
    delta: Float | None = setting(None, "thresholds (J,) of the Huber loss, fixed instead of by the 14 % rule")
    weighted: bool = setting(
        False, "misses count in parts of what is left of their joint, as is usual for arms: a joint that is modelled "
        "badly does not bend the others"
    )
    physical: bool = setting(
        False, "only parameters that some machine could have: positive masses and inertias, friction that brakes"
    )
    shape_search: str = setting(
        MULTISTART, "how shape parameters are looked for: multistart (a grid), nfo, or another optimiser"
    )
