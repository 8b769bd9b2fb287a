"""A rough machine for the audit: good enough to tell a sign or a swapped channel, not to identify.

Every link's mass, first moment and inertia, the inertias of the drives' rotors, weights and frictions are free but not
negative, so neither the thigh's length nor gravity nor the scale of the torque need be known, and a leg turned upside
down does not fit (non-negative least squares). Of a machine in space it is what a motion shows of the ten numbers of
each link, under the gravity that its model has.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exoid.measurement.forces import usual_forces
from exoid.measurement.reading.angles import running_median
from exoid.measurement.reading.conventions import Convention, conventions
from exoid.measurement.reading.registers import COUNTED
from exoid.measurement.recording import Recording
from exoid.measurement.signals.butterworth import both_ways, low_pass_filter
from exoid.measurement.signals.masks import widen
from exoid.symbolic.force import Force
from exoid.symbolic.joints import LEG, Joint, Vector, ancestors, is_leg, is_spatial, parents
from exoid.symbolic.mechanics.base_parameters import base_parameters, pull_of
from exoid.symbolic.mechanics.newton_euler import STILL, BaseMotion, link_torques
from exoid.symbolic.mechanics.payload import Payload
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
    """Evenly sampled, smoothed motion: `q`, `dq`, `ddq`, `tau` (K, J) at `step` s; `keep` picks rows for fitting, of
    which those that were `measured` (K,) were not filled in. `base` (K, 5) is the angle of a measured base, its two
    derivatives, its acceleration forwards and upwards. `weighs` says whether the machine moves under gravity, of one in
    space under which (3,) in m/s². `forces` are {column: (K,)} of measured ones, `meant` what they are, None for the
    usual, `payloads` known loads, `kept` the conventions in which the file was read, `counted`
    the joints whose angles are counts of an encoder: any other has its zero where somebody put it.
    """

    q: Float
    dq: Float
    ddq: Float
    tau: Float
    step: float
    keep: slice
    measured: NDArray[np.bool_]
    base: Float | None = None
    joints: tuple[Joint, ...] = LEG
    weighs: float | Vector = True
    forces: Mapping[str, Float] = field(default_factory=dict)
    meant: tuple[Force, ...] | None = None
    payloads: tuple[Payload, ...] = ()
    kept: tuple[Convention, ...] = ()
    counted: frozenset[int] = frozenset()

    @property
    def elsewhere(self) -> bool:
        """True if drives may stand elsewhere than at their joints, and rub there."""
        return any(item.sums for item in self.kept)


def smooth(recording: Recording) -> Smooth | None:
    """The recording (at most its first two minutes) filtered forwards and backwards; None when too short, or where no
    joint moves or no torque changes.
    """
    if not len(recording):
        return None
    near = recording.t <= recording.t[0] + MOST_SECONDS
    moved, pulled = (near & valid.all(axis=1) for valid in (recording.angle_valid, recording.torque_valid))
    t = recording.t[moved]
    if np.count_nonzero(moved & pulled) < 100 or t.size < 100 or t[-1] - t[0] < 3.0 or recording.rate < 4 * CUTOFF:
        return None
    step = max(1.0 / recording.rate, 0.005)
    even = np.arange(t[0], t[-1], step)

    def filtered(values: Float, valid: NDArray[np.bool_]) -> Float:
        # The running median takes out single outliers, which a filter would smear over its whole length.
        known = recording.t[valid]
        whole = [np.interp(even, known, running_median(column, 7)) for column in values[valid].T]
        return both_ways(low_pass_filter(2, 2.0 * CUTOFF * step), np.column_stack(whole), 9)

    q, tau = filtered(recording.q, moved), filtered(recording.tau, pulled)
    reach = np.array([joint.reach for joint in recording.joints])
    if not (np.any(q.std(axis=0) > 0.02 * reach) and np.any(tau.std(axis=0) > 0.0)):
        return None
    dq = np.gradient(q, step, axis=0)
    base = None if recording.base is None else filtered(recording.base, moved)
    if base is not None:
        rate = np.gradient(base[:, 0], step)
        base = np.column_stack([base[:, 0], rate, np.gradient(rate, step), base[:, 1:]])
    edge = round(0.5 / step)
    thin = max(1, (even.size - 2 * edge) // ROWS)
    seen = recording.t[moved & pulled]
    after = np.clip(np.searchsorted(seen, even, side="right"), 1, seen.size - 1)
    hole = (seen[after] - seen[after - 1] > HOLE / recording.rate) | (even > seen[-1]) | (even < seen[0])
    measured = np.asarray(~widen(hole, round(0.5 / CUTOFF / (even[1] - even[0]))))  # half a period away from holes
    noted = {finding.check for finding in recording.findings if not recording.conventions}
    signals = {name: filtered(force[:, None], recording.valid)[:, 0] for name, force in recording.forces.items()}
    return Smooth(
        q, np.asarray(dq), np.asarray(np.gradient(dq, step, axis=0)), tau, step, slice(edge, -edge, thin), measured,
        base, recording.joints, forces=signals, payloads=recording.payloads,
        kept=conventions(recording.conventions, recording.joints),
        counted=frozenset(k for k in range(q.shape[1]) if COUNTED.format(f"q{k + 1}") in noted),
    )  # fmt: skip


def machine_columns(motion: Smooth) -> Float:
    """Return the columns (J, K, P) of a machine: links, their weights, friction, rotors, and measured forces.

    A weight has a number of its own, since the scale of gravity need not be known. Where there is none, and where a
    joint slides, a spring may be all that pulls: moved at one frequency, it would be the mass of a force with the
    other sign. In space, where far less is left, so it is everywhere. Drives that stand on the base rub at the speed of
    each further link against it.
    """
    joints, q, dq, spatial = motion.joints, motion.q, motion.dq, is_spatial(motion.joints)
    links: Sequence[Sequence[Any]]
    if spatial:  # what a motion shows of its links
        wanted = [(parameter.link, parameter.kind) for parameter in base_parameters(joints, _pull(motion))]
        links = link_columns(joints, _pull(motion), list(q.T), list(dq.T), list(motion.ddq.T), np, wanted)
    else:
        links = _in_a_plane(motion)
    columns: list[dict[int, Any]] = [dict(enumerate(row)) for row in links]
    widths = (TURNS,) if is_leg(joints) and motion.base is None else (TURNS, SHARPLY)
    for k, (joint, above) in enumerate(zip(joints, parents(joints), strict=True)):
        columns += [{k: np.tanh(dq[:, k] / (width * joint.reach))} for width in widths] + [{k: dq[:, k]}]
        columns += [{k: motion.ddq[:, k]}] if above is not None else []
        columns += [] if joint.turns and motion.weighs and not spatial else [{k: q[:, k] - q[:, k].mean()}]
    for k, joint in enumerate(joints if motion.elsewhere else ()):
        along = [m for m in ancestors(joints, k) if joints[m].turns == joint.turns]
        if len(along) > 1:
            speed = dq[:, along].sum(axis=1)
            columns += [dict.fromkeys(along, np.tanh(speed / (TURNS * joint.reach))), dict.fromkeys(along, speed)]
    columns += [dict(enumerate(part.T)) for part in _pushed(motion)]
    found = np.zeros((len(joints), len(q), len(columns)))
    for number, column in enumerate(columns):
        for k, values in column.items():
            found[k, :, number] = values
    return found


def _pushed(motion: Smooth) -> Iterator[Float]:
    """Yield the torques (K, J) of measured forces: what each does at its link's upper joint, and what per metre along
    the link; neither gain nor place can be negative.
    """
    meant = usual_forces(tuple(motion.forces), motion.joints) if motion.meant is None else motion.meant
    base = STILL if motion.base is None else BaseMotion(*motion.base.T)
    for force in meant:
        if all(name in motion.forces for name in force.columns):
            signals = force.sign * np.column_stack([motion.forces[name] for name in force.columns])
            origin, unit = (pushed_torques(motion.joints, motion.q, force, at, signals, base) for at in (0.0, 1.0))
            yield from (part for part in (origin, unit - origin) if part.any())


def either_sign(motion: Smooth) -> int:
    """Number of the first `machine_columns` that may have negative numbers: those of links in space."""
    return len(base_parameters(motion.joints, _pull(motion))) if is_spatial(motion.joints) else 0


def _in_a_plane(motion: Smooth) -> list[Sequence[Any]]:
    """Return the regressors of links and weights of a planar machine, a row per number, an entry (K,) per joint."""
    joints, q, dq, ddq = motion.joints, motion.q, motion.dq, motion.ddq
    base = STILL if motion.base is None else BaseMotion(*motion.base.T)
    still = [0.0] * len(joints)
    links = link_torques(joints, 0.0, list(q.T), list(dq.T), list(ddq.T), np, base)
    weights = link_torques(joints, 1.0, list(q.T), still, still, np, BaseMotion(base.angle)) if motion.weighs else []
    # The mass of a link that turns on another one is as good as one at the end of that.
    massive = [not joint.turns or above is None for joint, above in zip(joints, parents(joints), strict=True)]
    kinds = [links, weights] if motion.weighs else [links]
    found: list[Sequence[Any]] = [link[kind] for link in links for kind in ("J", "X")]
    found += [weight["X"] for weight in weights]
    found += [of[k]["m"] for of in kinds for k in np.flatnonzero(massive)]
    # Where a link slides, the zero of its position is anybody's, and its first moment of either sign.
    slides = [k for k, joint in enumerate(joints) if not joint.turns]
    return found + [[-x for x in of[k]["X"]] for k in slides for of in kinds]


def _pull(motion: Smooth) -> Vector:
    """Return gravity (3,) as a spatial machine has it where nothing else is said: downwards."""
    return motion.weighs if isinstance(motion.weighs, tuple) else pull_of(STANDARD_GRAVITY if motion.weighs else 0.0)
