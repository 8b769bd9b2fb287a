"""Result of the design of a separating experiment."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.diagnosis.separation.distance import Rival
from exoid.diagnosis.separation.indistinguishable import Same
from exoid.diagnosis.separation.plots import separation_figure
from exoid.ground.frames import pandas
from exoid.ground.html import code, picture
from exoid.ground.plain import AsJson
from exoid.ground.thresholds import Threshold
from exoid.measurement.trajectories.extremes import Use
from exoid.measurement.trajectories.trajectory import Fourier
from exoid.measurement.trajectories.trajectory_file import trajectory_content
from exoid.optimisation.excitation.criteria import Noise
from exoid.symbolic.model import Model

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

ENOUGH: Threshold = 3.0
"""σ between rivals on the designed motion: one run would choose by chance"""

Apart = Mapping[tuple[str, str], float]
"""(truth, rival) -> σ apart after the rival and everything else have been refitted."""


@dataclass(frozen=True, eq=False)
class Separation(AsJson):
    """The motion that distinguishes rivals, or why there is none.

    `apart` are the distances on `trajectory` (None where no pair can be distinguished) in `duration` s, `present` those
    on the recordings given (`present_seconds` long), `usual` the median of motions drawn at random, of the same length
    as the design. `same` are rivals that no motion can distinguish, with what else would.
    """

    model: Model
    rivals: tuple[Rival, ...]
    same: tuple[Same, ...]
    trajectory: Fourier | None
    apart: Apart
    present: Apart | None
    present_seconds: float
    usual: Apart
    noise: Noise
    duration: float
    cutoff: float
    uses: tuple[Use, ...]
    seed: int
    seconds: float = field(default=0.0, repr=False)

    @property
    def smallest(self) -> float:
        """The smallest distance of any pair, σ; zero where some pair makes the same torque."""
        if any(item.mutual for item in self.same) or not self.apart:
            return 0.0
        return min(self.apart.values())

    @property
    def separable(self) -> bool:
        """True if every pair will be at least `ENOUGH` σ apart."""
        return self.smallest >= ENOUGH

    @property
    def needed(self) -> float:
        """Seconds of this motion after which the closest pair is `ENOUGH` σ apart; infinite where none is enough."""
        found = min(self.apart.values(), default=0.0)
        return self.duration * (ENOUGH / found) ** 2 if found > 0.0 else math.inf

    @property
    def sentence(self) -> str:
        """The answer for a person."""
        blind = [item.sentence for item in self.same]
        if not self.apart:
            return ". ".join(blind) + "."
        text = f"{self.duration:g} s of this motion put the closest rivals {min(self.apart.values()):.1f} σ apart"
        text += f", {min(self.usual.values()):.1f} σ on a motion drawn at random"
        if self.present is not None:
            now = min(self.present.values())
            text += f", and {now:.1f} σ in the {self.present_seconds:.0f} s of the present recordings"
        if min(self.apart.values()) < ENOUGH:
            took = f"it would take {self.needed:.0f} s" if self.needed < math.inf else "no time would be enough"
            text += f"; for {ENOUGH:g} σ {took}"
        return ". ".join([text, *blind]) + "."

    def __repr__(self) -> str:
        lines = [self.sentence]
        for pair, far in self.apart.items():
            now = "" if self.present is None else f", present recordings {self.present[pair]:.1f} σ"
            lines.append(f"  {pair[0]} true, {pair[1]} fitted: {far:.1f} σ; at random {self.usual[pair]:.1f} σ{now}")
        lines += [f"  {rival.sentence}" for rival in self.rivals]
        lines.append(f"  noise: {self.noise}")
        lines += [f"  instead: {way}" for item in self.same for way in item.ways]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        return code(repr(self)) + picture(self.plot(), "The motion, and how far apart the rivals are on it")

    def to_frame(self) -> pd.DataFrame:
        """Return one row per (truth, rival): σ apart by design, at random, in the present recordings."""
        present = self.present or dict.fromkeys(self.apart)
        rows = [(*pair, far, self.usual[pair], present[pair]) for pair, far in self.apart.items()]
        return pandas().DataFrame(rows, columns=["truth", "rival", "designed", "at_random", "present"])

    def plot(self) -> Figure:
        """Draw the distances, and the motion."""
        bars = [("designed", self.apart), ("at random", self.usual)]
        if self.present is not None:
            bars.append((f"present ({self.present_seconds:.0f} s)", self.present))
        path = self.trajectory
        return separation_figure(
            [f"{a} true,\n{b} fitted" for a, b in self.apart],
            [(name, [distances[pair] for pair in self.apart]) for name, distances in bars],
            ENOUGH,
            f"apart after {self.duration:g} s",
            None if path is None else path.at(np.linspace(0.0, path.period, 400)),
            [limit.angle for limit in self.model.motion_limits.values()],
            self.model.joints,
        )

    def _json(self) -> dict[str, Any]:
        return {
            "separable": self.separable, "smallest": self.smallest, "sentence": self.sentence, "rivals": self.rivals,
            "present_seconds": self.present_seconds, "never": self.same, "limits": self.uses, "noise": self.noise,
            "duration": self.duration, "needed": self.needed, "cutoff": self.cutoff, "seed": self.seed,
            "seconds": self.seconds, "apart": _rows(self.apart),
            "present": None if self.present is None else _rows(self.present), "at_random": _rows(self.usual),
            "trajectory": self.trajectory and trajectory_content(self.trajectory, self.model.joint_names),
        }  # fmt: skip


def _rows(distances: Apart) -> list[dict[str, Any]]:
    return [{"truth": a, "rival": b, "sigma": value} for (a, b), value in distances.items()]
