"""Settings of a watch: how long it learns, how soon it names, how often it may be wrong."""

from __future__ import annotations

from dataclasses import dataclass, field

from exoid.apps.watch.front import CUTOFF
from exoid.apps.watch.recursive.estimator import Pace


@dataclass(frozen=True)
class Settings:
    """Settings of a watch. `block` s are judged at a time; `learn` blocks say at first what is usual; a change is named
    when it has lasted `least` blocks and once more after `sure`; `alarms_per_day` false alarms are accepted; `placebos`
    are drawn per block for the threshold, and `draws` for a name. `estimates` says every so many blocks what the
    numbers are (0: never).
    """

    cutoff: float = CUTOFF
    block: float = 5.0
    learn: int = 24
    most_learn: int = 72
    least: int = 3
    sure: int = 12
    alarms_per_day: float = 1.0
    placebos: int = 40
    draws: int = 999
    estimates: int = 0
    pace: Pace = field(default_factory=Pace)
    seed: int = 0
