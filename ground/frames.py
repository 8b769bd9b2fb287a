"""Tables as DataFrames, for those who have pandas."""

from __future__ import annotations

from typing import Any

from exoid.ground.extras import needing


def pandas() -> Any:
    """Return the module pandas; ExoidError where it is not installed."""
    with needing("pandas", "DataFrames", "pandas", instead="; to_json() gives the same without it"):
        import pandas
    return pandas
