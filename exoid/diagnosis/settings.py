"""Settings of `diagnose`, `discover` and a session."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypedDict

from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.settings import VerbSettings, setting
from exoid.measurement.signals.methods import BUTTERWORTH, DERIVATIVES

if TYPE_CHECKING:
    from exoid.symbolic.effect import Effect


class DiagnosisOptions(TypedDict, total=False):
    """`DiagnosisSettings` as keywords."""

    seed: int
    cutoff: float | None
    derivative: str
    extra: Sequence[Effect]
    rules: Rules


class DiscoveryOptions(DiagnosisOptions, total=False):
    """`DiscoverySettings` as keywords."""

    most: int | None


@dataclass(frozen=True, kw_only=True, eq=False)
class DiagnosisSettings(VerbSettings):
    """Settings of the preparation of recordings, and the rules by which suspects are weighed."""

    cutoff: float | None = setting(None, "Hz of the common filter; without it, chosen from the recordings")
    derivative: str = setting(
        BUTTERWORTH,
        "how accelerations come from angles: butterworth, savgol, or fourier for motion that repeats, whose periods "
        "are averaged",
        choices=DERIVATIVES,
    )
    extra: Sequence[Effect] = setting(
        (), "effects beyond the catalogue and the model's own, which are suspected anyway"
    )
    rules: Rules = setting(RULES, "the thresholds that decide")


@dataclass(frozen=True, kw_only=True, eq=False)
class DiscoverySettings(DiagnosisSettings):
    """Limit of a search."""

    most: int | None = setting(None, "effects that are added at most; without it, what the rules say")

    def limited(self, joints: int) -> Rules:
        """The rules for a machine of so many `joints`, with `most` in them. Of many joints less is searched: candidates
        are as many as joints, and so is what is compared with each.
        """
        rules, less = self.rules, min(1.0, self.rules.few_joints / joints)
        most = max(rules.most_terms, joints * rules.most_per_joint) if self.most is None else self.most
        searched = min(rules.searched_seconds, max(rules.least_searched, less**2 * rules.searched_seconds))
        whole = rules.whole_seconds * searched / rules.searched_seconds
        stretch = less * rules.stretch_seconds
        return replace(rules, most_terms=most, whole_seconds=whole, searched_seconds=searched, stretch_seconds=stretch)
