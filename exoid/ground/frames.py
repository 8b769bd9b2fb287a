"""Tables as DataFrames, for those who have pandas."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from exoid.ground.extras import needing

if TYPE_CHECKING:
    import pandas as pd


class Pandas(Protocol):
    """Part of the module that is used."""

    @property
    def DataFrame(self) -> type[pd.DataFrame]: ...  # noqa: D102


def pandas() -> Pandas:
    """Return the module pandas; ExoidError where it is not installed."""
    with needing("pandas", "DataFrames", "pandas", instead="; to_json() gives the same without it"):
        import pandas
    return pandas
