"""A rough pendulum for the audit: good enough to tell a sign or a swapped channel, not to identify. Of the leg:

    tau1 = a θ1'' + b (θ1'' + θ2'') + c (cos θ2 (2 θ1'' + θ2'') - sin θ2 (2 θ1' θ2' + θ2'²))
           + g1 sin θ1 + g2 sin θ12 + friction
    tau2 = b (θ1'' + θ2'') + c (cos θ2 θ1'' + sin θ2 θ1'²) + g2 sin θ12 + r θ2'' + friction

Inertias (r: of the knee drive's rotor), weights and frictions are free but not negative, so neither thigh length
nor gravity nor the scale of the torque need be known, and a leg turned upside down does not fit (non-negative least
squares). Of any other machine, whose lengths are known, every link's mass, first moment and inertia in the same way;
of one in space what a motion shows of the ten numbers of each link, under the gravity that its model has.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from exoid.measurement.auditing.non_negative import non_negative
from exoid.measurement.forces import usual_forces
from exoid.measurement.reading.angles import running_median
from exoid.measurement.reading.conventions import conventions
from exoid.measurement.recording import Recording
from exoid.measurement.signals.butterworth import both_ways, low_pass_filter
from exoid.measurement.signals.masks import widen
from exoid.symbolic.force import Force
from exoid.symbolic.joints import LEG, Joint, Vector, ancestors, is_leg, is_spatial, parents
from exoid.symbolic.mechanics.base_parameters import base_parameters, pull_of
from exoid.symbolic.mechanics.newton_euler import STILL, BaseMotion, link_torques
from exoid.symbolic.mechanics.pushed import pushed_torques
from exoid.symbolic.mechanics.spatial import link_columns
from exoid.symbolic.model_structure import STANDARD_GRAVITY
from exoid.symbolic.motion import Float

CUTOFF = 5.0
"""Hz. Low on purpose: noise of the second derivative pulls inertias to zero."""
MOST_SECONDS, ROWS = 120.0, 1500
TURNS, SHARPLY = 0.05, 0.005
"""rad/s over which dry friction turns round, as wide as noise and stick make it, and hardly at all."""
HOLE = 5.0
"""Median steps between samples that count as a hole."""


@dataclass(frozen=True, eq=False)
class Smooth:
    """Evenly sampled, smoothed motion: `q`, `dq`, `ddq`, `tau` (K, J) at `step` s; `keep` picks rows for
    fitting. `base` (K, 5) is the angle of a measured base, its two derivatives, its acceleration forwards and upwards.
    `weighs` says whether the machine moves under gravity, of one in space under which (3,) in m/s². `forces` are
    {column: (K,)} of measured ones, `meant` what they are, None for the usual. Drives that may stand `elsewhere` than
    at their joints rub there.
    """

    q: Float
    dq: Float
    ddq: Float
    tau: Float
    step: float
    keep: slice
    base: Float | None = None
    joints: tuple[Joint, ...] = LEG
    weighs: float | Vector = True
    forces: Mapping[str, Float] = field(default_factory=dict)
    meant: tuple[Force, ...] | None = None
    elsewhere: bool = False
    measured: NDArray[np.bool_] = None  # type: ignore[assignment]
    """Samples (K,) at which angles and torques were measured, and not filled in; all where nothing is said."""

    def __post_init__(self) -> None:
        if self.measured is None:
            object.__setattr__(self, "measured", np.ones(len(self.q), dtype=bool))

    @cached_property
    def sums(self) -> tuple[Float, Float, NDArray[np.int_], Float]:
        """The columns (J, K, P) around their means, without offsets, their Gram matrices (J, P, P), the rows (K,), and
        the share of each in the means.
        """
        rows = np.arange(len(self.q))[self.keep]
        seen = self.measured[rows]
        own = columns(self.q[rows], self.dq[rows], self.ddq[rows])[:, :, :OFFSETS]
        parts = np.concatenate([own, pushed_columns(self)[:, rows]], axis=2)
        share = seen / max(1, int(seen.sum()))
        parts = (parts - (share @ parts)[:, None]) * seen[:, None]
        return parts, np.swapaxes(parts, 1, 2) @ parts, rows, share


_SMOOTH: WeakKeyDictionary[Recording, Smooth | None] = WeakKeyDictionary()
"""Of recordings that are still in use: several checks ask for the same one."""


def smooth(recording: Recording) -> Smooth | None:
    """The recording (at most its first two minutes) filtered forwards and backwards; None when too short."""
    if recording not in _SMOOTH:
        _SMOOTH[recording] = _smoothed(recording)
    return _SMOOTH[recording]


def _smoothed(recording: Recording) -> Smooth | None:
    if not len(recording):
        return None
    near = recording.t <= recording.t[0] + MOST_SECONDS
    moved, pulled = (near & valid.all(axis=1) for valid in (recording.angle_valid, recording.torque_valid))
    t = recording.t[moved]
    if np.count_nonzero(moved & pulled) < 100 or t.size < 100 or t[-1] - t[0] < 3.0 or recording.rate < 4 * CUTOFF:
        return None
    step = max(1.0 / recording.rate, 0.005)
    even = np.arange(t[0], t[-1], step)
    pairs = []
    base_motion = () if recording.base is None else ((recording.base, moved),)
    forces = np.column_stack([np.zeros((len(recording), 0)), *recording.forces.values()])
    for pair, valid in ((recording.q, moved), (recording.tau, pulled), (forces, recording.valid), *base_motion):
        if not pair.shape[1]:
            pairs.append(np.zeros((even.size, 0)))
            continue
        # the running median takes out single outliers, which a filter would smear over its whole length
        known = recording.t[valid]
        values = np.column_stack([np.interp(even, known, running_median(column, 7)) for column in pair[valid].T])
        pairs.append(both_ways(low_pass_filter(2, 2.0 * CUTOFF * step), values, 9))
    q, tau, pushing, *others = pairs
    dq = np.gradient(q, step, axis=0)
    base = None
    if others:
        angle = others[0][:, 0]
        rate = np.gradient(angle, step)
        base = np.column_stack([angle, rate, np.gradient(rate, step), others[0][:, 1:]])
    edge = round(0.5 / step)
    thin = max(1, (even.size - 2 * edge) // ROWS)
    measured = _measured(even, recording.t[moved & pulled], 1.0 / recording.rate)
    signals = dict(zip(recording.forces, pushing.T, strict=True))
    return Smooth(
        q, np.asarray(dq), np.asarray(np.gradient(dq, step, axis=0)), tau, step, slice(edge, -edge, thin), base,
        recording.joints, measured=measured, forces=signals,
        elsewhere=any(entry.sums for entry in conventions(recording.conventions, recording.joints)),
    )  # fmt: skip


def _measured(even: Float, t: Float, step: float) -> NDArray[np.bool_]:
    """Return a mask of the samples `even` (K,) that lie within what was measured at `t` s, every `step`, and half a
    period of the cut-off away from holes.
    """
    after = np.clip(np.searchsorted(t, even, side="right"), 1, t.size - 1)
    hole = (t[after] - t[after - 1] > HOLE * step) | (even > t[-1]) | (even < t[0])
    return np.asarray(~widen(hole, round(0.5 / CUTOFF / (even[1] - even[0]))))


def unexplained(
    motion: Smooth, delays: Sequence[float] = (0.0,), factors: Sequence[float] = (1.0, 1.0), most: float = np.inf
) -> Float:
    """Return the share (D, J) of the torque's power that the pendulum leaves when the torque is late by each of
    `delays` (s) and multiplied by `factors` (J,).

    Where even numbers that may be negative leave more than `most`, summed over the joints, it is infinite.
    """
    parts, grams, rows, share = motion.sums
    shift = np.array(delays) / motion.step
    whole = np.floor(shift).astype(int)
    far = int(np.abs(whole).max()) + 1
    torques = np.pad(motion.tau.T, ((0, 0), (far, far)), mode="edge")
    thin = int(rows[1] - rows[0])
    slopes, square = np.empty((whole.size, *grams.shape[:2])), np.empty((whole.size, len(torques)))
    for k, (first, part) in enumerate(zip((rows[0] + far + whole).tolist(), shift - whole, strict=True)):
        place = slice(first, first + (rows.size - 1) * thin + 1, thin)
        after = slice(place.start + 1, place.stop + 1, thin)
        tau = torques[:, place] if part == 0.0 else (1.0 - part) * torques[:, place] + part * torques[:, after]
        tau = tau - (tau @ share)[:, None]  # constant offsets are nobody's sign, so they may have both
        slopes[k] = (tau[:, None] @ parts)[:, 0]
        square[k] = tau**2 @ share
    # Each joint counts alike, whatever its torque.
    scale = np.maximum(np.sqrt(square), 1e-12)
    weight = np.array(factors) * scale
    power = square / scale**2
    slopes /= (scale * weight)[:, :, None]
    slope = slopes.sum(axis=1)
    gram = np.tensordot(1.0 / weight**2, grams, 1)
    out, count = np.full(power.shape, np.inf), max(1, int(np.count_nonzero(share)))
    x = np.zeros(grams.shape[1])
    promising = power.sum(axis=1) - _most_explained(gram, slope) / count <= most
    for k in np.flatnonzero(promising).tolist():
        x = non_negative(gram[k], slope[k], x > 0.0)
        left = x @ grams @ x / weight[k] ** 2 - 2.0 * slopes[k] @ x
        out[k] = np.maximum(power[k] + left / count, 0.0)
    return out


def _most_explained(gram: Float, slope: Float) -> Float:
    """Return slope · gram⁻¹ · slope (D,): of `gram` (D, P, P) what is not rounding."""
    length = np.sqrt(np.maximum(np.diagonal(gram, axis1=1, axis2=2), 1e-300))
    size, axes = np.linalg.eigh(gram / (length[:, :, None] * length[:, None, :]))
    along = np.swapaxes(axes, 1, 2) @ (slope / length)[:, :, None]
    told = size > 1e-12
    return np.asarray(np.sum(np.where(told, along[:, :, 0] ** 2 / np.where(told, size, 1.0), 0.0), axis=1))


OFFSETS = 10
"""Of the columns the first that is an offset."""


def columns(q: Float, dq: Float, ddq: Float) -> Float:
    """Return the columns (J, K, 14) of the pendulum with friction and offsets of either sign."""
    s1, s12 = np.sin(q[:, 0]), np.sin(q[:, 0] + q[:, 1])
    s2, c2 = np.sin(q[:, 1]), np.cos(q[:, 1])
    (v1, v2), (a1, a2) = dq.T, ddq.T
    none, ones = np.zeros_like(s1), np.ones_like(s1)
    hip = [a1, a1 + a2, c2 * (2 * a1 + a2) - s2 * (2 * v1 * v2 + v2**2), s1, s12]
    knee = [none, a1 + a2, c2 * a1 + s2 * v1**2, none, s12]
    soft1, soft2 = np.tanh(v1 / TURNS), np.tanh(v2 / TURNS)
    hip += [none, soft1, v1, none, none, ones, -ones, none, none]
    knee += [a2, none, none, soft2, v2, none, none, ones, -ones]
    return np.stack([np.column_stack(hip), np.column_stack(knee)])


def pushed_columns(motion: Smooth) -> Float:
    """Return the columns (J, K, F) of measured forces: what each does at its link's upper joint, and what per metre
    along the link; neither gain nor place can be negative.
    """
    meant = usual_forces(tuple(motion.forces), motion.joints) if motion.meant is None else motion.meant
    base = STILL if motion.base is None else BaseMotion(*motion.base.T)
    out = []
    for force in meant:
        if not all(name in motion.forces for name in force.columns):
            continue
        signals = force.sign * np.column_stack([motion.forces[name] for name in force.columns])
        origin, unit = (pushed_torques(motion.joints, motion.q, force, at, signals, base) for at in (0.0, 1.0))
        out += [part for part in (origin, unit - origin) if part.any()]
    return np.stack(out, axis=2).swapaxes(0, 1) if out else np.zeros((motion.q.shape[1], len(motion.q), 0))


def machine_columns(motion: Smooth) -> Float:
    """Return the columns (J, K, P) of any machine: links, their weights, rotors, friction, offsets of either sign, and
    measured forces.

    A weight has a number of its own, since the scale of gravity need not be known. Where there is none, and where a
    joint slides, a spring may be all that pulls: moved at one frequency, it would be the mass of a force with the
    other sign. In space, where far less is left, so it is everywhere.
    """
    joints, q, dq, ddq, base = motion.joints, motion.q, motion.dq, motion.ddq, motion.base
    more = [pushed_columns(motion), *([_friction_at_the_base(motion)] if motion.elsewhere else [])]
    if is_leg(joints) and base is None:
        return np.concatenate([columns(q, dq, ddq), *more], axis=2)
    count, spatial = range(len(joints)), is_spatial(joints)
    found = _in_space(motion) if spatial else _in_a_plane(motion, base)
    out = [[row[k] + np.zeros(len(q)) for row in found] for k in count]
    for k, (joint, above) in enumerate(zip(joints, parents(joints), strict=True)):
        own = [np.tanh(dq[:, k] / (width * joint.reach)) for width in (TURNS, SHARPLY)] + [
            dq[:, k],
            np.ones(len(q)),
            -np.ones(len(q)),
        ]
        own += [ddq[:, k]] if above is not None else []
        own += [] if joint.turns and motion.weighs and not spatial else [q[:, k] - q[:, k].mean()]
        for other in count:
            out[other] += [column if other == k else np.zeros(len(q)) for column in own]
    return np.concatenate([np.stack([np.column_stack(row) for row in out]), *more], axis=2)


def _friction_at_the_base(motion: Smooth) -> Float:
    """Return the columns (J, K, F) of the friction of drives that stand on the base, dry and viscous: at the speed of
    each further link against it.
    """
    found = [np.zeros((motion.q.shape[1], len(motion.q), 0))]
    for k, joint in enumerate(motion.joints):
        above = [m for m in ancestors(motion.joints, k) if motion.joints[m].turns == joint.turns]
        if len(above) > 1:
            speed = motion.dq[:, above].sum(axis=1)
            own = np.zeros((motion.q.shape[1], len(motion.q), 2))
            own[above] = np.column_stack([np.tanh(speed / (TURNS * joint.reach)), speed])
            found.append(own)
    return np.concatenate(found, axis=2)


def either_sign(motion: Smooth) -> int:
    """Number of the first `machine_columns` that may have negative numbers: those of links in space."""
    return len(base_parameters(motion.joints, _pull(motion))) if is_spatial(motion.joints) else 0


def _in_a_plane(motion: Smooth, base: Float | None) -> list[Sequence[Any]]:
    """Return the regressors of links and weights of a planar machine, a row per number, an entry (K,) per joint."""
    joints, q, dq, ddq = motion.joints, motion.q, motion.dq, motion.ddq
    still = list(np.zeros_like(q).T)
    links = link_torques(
        joints, 0.0, list(q.T), list(dq.T), list(ddq.T), np, STILL if base is None else BaseMotion(*base.T)
    )
    turned = STILL if base is None else BaseMotion(angle=base[:, 0])
    weights = link_torques(joints, 1.0, list(q.T), still, still, np, turned) if motion.weighs else []
    found: list[Sequence[Any]] = [link[kind] for link in links for kind in ("J", "X", "m")]
    found += [weight[kind] for weight in weights for kind in ("X", "m")]
    # Where a link slides, the zero of its position is anybody's, and its first moment of either sign.
    slides = [k for k, joint in enumerate(joints) if not joint.turns]
    found += [[-x for x in of[k]["X"]] for k in slides for of in (links, weights) if of]
    return found


def _in_space(motion: Smooth) -> list[Sequence[Any]]:
    """Return the same of a spatial machine, of what a motion shows of its links."""
    joints, pull = motion.joints, _pull(motion)
    wanted = [(parameter.link, parameter.kind) for parameter in base_parameters(joints, pull)]
    found = link_columns(joints, pull, list(motion.q.T), list(motion.dq.T), list(motion.ddq.T), np, wanted)
    return list(found)


def _pull(motion: Smooth) -> Vector:
    """Return gravity (3,) as a spatial machine has it where nothing else is said: downwards."""
    return motion.weighs if isinstance(motion.weighs, tuple) else pull_of(STANDARD_GRAVITY if motion.weighs else 0.0)
