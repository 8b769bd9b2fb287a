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
from collections.abc import Callable, Sequence
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
from exoid.symbolic.motion import Float, Motion

RATE = 100.0
"""Hz at which a designed motion is sampled when it is evaluated."""
SKETCH_SAMPLES = 400
"""Samples of one period while searching."""
SKETCH_NODES = 12
"""Trial values of a rival's shape parameters while searching."""


@dataclass(frozen=True, eq=False)
class Rival(AsJson):
    """A rival with its numbers: `model` holds it, `linear` (P,) and `shape` (S,) are its values, `source` says
    whence.
    """

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
    stuck = _stuck(motion, joints, int(np.ceil(STICK_REACH * RATE / (INNER * cutoff)))).T
    none = np.zeros(len(joints))
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
        reach=reaches(joints),
    )


def _stuck(motion: Motion, joints: Sequence[Joint], near: int) -> Bool:
    """Mask (J, N) of the samples at which each joint may stick, and of `near` samples around them."""
    return sticking(motion.dq, reaches(joints), near).T


def residual_noise(
    residual: Float, use: Bool, groups: NDArray[np.int64], rate: float, cutoff: float, joints: Sequence[Joint] = LEG
) -> Noise:
    """Return the noise that a fit's `residual` (J, N) shows, its autocorrelation counted.

    Independent samples per second are those whose mean would scatter as the residual's does (Newey-West over blocks),
    at most 2 × cut-off: a filtered signal has no more.
    """
    sd, per_second = np.empty(len(joints)), np.empty(len(joints))
    for j in range(len(joints)):
        live = np.asarray(use[j], dtype=bool)
        score = residual[j][live][:, None]
        own = np.asarray(groups)[live]
        sd[j] = float(np.sqrt(np.mean(score**2)))
        longrun = float(block_outer(score, own, block_length(score, own))[0, 0]) / len(score)
        per_second[j] = rate * float(np.mean(score**2)) / max(longrun, 1e-300)
    source = "the residual of the recordings, with its autocorrelation"
    return Noise(sd, np.minimum(per_second, 2.0 * cutoff), source, tuple(joints))


def distance(truth: Rival, rival: Model, prepared: Sequence[PreparedRecording], noise: Noise, start: Float) -> float:
    """Return D of `rival` from `truth` on prepared motions; `start` (S,) are shape values to begin from."""
    made = [recording.smooth(truth.model.torque(recording.motion, truth.linear, truth.shape)) for recording in prepared]
    told = [item.changed(torque=torque) for item, torque in zip(prepared, made, strict=True)]
    assembly = Assembly(rival, told)
    root = [np.sqrt(noise.weight / entry.kept_rate) for entry in prepared]
    weights = np.concatenate(
        [np.tile(w[:, None], (1, len(element.kept))) for w, element in zip(root, prepared, strict=True)], axis=1
    )

    def weighted(data: LinearData) -> LinearData:
        return replace(data, columns=data.columns * weights[:, :, None], tau=data.tau * weights)

    known = _known(truth, rival)

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
    last = model.terms[-1].name
    free = [k for k, s in enumerate(model.shapes) if s.term == last]
    if not free:
        return [start]
    shapes = [model.shapes[k].shape for k in free]
    axes: list[Sequence[float]] = []
    each = max(2, round(most ** (1.0 / max(1, sum(not s.choices for s in shapes)))))
    for place, shape in zip(free, shapes, strict=True):
        if shape.choices:
            axes.append(shape.choices)
        elif shape.spacing == "position":
            axes.append(np.linspace(*_range(model, place), each).tolist())
        else:
            axes.append([from_unit(shape, u) for u in np.linspace(0.0, 1.0, min(each, max(2, shape.points)))])
    out = [start]
    for values in itertools.product(*axes):
        node = start.copy()
        node[free] = values
        out.append(node)
    return out


def _range(model: Model, place: int) -> tuple[float, float]:
    """Ends of the part of a joint's range in which a position may be looked for."""
    entry = model.shapes[place]
    low, high = model.motion_limits[entry.term.partition(":")[2]].angle
    return max(entry.shape.min, low), min(entry.shape.max, high)


@dataclass(frozen=True, eq=False)
class Distances:
    """Distances of `truths` on motions of `duration` s, for each (truth, rival) of `pairs`, in units of the noise.

    By full refits, or cheap and rough for a search: on one period, few samples, shapes on a coarse grid.
    """

    truths: tuple[Rival, ...]
    pairs: tuple[tuple[int, int], ...]
    noise: Noise
    duration: float
    cutoff: float

    @property
    def names(self) -> tuple[tuple[str, str], ...]:
        """The pairs by name."""
        return tuple((self.truths[a].name, self.truths[b].name) for a, b in self.pairs)

    @property
    def joints(self) -> tuple[Joint, ...]:
        """Those of the machine."""
        return self.truths[0].model.joints

    @property
    def payload(self) -> Float | None:
        """Payload that the limb of its wearer is for the machine; None without one."""
        model = self.truths[0].model
        return None if model.wearer is None else model.wearer.added(model)

    def motion(self, trajectory: Fourier) -> dict[tuple[str, str], float]:
        """Return D of every pair on a motion."""
        return self.recordings([planned(trajectory, self.duration, self.cutoff, self.joints, self.payload)])

    def recordings(self, prepared: Sequence[PreparedRecording]) -> dict[tuple[str, str], float]:
        """Return D of every pair on prepared recordings together."""
        rivals = zip(self.names, self.pairs, strict=True)
        ends = ((names, self.truths[a], self.truths[b]) for names, (a, b) in rivals)
        return {names: distance(a, b.model, prepared, self.noise, b.shape) for names, a, b in ends}

    def smallest(self, trajectory: Fourier) -> float:
        """Return roughly the smallest D² over the pairs."""
        step = trajectory.period / SKETCH_SAMPLES
        motion = replace(trajectory.at(np.arange(SKETCH_SAMPLES) * step), payload=self.payload)
        stuck = _stuck(motion, self.joints, int(np.ceil(STICK_REACH / (self.cutoff * step))))
        weight = np.sqrt(self.noise.weight[:, None] * (self.duration / SKETCH_SAMPLES)) * ~stuck
        # What a Butterworth filter run forwards and backwards leaves of a periodic signal, frequency by frequency.
        gain = 1.0 / (1.0 + (np.fft.rfftfreq(SKETCH_SAMPLES, step) / self.cutoff) ** (2 * ORDER))

        def seen(signals: Float) -> Float:
            passed = np.fft.irfft(np.fft.rfft(signals, axis=1) * gain[:, None], SKETCH_SAMPLES, axis=1)
            return np.asarray(passed * weight[:, :, None])

        torques = [
            seen(truth.model.torque(motion, truth.linear, truth.shape).T[:, :, None]).ravel() for truth in self.truths
        ]
        return min(self._gap(motion, torques[a], self.truths[a], self.truths[b], seen) for a, b in self.pairs)

    def _gap(self, motion: Motion, torque: Float, truth: Rival, rival: Rival, seen: Callable[[Float], Float]) -> float:
        model, best = rival.model, np.inf
        known = _known(truth, model) if model.needs_reference else None
        for node in nodes(model, rival.shape, SKETCH_NODES):
            try:
                columns = seen(model.columns(motion, node, known))
            except ExpressionError:
                continue
            matrix = columns.reshape(-1, columns.shape[2])
            best = min(best, _remainder(matrix, torque))
        return best


def _remainder(matrix: Float, vector: Float) -> float:
    """Return the squared distance of `vector` from the span of the columns of `matrix`."""
    length = np.sqrt(np.einsum("kp,kp->p", matrix, matrix))
    matrix = matrix[:, length > 0.0] / length[length > 0.0]
    gram = matrix.T @ matrix
    gram[np.diag_indices_from(gram)] += 1e-10
    along = matrix.T @ vector
    return max(float(vector @ vector - along @ np.linalg.solve(gram, along)), 0.0)
