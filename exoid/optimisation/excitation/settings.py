"""Settings of a design: the motion, its criterion, and the search for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, TypedDict

from exoid.ground.errors import ExoidError
from exoid.ground.folder import with_apps
from exoid.ground.settings import VerbSettings, setting
from exoid.optimisation import optimisers

if TYPE_CHECKING:
    from exoid.optimisation.excitation.criteria import Noise
    from exoid.symbolic.model_file import Numbers

DURATION = 30.0
"""s of recording for which standard deviations are predicted."""
OFFSETS = ("paper", "middle", "free")
"""Where a motion is centred: θ_0 of the paper, the middle of the angle range, or wherever is best."""
OPTIMISERS = tuple(with_apps(optimisers))
CRITERION_NAMES = ("condition", "d_optimal", "worst")
"""What a motion is evaluated by; `exoid.optimisation.excitation.criteria` computes them."""


class DesignError(ExoidError):
    """A design that cannot be made: unknown words, or no motion inside the limits."""


class MotionOptions(TypedDict, total=False):
    """`MotionSettings` as keywords."""

    seed: int
    period: float
    harmonics: int
    offsets: str
    rest: bool
    use: float
    noise: Noise | None
    numbers: Numbers | None
    duration: float
    generations: int


class DesignOptions(MotionOptions, total=False):
    """`DesignSettings` as keywords."""

    criterion: str
    printed: bool
    box: float
    starts: int
    individuals: int
    optimiser: str


@dataclass(frozen=True, kw_only=True)
class MotionSettings(VerbSettings):
    """A motion to be designed, whatever for."""

    refusal: ClassVar[type[ExoidError]] = DesignError

    period: float = setting(10.0, "length of one period", 0.01, 1e5, "s")
    harmonics: int = setting(5, "number of harmonics", 1, 20)
    offsets: str = setting("paper", "where the motion is centred: paper, middle or free", choices=OFFSETS)
    rest: bool = setting(False, "start and end at rest: no velocity, no acceleration")
    use: float = setting(1.0, "share of the limits that may be used; 0.9 leaves room for tracking errors")
    noise: Noise | None = setting(None, "standard deviation of a torque sample; without it, that of the bench")
    numbers: Numbers | None = setting(None, "identified parameters of the model; without them, typical sizes")
    duration: float = setting(DURATION, "length of the recording", 0.1, 1e7, "s")
    generations: int = setting(400, "generations of the search", 0, 100_000)

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0.0 < self.use <= 1.0:
            raise DesignError(f"{self.use:g} of the limits", remedy="give a share above 0 and at most 1")


@dataclass(frozen=True, kw_only=True)
class DesignSettings(MotionSettings):
    """A motion that tells as much as possible about a model's parameters."""

    criterion: str = setting(
        "condition",
        "condition: cond(Y), as the paper; d_optimal: log det; worst: largest relative deviation",
        choices=CRITERION_NAMES,
    )
    printed: bool = setting(False, "NFO as the paper prints it: Inf outside the limits")
    box: float = setting(1.0, "with the printed form: half-width of its box", 1e-6, 1e6)
    starts: int = setting(0, "starts of IPOPT, for a second opinion", 0, 1000)
    individuals: int = setting(20, "population of the search")
    optimiser: str = setting("cma_es", "what searches; nfo does so in stages from smooth to exact", choices=OPTIMISERS)
