"""What is missing: comparison, suspects, look-alikes, verdict, extension.

In a notebook: `from diagnosis import compare, discover, watch`; `found = discover(leg, train, verify)`.
"""

from typing import TYPE_CHECKING

from ground.lazy import lend

if TYPE_CHECKING:
    from diagnosis.compare import compare
    from diagnosis.discover import diagnose, discover
    from diagnosis.extend import add, watch
    from diagnosis.separation.design import separate

__all__ = ["add", "compare", "diagnose", "discover", "separate", "watch"]

lend(
    __name__,
    {
        "add": "diagnosis.extend",
        "compare": "diagnosis.compare",
        "diagnose": "diagnosis.discover",
        "discover": "diagnosis.discover",
        "separate": "diagnosis.separation.design",
        "watch": "diagnosis.extend",
    },
)
