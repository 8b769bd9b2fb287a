"""Tables as DataFrames, for those who have pandas."""

from __future__ import annotations

from typing import Any

from exoid.ground.errors import ExoidError


def pandas() -> Any:
    """Return the module pandas; ExoidError where it is not installed."""
    try:
        import pandas
    except ImportError as error:
        raise ExoidError(
            "DataFrames need the package pandas, which is not installed",
            remedy="pip install 'exoid[pandas]'; to_json() gives the same without it",
        ) from error
    return pandas
