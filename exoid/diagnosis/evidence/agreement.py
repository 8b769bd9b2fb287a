"""Agreement of splits of the recordings about a term; without NumPy, which `exoid --help` does without."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from exoid.diagnosis.rules import Rules


@dataclass(frozen=True)
class Agreement:
    """In how many splits a term is `accepted`, of those that can tell (`of`), and the `ranges` of its parameters there.

    `against` are indices of the recordings that, set aside, lose by it. `splits` counts those that cannot tell too,
    `recordings` what they are splits of; `mute`: the split that is in use, of fitted and held-out recordings, cannot
    tell.
    """

    accepted: int = 0
    of: int = 0
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    against: tuple[int, ...] = ()
    splits: int = 0
    recordings: int = 0
    mute: bool = False

    @property
    def share(self) -> float | None:
        """The share of splits in which the term is accepted; None where no split can tell."""
        return self.accepted / self.of if self.of else None

    def enough(self, rules: Rules) -> bool:
        """True if so many splits agree that the term may be accepted; without splits nothing speaks against it."""
        return self.share is None or self.share >= rules.most

    def repeats(self, rules: Rules) -> bool:
        """True if nearly all splits of many recordings agree: so many do not by chance, whichever are held out.

        Those that cannot tell count against it; where that in use is one of them, most of all must.
        """
        told = self.of if self.mute and self.of > rules.half * self.splits else self.splits
        return self.recordings >= rules.many_recordings and self.accepted >= (1.0 - rules.level) * told
