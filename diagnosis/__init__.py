"""What is missing: comparison, suspects, look-alikes, verdict, extension.

In a notebook: `from exoid.diagnosis import compare, discover, watch`; `found = discover(leg, train, verify)`.
"""

from typing import TYPE_CHECKING

from exoid.ground.lazy import lend

if TYPE_CHECKING:
    from exoid.diagnosis.against.differences import compare_against as compare_against
    from exoid.diagnosis.compare import compare as compare
    from exoid.diagnosis.discover import diagnose as diagnose
    from exoid.diagnosis.discover import discover as discover
    from exoid.diagnosis.evidence.fitted import fitted_model as fitted_model
    from exoid.diagnosis.extend import add as add
    from exoid.diagnosis.separation.design import separate as separate
    from exoid.diagnosis.session.session import Session as Session
    from exoid.diagnosis.watching.replay import replay as replay
    from exoid.diagnosis.watching.watch import follow as follow
    from exoid.diagnosis.watching.watch import watch as watch

__all__ = lend(__name__)
