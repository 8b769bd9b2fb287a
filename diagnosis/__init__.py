"""What is missing: comparison, suspects, look-alikes, verdict, extension.

In a notebook: `from diagnosis import compare, discover, watch`; `found = discover(leg, train, verify)`.
"""

from typing import TYPE_CHECKING

from ground.lazy import lend

if TYPE_CHECKING:
    from diagnosis.compare import compare as compare
    from diagnosis.discover import diagnose as diagnose
    from diagnosis.discover import discover as discover
    from diagnosis.evidence.fitted import fitted_model as fitted_model
    from diagnosis.extend import add as add
    from diagnosis.separation.design import separate as separate
    from diagnosis.session.session import Session as Session
    from diagnosis.watching.differences import compare_against as compare_against
    from diagnosis.watching.replay import replay as replay
    from diagnosis.watching.watch import follow as follow
    from diagnosis.watching.watch import watch as watch

__all__ = lend(__name__)
