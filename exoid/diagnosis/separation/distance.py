"""Distance of rival effects on a motion, in standard deviations of the noise, everything else refitted.

One rival is taken for the truth, with its numbers; the other is fitted to the torque that truth makes, together with
all base parameters and every shape parameter:

    D² = min over linear, shape of Σ_j w_j Σ_n (τ_truth - τ_rival)²,   w_j = independent samples per sample / σ_j²

so that D is the distance in units of the noise: the likelihood ratio of the two rises by D² on average. The signals go
through the same filter as recordings do, and samples at which a joint may stick are left out, as in a fit. Signs of
coefficients are not enforced in the refit, which can only make D smaller.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exoid.ground.errors import ExpressionError, NotEnoughDataError
from exoid.ground.plain import AsJson
from exoid.measurement.signals.conditioning import ORDER
from exoid.measurement.trajectories.trajectory import Fourier
from exoid.optimisation.excitation.criteria import Noise
from exoid.optimisation.fitting.assemble import Assembly, settle
from exoid.optimisation.fitting.shapes import from_unit, search_shape
from exoid.optimisation.linear.loss import Bool
from exoid.optimisation.linear.problem import LinearData
from exoid.optimisation.linear.solve import solve_sse
from exoid.optimisation.linear.uncertainty import block_length, block_outer
from exoid.optimisation.preparation.filtering import EDGE, INNER, PreparedRecording, reaches
from exoid.optimisation.preparation.sticking import STICK_REACH, sticking
from exoid.symbolic.joints import LEG, Joint
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

RATE = 100.0
"""Hz at which a designed motion is sampled when it is evaluated."""
SKETCH_SAMPLES = 400
"""Samples of one period while searching."""
SKETCH_NODES = 12
"""Trial values of a rival's shape parameters while searching."""


@dataclass(frozen=True, eq=False)
class Rival(AsJson):
    """A rival with its numbers: `model` holds it, with values `linear` (P,) and `shape` (S,); `source` says whence."""

    name: str
    model: Model
    linear: Float
    shape: Float
    source: str

    @property
    def own(self) -> dict[str, float]:
        """The rival's own numbers."""
        named = [p.name for p in self.model.parameters] + [s.name for s in self.model.shapes]
        values = (*self.linear, *self.shape)
        return {n: float(v) for n, v in zip(named, values, strict=True) if n.startswith(f"{self.name}.")}

    @property
    def sentence(self) -> str:
        """The rival and its own numbers in words."""
        numbers = ", ".join(f"{name.rpartition('.')[2]} = {value:.3g}" for name, value in self.own.items())
        return f"assumed: {self.name} with {numbers} ({self.source})"

    def _json(self) -> dict[str, Any]:
        return {"name": self.name, "numbers": self.own, "source": self.source}


def planned(
    trajectory: Fourier, duration: float, cutoff: float, joints: Sequence[Joint] = LEG, payload: Float | None = None
) -> PreparedRecording:
    """Return a motion, with the limb of a wearer as its `payload`, as if it had been recorded for `duration` s and
    prepared with `cutoff` Hz; its torque is zero.
    """
    t = np.arange(round(duration * RATE)) / RATE
    motion = replace(trajectory.at(t), payload=payload)
    edge = int(np.ceil(EDGE * RATE))
    kept = np.arange(edge, len(t) - edge, max(1, int(RATE // (6.0 * cutoff))))
    if len(kept) < 2:
        raise NotEnoughDataError(f"{duration:g} s of motion is too short", remedy="take at least 5 s of motion")
    reach, none = reaches(joints), np.zeros(len(joints))
    stuck = sticking(motion.dq, reach, int(np.ceil(STICK_REACH * RATE / (INNER * cutoff))))
    return PreparedRecording(
        name="designed",
        motion=motion,
        torque=np.zeros((len(joints), len(kept))),
        used=~stuck[kept].T,
        kept=kept,
        cutoff=cutoff,
        rate=RATE,
        outliers=none,
        wide_tau=np.zeros(motion.q.shape),
        angle_noise=none,
        band=INNER * cutoff,
        stuck=stuck,
        hidden=stuck,
        standing=none > 0.0,
        driven=none == 0.0,
        full_rate=RATE,
        reach=reach,
    )


def residual_noise(
    residual: Float, use: Bool, groups: NDArray[np.int64], rate: float, cutoff: float, joints: Sequence[Joint] = LEG
) -> Noise:
    """Return the noise that a fit's `residual` (J, N) shows, its autocorrelation counted.

    Independent samples per second are those whose mean would scatter as the residual's does (Newey-West over blocks),
    at most 2 × cut-off: a filtered signal has no more.
    """
    sd, per_second = np.empty(len(joints)), np.empty(len(joints))
    for j, live in enumerate(use):
        score, own = residual[j][live][:, None], groups[live]
        longrun = float(block_outer(score, own, block_length(score, own))[0, 0]) / len(score)
        square = float(np.mean(score**2))
        sd[j], per_second[j] = np.sqrt(square), rate * square / max(longrun, 1e-300)
    source = "the residual of the recordings, with its autocorrelation"
    return Noise(sd, np.minimum(per_second, 2.0 * cutoff), source, tuple(joints))


def distance(truth: Rival, rival: Model, prepared: Sequence[PreparedRecording], noise: Noise, start: Float) -> float:
    """Return D of `rival` from `truth` on prepared motions; `start` (S,) are shape values to begin from."""
    made = [recording.smooth(truth.model.torque(recording.motion, truth.linear, truth.shape)) for recording in prepared]
    told = [item.changed(torque=torque) for item, torque in zip(prepared, made, strict=True)]
    assembly, known = Assembly(rival, told), _known(truth, rival)
    root = [np.sqrt(noise.weight / item.kept_rate)[:, None] for item in prepared]
    weights = np.repeat(np.concatenate(root, axis=1), [len(item.kept) for item in prepared], axis=1)

    def weighted(data: LinearData) -> LinearData:
        return replace(data, columns=data.columns * weights[:, :, None], tau=data.tau * weights)

    def loss(shape: Float) -> float:
        try:
            found = settle(assembly, shape if shape.size else None, lambda data: solve_sse(weighted(data)), known)
        except ExpressionError:
            return float("inf")
        return float(np.sum(weighted(found.data).residual(found.linear) ** 2))

    if not rival.shapes:
        return float(np.sqrt(loss(np.zeros(0))))
    return float(np.sqrt(search_shape(loss, [s.shape for s in rival.shapes], nodes(rival, start, 40)).value))


def _known(truth: Rival, rival: Model) -> Float:
    """Return the linear parameters (P,) of `rival` that the truth has too; zero for its own."""
    values = dict(zip((p.name for p in truth.model.parameters), truth.linear, strict=True))
    return np.array([values.get(p.name, 0.0) for p in rival.parameters])


def nodes(model: Model, start: Float, most: int) -> list[Float]:
    """Return about `most` trial values (S,) of a model's shapes: the last term's on a grid, others at `start`."""
    term = model.terms[-1]
    own = {k: entry.shape for k, entry in enumerate(model.shapes) if entry.term == term.name}
    if not own:
        return [start]
    axes: list[Sequence[float]] = []
    each = max(2, round(most ** (1.0 / max(1, sum(not shape.choices for shape in own.values())))))
    for shape in own.values():
        if shape.choices:
            axes.append(shape.choices)
        elif shape.spacing == "position":  # somewhere in the joint's range
            low, high = model.motion_limits[term.name.partition(":")[2]].angle
            axes.append(np.linspace(max(shape.min, low), min(shape.max, high), each).tolist())
        else:
            axes.append([from_unit(shape, u) for u in np.linspace(0.0, 1.0, min(each, max(2, shape.points)))])
    out = np.tile(start, (1 + math.prod(map(len, axes)), 1))
    out[1:, list(own)] = [*itertools.product(*axes)]
    return list(out)


@dataclass(frozen=True, eq=False)
class Distances:
    """Distances of rivals on motions of `duration` s, for each (truth, rival) of `pairs`, in units of the noise.

    By full refits, or cheap and rough for a search: on one period, few samples, shapes on a coarse grid.
    """

    model: Model
    pairs: tuple[tuple[Rival, Rival], ...]
    noise: Noise
    duration: float
    cutoff: float

    @property
    def payload(self) -> Float | None:
        """Payload that the limb of its wearer is for the machine; None without one."""
        return None if self.model.wearer is None else self.model.wearer.added(self.model)

    def motion(self, trajectory: Fourier) -> dict[tuple[str, str], float]:
        """Return D of every pair on a motion."""
        return self.recordings([planned(trajectory, self.duration, self.cutoff, self.model.joints, self.payload)])

    def recordings(self, prepared: Sequence[PreparedRecording]) -> dict[tuple[str, str], float]:
        """Return D of every pair on prepared recordings together."""
        return {(a.name, b.name): distance(a, b.model, prepared, self.noise, b.shape) for a, b in self.pairs}

    def smallest(self, trajectory: Fourier) -> float:
        """Return roughly the smallest D² over the pairs."""
        step = trajectory.period / SKETCH_SAMPLES
        motion = replace(trajectory.at(np.arange(SKETCH_SAMPLES) * step), payload=self.payload)
        stuck = sticking(motion.dq, reaches(self.model.joints), int(np.ceil(STICK_REACH / (self.cutoff * step))))
        weight = np.sqrt(self.noise.weight[:, None] * (self.duration / SKETCH_SAMPLES)) * ~stuck.T
        # What a Butterworth filter run forwards and backwards leaves of a periodic signal, frequency by frequency.
        gain = 1.0 / (1.0 + (np.fft.rfftfreq(SKETCH_SAMPLES, step) / self.cutoff) ** (2 * ORDER))

        def seen(signals: Float) -> Float:
            passed = np.fft.irfft(np.fft.rfft(signals, axis=1) * gain[:, None], SKETCH_SAMPLES, axis=1)
            return np.asarray(passed * weight[:, :, None])

        truths = {truth.name: truth for truth, _ in self.pairs}
        torques = {
            name: seen(truth.model.torque(motion, truth.linear, truth.shape).T[:, :, None]).ravel()
            for name, truth in truths.items()
        }
        best = np.inf
        for truth, rival in self.pairs:
            known = _known(truth, rival.model) if rival.model.needs_reference else None
            for node in nodes(rival.model, rival.shape, SKETCH_NODES):
                try:
                    columns = seen(rival.model.columns(motion, node, known))
                except ExpressionError:
                    continue
                best = min(best, _remainder(columns.reshape(-1, columns.shape[2]), torques[truth.name]))
        return best


def _remainder(matrix: Float, vector: Float) -> float:
    """Return the squared distance of `vector` from the span of the columns of `matrix`."""
    length = np.sqrt(np.einsum("kp,kp->p", matrix, matrix))
    matrix = matrix[:, length > 0.0] / length[length > 0.0]
    gram = matrix.T @ matrix
    gram[np.diag_indices_from(gram)] += 1e-10
    along = matrix.T @ vector
    return max(float(vector @ vector - along @ np.linalg.solve(gram, along)), 0.0)
