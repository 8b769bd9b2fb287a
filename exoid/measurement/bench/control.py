"""The benefit of finding a missing effect: the leg on the bench follows a motion, fed forward by models that know more
or less.

    τ = τ_model(θ_d, θ_d', θ_d'') + kp (θ_d - θ) + kd (θ_d' - θ̂')

The better the model, the less is left to the feedback and the smaller the tracking error (Siciliano and others,
Robotics: Modelling, Planning and Control, 2009, section 8.5). Beside whole models, gravity alone is fed forward.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.ground.figures import figure_style, new_figure
from exoid.ground.frames import pandas
from exoid.ground.html import lines, picture, table
from exoid.ground.plain import AsJson, plain_dict
from exoid.measurement.bench.hidden import Hidden, TrueModel, true_model
from exoid.measurement.bench.leg import Leg
from exoid.measurement.bench.machine import Machine
from exoid.measurement.bench.simulation import Bench, bench_machine, run_bench
from exoid.measurement.trajectories.trajectory import Fourier, random_trajectory
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float, Motion

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NOTHING, GRAVITY, TRUTH = "no model", "gravity of ", "the truth"


@dataclass(frozen=True, eq=False)
class Followed(AsJson):
    """The accuracy with which a controller with one feed-forward follows: `error` (J,) rad RMS of the angles,
    `feedback` (J,) N·m RMS of what is left to the feedback, `effort` (J,) N·m RMS of the whole torque; `t` (N,) s and
    `course` (N, J) rad.
    """

    name: str
    error: Float
    feedback: Float
    effort: Float
    t: Float
    course: Float

    def _json(self) -> dict[str, Any]:
        return {"tracking_rms": self.error, "feedback_rms": self.feedback, "torque_rms": self.effort}


@dataclass(frozen=True, eq=False)
class Tracking:
    """The same motion followed with each feed-forward in turn, the poorest first."""

    joints: tuple[str, ...]
    runs: tuple[Followed, ...]

    def find(self, name: str) -> Followed:
        """Return the run with the feed-forward of that name."""
        return next(run for run in self.runs if run.name == name)

    @property
    def sentence(self) -> str:
        """The gain of the better model, in words."""
        parts = []
        for j, joint in enumerate(self.joints):
            values = ", ".join(f"{1e3 * run.error[j]:.2g} mrad with {run.name}" for run in self.runs)
            parts.append(f"{joint}: {values}")
        return "Tracking error (RMS) on the bench. " + "; ".join(parts) + "."

    def __repr__(self) -> str:
        return self.sentence

    def _rows(self) -> list[tuple[Any, ...]]:
        return [
            (run.name, joint, 1e3 * float(run.error[j]), float(run.feedback[j]), float(run.effort[j]))
            for run in self.runs
            for j, joint in enumerate(self.joints)
        ]

    def _repr_html_(self) -> str:
        return lines(self.sentence) + table(_HEAD, self._rows()) + picture(self.plot(), self.sentence)

    def to_frame(self) -> Any:
        """Return one row per feed-forward and joint."""
        return pandas().DataFrame(self._rows(), columns=list(_HEAD))

    def to_json(self) -> dict[str, Any]:
        """Return everything but the courses in plain types."""
        return plain_dict({run.name: run for run in self.runs})

    def figures(self) -> list[tuple[str, str, Figure]]:
        """Return (title, alternative text, figure)."""
        return [("It pays in control: the tracking error falls with the model's", self.sentence, self.plot())]

    def plot(self) -> Figure:
        """Draw the tracking error over time and, as bars, tracking error and feedback torque (RMS)."""
        with figure_style():
            figure = new_figure(7.0, 5.5)
            axes = figure.subplots(2, len(self.joints), squeeze=False)
            for j, joint in enumerate(self.joints):
                for k, run in enumerate(self.runs):
                    axes[0, j].plot(run.t, 1e3 * run.course[:, j], color=f"C{k}", label=run.name, linewidth=1.0)
                place = np.arange(len(self.runs))
                axes[1, j].bar(place - 0.2, [1e3 * item.error[j] for item in self.runs], 0.4, label="error [mrad]")
                axes[1, j].bar(place + 0.2, [entry.feedback[j] for entry in self.runs], 0.4, label="feedback [N·m]")
                axes[1, j].set_xticks(place, [element.name for element in self.runs], rotation=25, ha="right")
                axes[0, j].set(title=joint, xlabel="time [s]", ylabel="tracking error [mrad]")
                axes[1, j].set(ylabel="RMS")
            axes[0, 0].legend(fontsize="small")
            axes[1, 0].legend(fontsize="small")
        return figure


_HEAD = ("feed-forward", "joint", "tracking error [mrad]", "feedback torque [N·m]", "torque [N·m]")


def track(
    models: Mapping[str, tuple[Model, Float, Float]],
    *,
    leg: Leg | Machine | None = None,
    effects: Iterable[Hidden] = (),
    excitation: Fourier | None = None,
    bench: Bench | None = None,
    seed: int = 0,
) -> Tracking:
    """Let the leg with hidden `effects` follow a motion, fed forward by nothing, by the gravity of the first of
    `models`, by each of them, and by the truth.

    `models` are {name: (model, linear parameters (P,), shapes (S,))}, the poorest first; `excitation` None draws a
    motion from `seed`. BenchError where the leg runs away.
    """
    bench = Bench(duration=20.0) if bench is None else bench
    hidden = tuple(effects)
    first = next(iter(models.values()))[0]
    leg = bench_machine(first.base()) if leg is None else leg
    rng = np.random.default_rng([seed, 7])
    path = random_trajectory(rng, first.motion_limits) if excitation is None else excitation
    known: dict[str, TrueModel | None] = {NOTHING: None}
    for name, (model, linear, shape) in models.items():
        known[name] = TrueModel(model, np.asarray(linear), np.asarray(shape))
    base = first.base()
    known[TRUTH] = true_model(base, leg.base, hidden)
    poorest = next(iter(models))

    def followed(name: str, fed_by: str, still: bool = False) -> Followed:
        """Return the errors in following the motion with the model `fed_by`, or with its gravity alone."""

        def feed_forward(wanted: Motion) -> Float:
            chosen = known[fed_by]
            if chosen is None:
                return np.zeros_like(wanted.q)
            rest = np.zeros_like(wanted.q)
            return chosen.torque(replace(wanted, dq=rest, ddq=rest, sign=rest) if still else wanted)

        made = run_bench(base, leg, effects=hidden, seed=seed, excitation=path, bench=bench, feed_forward=feed_forward)
        wanted = path.at(made.motion.t)
        course = wanted.q - made.motion.q
        left = made.torque - feed_forward(wanted)
        return Followed(name, _rms(course), _rms(left), _rms(made.torque), made.motion.t, course)

    first_two = [followed(NOTHING, NOTHING), followed(GRAVITY + poorest, poorest, still=True)]
    return Tracking(first.joint_names, (*first_two, *(followed(name, name) for name in known if name != NOTHING)))


def _rms(x: Float) -> Float:
    return np.asarray(np.sqrt(np.mean(x**2, axis=0)))
