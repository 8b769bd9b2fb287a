"""Certainty that an effect is missing, in one word that is the same wherever a person reads it.

The word sums up figures that stand beside it for who wants them: how rarely placebos do as well, how many splits of the
recordings agree, whether something else does as well on these recordings, and how much is left where it shows. What is
left of the whole is a statement of its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from exoid.diagnosis.evidence.agreement import Agreement
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.thresholds import Threshold

RARE: Threshold = 0.002
"""share of placebos that do as well, at most, where one is very sure: one in twenty is not rare"""
AGREEING: Threshold = 0.9
"""share of splits that agree where one is very sure: the next recording may say otherwise"""
VERY, FAIRLY, UNSURE = "very sure", "fairly sure", "cannot tell"

MEANINGS: Mapping[str, str] = MappingProxyType(
    {
        VERY: f"at most {1000 * RARE:g} placebos in 1000 do as well (the same effect, shifted in time), half of the "
        f"splits of the recordings can tell and at least {100 * AGREEING:.0f} % of them agree, nothing else does as "
        f"well on these recordings, and what is left at its joints is near the noise (at most {RULES.near_noise:g} "
        "times)",
        FAIRLY: f"more than chance (at most {100 * RULES.level:.0f} % of such findings are), and enough "
        "splits of the recordings agree or there are too few recordings to split; more may be missing",
        UNSURE: "chance does as well, or the splits of the recordings disagree, or another effect does as well on them",
    }
)
"""What each word means."""


def meanings_of(words: Iterable[str]) -> list[str]:
    """Return "very sure: at most ..." for each of `words`, once, the surest first."""
    wanted = set(words)
    return [f"{word}: {meaning}" for word, meaning in MEANINGS.items() if word in wanted]


def least_sure(words: Iterable[str]) -> str:
    """Return the least sure of `words`; "" for none."""
    return max(words, key=[*MEANINGS].index, default="")


def sureness(
    p: float | None,
    agreement: Agreement | None = None,
    *,
    doubted: bool = False,
    left: float = 0.0,
    rules: Rules = RULES,
) -> str:
    """Return the word for an effect whose placebos do as well with probability `p` (None: nobody asked them).

    `agreement` is what splits of the recordings say; `doubted` where something speaks against it, or something else
    does as well; `left` how many times the noise is left at its joints beside it.
    """
    agreement = agreement or Agreement()
    if doubted or p is None or p > rules.level or not agreement.enough(rules):
        return UNSURE
    agreed = (agreement.share or 0.0) >= AGREEING and agreement.of >= rules.half * agreement.splits
    return VERY if p <= RARE and agreed and left <= rules.near_noise else FAIRLY
