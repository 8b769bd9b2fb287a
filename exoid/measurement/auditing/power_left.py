"""The share of the torques' power that a reading leaves: a rough pendulum is fitted to all recordings, so read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from exoid.ground.thresholds import threshold
from exoid.measurement.auditing.hypotheses import ConventionHypothesis
from exoid.measurement.auditing.non_negative import non_negative
from exoid.measurement.auditing.rough import TURNS, Smooth, either_sign, machine_columns, smooth
from exoid.measurement.reading.conventions import combined_map, conventions
from exoid.measurement.recording import Recording
from exoid.symbolic.force import Force
from exoid.symbolic.joints import Joint, Vector, is_spatial, parents
from exoid.symbolic.motion import Float

QUIET = threshold(
    __name__, "QUIET", 0.1,
    "variation of a torque, of its neighbour's, below which it counts as so much: noise of a light joint would "
    "choose the reading",
)  # fmt: skip
PASSIVE = threshold(
    __name__, "PASSIVE", 0.02,
    "the same below which a joint is passive: what is left there would be compared with a torque that is none",
)  # fmt: skip
STANDS = threshold(
    __name__, "STANDS", 0.01,
    "rad, standard deviation below which a joint stands: a lock carries its torque, which speaks for no reading",
)  # fmt: skip
SLOW = 2.0 * TURNS
"""rad/s below which a joint may stick."""
ROUNDING = 1e-13
"""Power of a column, relative to the largest, below which it is rounding."""
STOP = (0.1, 0.9)
"""Quantiles of an angle beyond which something may push back."""
ROWS = 600
"""Samples of all recordings together."""


def smoothed_groups(
    recordings: Sequence[Recording], weighs: float | Vector = True, forces: tuple[Force, ...] | None = None
) -> list[list[Smooth]]:
    """Return the smoothed recordings that move and carry torque, those with the same known masses and drives together;
    `forces` say what they have measured of those, None the usual.
    """
    groups: dict[object, list[Smooth]] = {}
    for recording in recordings:
        motion = smooth(recording)
        reach = [joint.reach for joint in recording.joints]
        if (
            motion is not None
            and np.any(motion.q.std(axis=0) > 0.02 * np.array(reach))
            and np.any(motion.tau.std(axis=0) > 0.0)
        ):
            of = recording.payloads, motion.elsewhere
            groups.setdefault(of, []).append(replace(motion, weighs=weighs, meant=forces))
    return list(groups.values())


def undone(motion: Smooth, names: tuple[str, ...]) -> Smooth:
    """Return `motion` as it was before the conventions `names` were taken into account."""
    to = combined_map(conventions(names, motion.joints), motion.joints)
    back = np.linalg.inv(to.angle).T
    q, tau = to.undone(motion.q, motion.tau)
    return replace(motion, q=q, dq=motion.dq @ back, ddq=motion.ddq @ back, tau=tau, elsewhere=False)


def power_left(sets: Sequence[Sequence[Smooth]], kinds: Sequence[ConventionHypothesis], most: float = np.inf) -> Float:
    """Return for each reading the share of the torques' power, summed over the joints, that the pendulum leaves.

    Of readings that leave more than `most` a lower bound may be returned instead: that of free least squares.
    """
    samples = sum(len(range(m.q.shape[0])[m.keep]) for group in sets for m in group)
    thin = max(1, samples // ROWS)
    thinned = [[_rows(m, thin) for m in group] for group in sets]
    stands = STANDS * np.array([joint.reach for joint in sets[0][0].joints])
    moves = [[m.q[m.keep].std(axis=0) > stands for m in group] for group in sets]
    alike: dict[bytes, list[int]] = {}
    for k, kind in enumerate(kinds):
        alike.setdefault(np.array([*kind.map.angle.flat, *kind.map.zero, kind.sums]).tobytes(), []).append(k)
    out = np.zeros(len(kinds))
    for places in alike.values():
        sums = [_sums(group, moving, kinds[places[0]]) for group, moving in zip(thinned, moves, strict=True)]
        out[places] = _shares(sums, np.stack([kinds[k].map.torque for k in places]), most)
    return out


def quiet_torques(sets: Sequence[Sequence[Smooth]]) -> NDArray[np.bool_]:
    """Return a mask of the torques (J,) that vary by next to nothing beside their neighbours': they say not whose they
    are.
    """
    joints = sets[0][0].joints
    power = np.sum([m.tau[m.keep].var(axis=0) for group in sets for m in group], axis=0)
    return np.asarray(power < QUIET**2 * np.where(_near(joints), power, 0.0).max(axis=1))


def _near(joints: Sequence[Joint]) -> NDArray[np.bool_]:
    """Joints (J, J) that are the same or neighbours."""
    near = np.eye(len(joints), dtype=bool)
    for k, above in enumerate(parents(joints)):
        if above is not None:
            near[k, above] = near[above, k] = True
    return near


def _rows(motion: Smooth, thin: int) -> Smooth:
    keep = np.arange(motion.q.shape[0])[motion.keep][::thin]
    q, dq, ddq, tau = (rows[keep] for rows in (motion.q, motion.dq, motion.ddq, motion.tau))
    forces = {name: values[keep] for name, values in motion.forces.items()}
    base = None if motion.base is None else motion.base[keep]
    seen = motion.measured[keep]
    return replace(motion, q=q, dq=dq, ddq=ddq, tau=tau, base=base, forces=forces, measured=seen)


@dataclass(frozen=True, eq=False)
class _Sums:
    """Sums over the samples of recordings in which the joint of torque k moves: `gram` (K, J, J, P, P) of two joints'
    columns, or (K, J, P, P) of one's in space, where no reading mixes torques, `slope` (J, K, P) of joint j's columns
    with torque k, `power` (K,) of the torques around their means. `near` (K, K) says which joints are neighbours (None:
    all). The first `either` columns may have negative numbers.
    """

    gram: Float
    slope: Float
    power: Float
    near: NDArray[np.bool_] | None = None
    either: int = 0


def _sums(group: Sequence[Smooth], moves: Sequence[np.ndarray], kind: ConventionHypothesis) -> _Sums:
    to = kind.map
    tau = np.concatenate([motion.tau for motion in group])
    counts = np.concatenate([item.measured[:, None] & m for m, item in zip(moves, group, strict=True)])
    apart = is_spatial(group[0].joints)
    if apart:  # small numbers of the links choose the reading there, and what sticks would drown them
        slow = SLOW * np.array([joint.reach for joint in group[0].joints])
        speed = np.abs(np.concatenate([m.dq for m in group]))  # as the file has it: the same samples for all
        counts = counts & (speed > slow)
    mean = np.sum(tau * counts, axis=0) / np.maximum(counts.sum(axis=0), 1)
    tau = (tau - mean) * counts  # constant offsets are nobody's sign
    q, dq, ddq = (np.concatenate(parts) for parts in zip(*((m.q, m.dq, m.ddq) for m in group), strict=True))
    known = [recording.base for recording in group if recording.base is not None]
    base = np.concatenate(known) if len(known) == len(group) else None
    turn = to.angle.T
    shared = [name for name in group[0].forces if all(name in element.forces for element in group)]
    forces = {name: np.concatenate([entry.forces[name] for entry in group]) for name in shared}
    q, dq, ddq, seen = q @ turn + to.zero, dq @ turn, ddq @ turn, np.asarray(counts.any(axis=1))
    elsewhere = kind.sums or group[0].elsewhere
    whole = replace(
        group[0], q=q, dq=dq, ddq=ddq, tau=tau, base=base, forces=forces, measured=seen, elsewhere=elsewhere
    )
    y = np.concatenate([machine_columns(whole), _stops(whole.q)], axis=2)
    flat = y.transpose(1, 0, 2).reshape(len(tau), -1)
    size, count = y.shape[2], tau.shape[1]
    if apart:
        grams = [[part.T @ part for part in y[:, seen]] for seen in counts.T]
    else:
        whole_grams = (part.T @ part for part in (flat[seen] for seen in counts.T))
        grams = [gram.reshape(count, size, count, size).transpose(0, 2, 1, 3) for gram in whole_grams]
    slope = (flat.T @ tau).reshape(count, size, count).transpose(0, 2, 1)
    return _Sums(np.array(grams), slope, np.sum(tau**2, axis=0), _near(whole.joints), either_sign(whole))


def _stops(q: Float) -> Float:
    """Return columns (J, K, 2 J) of what pushes back near the ends of each joint's range: stops, tendons, straps.

    Without them a machine that runs into its stop would look like one that is read wrongly.
    """
    joints = q.shape[1]
    out = np.zeros((joints, len(q), 2 * joints))
    for joint in range(joints):
        low, high = np.quantile(q[:, joint], STOP)
        out[joint, :, 2 * joint] = np.maximum(q[:, joint] - high, 0.0)
        out[joint, :, 2 * joint + 1] = np.minimum(q[:, joint] - low, 0.0)
    return out


def _factor(scaled: Float) -> Float:
    """Return the Cholesky factors of Gram matrices (M, P, P), which rounding may have left slightly indefinite."""
    try:
        return np.asarray(np.linalg.cholesky(scaled), dtype=float)
    except np.linalg.LinAlgError:
        least = np.linalg.eigvalsh(scaled)[:, :1, None]
        lifted = scaled + np.maximum(1e-10 - 2.0 * least, 0.0) * np.eye(scaled.shape[1])
        return np.asarray(np.linalg.cholesky(lifted), dtype=float)


def _shares(groups: Sequence[_Sums], torques: Float, most: float) -> Float:
    """Return for each torque map (M, J, J) the share of the power left, each group fitted on its own.

    What is left counts in the torques as they were recorded, so that no reading gains by mixing them.
    """
    power = np.sum([s.power for s in groups], axis=0)
    near = groups[0].near
    largest = np.full(power.shape, power.max()) if near is None else np.where(near, power, 0.0).max(axis=1)
    least = np.where(power < PASSIVE**2 * largest, 1.0, QUIET**2) * largest
    weight = 1.0 / np.maximum(np.maximum(power, least), 1e-24)
    back = np.linalg.inv(torques)
    squares = np.einsum("k,mkj,mkl->mkjl", weight, back, back)
    alone = np.diagonal(squares, axis1=2, axis2=3)
    ready = []
    bound = np.zeros(len(torques))
    for s in groups:
        gram = np.tensordot(squares, s.gram, 3) if s.gram.ndim == 5 else np.tensordot(alone, s.gram, 2)
        slope = np.tensordot(back * weight[:, None], s.slope.transpose(1, 0, 2), 2)
        square = np.diagonal(gram, axis1=1, axis2=2)
        # Columns that cancel, or of a joint that stands, are zero but for rounding: they are left out.
        size = np.sqrt(np.where(square > ROUNDING * square.max(axis=1, keepdims=True), square, np.inf))
        scaled = gram / (size[:, :, None] * size[:, None, :]) + 1e-10 * np.eye(size.shape[1])
        lower = _factor(scaled)
        side = np.linalg.solve(lower, (slope / size)[:, :, None])[:, :, 0]
        total = float(weight @ s.power)
        ready.append((scaled, slope / size, lower, side, s.either))
        bound += np.maximum(total - np.sum(side**2, axis=1), 0.0)
    for m in np.flatnonzero(bound <= most):
        # |lowerᵀx - side|² falls short of the loss by what no x explains.
        for gram, slope, lower, side, either in ready:
            short = lower[m].T @ non_negative(gram[m], slope[m], either=either) - side[m]
            bound[m] += float(short @ short)
    return bound
