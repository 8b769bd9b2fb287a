"""What is missing: comparison, suspects, look-alikes, verdict, extension.

In a notebook: `from diagnosis import compare, discover, watch`; `found = discover(leg, train, verify)`.
"""

from typing import TYPE_CHECKING

from ground.lazy import lend

if TYPE_CHECKING:
    from diagnosis.compare import compare
    from diagnosis.discover import diagnose, discover
    from diagnosis.extend import add
    from diagnosis.separation.design import separate
    from diagnosis.session.session import Session
    from diagnosis.watching.differences import compare_against
    from diagnosis.watching.replay import replay
    from diagnosis.watching.watch import follow, watch

__all__ = [
    "Session", "add", "compare", "compare_against", "diagnose", "discover", "follow", "replay", "separate", "watch",
]  # fmt: skip

lend(
    __name__,
    {
        "Session": "diagnosis.session.session",
        "add": "diagnosis.extend",
        "compare_against": "diagnosis.watching.differences",
        "compare": "diagnosis.compare",
        "diagnose": "diagnosis.discover",
        "discover": "diagnosis.discover",
        "follow": "diagnosis.watching.watch",
        "replay": "diagnosis.watching.replay",
        "separate": "diagnosis.separation.design",
        "watch": "diagnosis.watching.watch",
    },
)
