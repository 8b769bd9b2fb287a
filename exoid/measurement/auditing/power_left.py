"""The share of the torques' power that a reading leaves: a rough pendulum is fitted to all recordings, so read.

Something unmeasured may act in part of the time, rather than a channel mean something else. Another reading has to
explain the torques always; a foot that is on the ground, or a hand that pushes, leaves the rest of the time to the
machine as it stands. So both are asked, too, of how little they leave in the part of the time that they explain best
(`left_in_part`): the true one leaves noise there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exoid.ground.non_negative import non_negative
from exoid.ground.thresholds import Threshold
from exoid.measurement.auditing.hypotheses import ConventionHypothesis
from exoid.measurement.auditing.rough import TURNS, Smooth, either_sign, machine_columns, smooth
from exoid.measurement.auditing.trimmed import Windows, joined, trimmed, windows_of
from exoid.measurement.recording import Recording
from exoid.symbolic.force import Force
from exoid.symbolic.joints import Joint, Vector, is_spatial, parents
from exoid.symbolic.motion import Float

QUIET: Threshold = 0.1
"""variation of a torque, of its neighbour's, below which it counts as so much: noise of a light joint would choose the
reading
"""
PASSIVE: Threshold = 0.02
"""the same below which a joint is passive: what is left there would be compared with a torque that is none"""
STANDS: Threshold = 0.01
"""rad, standard deviation below which a joint stands: a lock carries its torque, which speaks for no reading"""
SLOW = 2.0 * TURNS
"""rad/s below which a joint may stick."""
ROUNDING = 1e-13
"""Power of a column, relative to the largest, below which it is rounding."""
STOP = (0.1, 0.9)
"""Quantiles of an angle beyond which something may push back."""
ROWS = 600
"""Samples of all recordings together."""
WINDOW = 0.12
"""s, of a window of the part of the time that is explained best: a swing has several."""


def motions_of(
    recordings: Sequence[Recording], weighs: float | Vector = True, forces: tuple[Force, ...] | None = None
) -> list[Smooth]:
    """Return the smoothed recordings that move and carry torque; `forces` say what they have measured, None the
    usual.
    """
    found = (smooth(recording) for recording in recordings)
    return [replace(motion, weighs=weighs, meant=forces) for motion in found if motion is not None]


def _grouped(motions: Sequence[Smooth]) -> list[list[Smooth]]:
    """Return motions with the same known masses and drives together: each group has numbers of its own."""
    groups: dict[object, list[Smooth]] = {}
    for motion in motions:
        groups.setdefault((motion.payloads, motion.elsewhere), []).append(motion)
    return list(groups.values())


def power_left(motions: Sequence[Smooth], kinds: Sequence[ConventionHypothesis]) -> Float:
    """Return for each reading the share of the torques' power, summed over the joints, that the machine leaves."""
    rows, out = _rows(motions), np.zeros(len(kinds))
    alike: dict[bytes, list[int]] = {}
    for k, kind in enumerate(kinds):
        alike.setdefault(np.array([*kind.map.angle.flat, *kind.map.zero, kind.sums]).tobytes(), []).append(k)
    for places in alike.values():
        sums = [_sums(*part, kinds[places[0]]) for part in rows]
        out[places] = shares_left(sums, np.stack([kinds[k].map.torque for k in places]))
    return out


def quiet_torques(motions: Sequence[Smooth]) -> NDArray[np.bool_]:
    """Mask (J,) of the torques that vary by next to nothing beside their neighbours': they say not whose they are."""
    power = np.sum([m.tau[m.keep].var(axis=0) for m in motions], axis=0)
    return np.asarray(power < QUIET**2 * np.where(_near(motions[0].joints), power, 0.0).max(axis=1))


def _near(joints: Sequence[Joint]) -> NDArray[np.bool_]:
    """Joints (J, J) that are the same or neighbours."""
    near = np.eye(len(joints), dtype=bool)
    for k, above in enumerate(parents(joints)):
        if above is not None:
            near[k, above] = near[above, k] = True
    return near


def _rows(motions: Sequence[Smooth]) -> list[tuple[Smooth, Float, Float]]:
    """A few samples of each group of motions, joined: their motion, the share (K, N) of each in the mean of torque k,
    zero where its joint stands or nothing was measured, and the torques (K, N) around that.
    """
    thin = max(1, sum(len(range(len(m.q))[m.keep]) for m in motions) // ROWS)
    return [_rows_of(group, thin) for group in _grouped(motions)]


def _rows_of(group: Sequence[Smooth], thin: int) -> tuple[Smooth, Float, Float]:
    joints = group[0].joints
    reach, kept, seen = np.array([joint.reach for joint in joints]), [], []
    for motion in group:
        keep = np.arange(len(motion.q))[motion.keep][::thin]
        counts = motion.measured[keep, None] & (motion.q[keep].std(axis=0) > STANDS * reach)
        # Small numbers of the links choose the reading in space, and what sticks would drown them.
        seen.append(counts & (np.abs(motion.dq[keep]) > SLOW * reach) if is_spatial(joints) else counts)
        kept.append(keep)

    def chosen(values: Sequence[Float | None]) -> Any:
        """Rows of all recordings that are kept; None where one recording has no values."""
        pairs = [(value, keep) for value, keep in zip(values, kept, strict=True) if value is not None]
        return np.concatenate([value[keep] for value, keep in pairs]) if len(pairs) == len(kept) else None

    parts = {name: chosen([getattr(motion, name) for motion in group]) for name in ("q", "dq", "ddq", "tau", "base")}
    forces = {name: chosen([motion.forces.get(name) for motion in group]) for name in group[0].forces}
    shared = {name: force for name, force in forces.items() if force is not None}
    known, torques = np.concatenate(seen).T, np.asarray(parts["tau"].T)
    share = known / np.maximum(known.sum(axis=1, keepdims=True), 1)
    torques = (torques - np.sum(torques * share, axis=1, keepdims=True)) * known  # constant offsets are nobody's sign
    return replace(group[0], **parts, forces=shared), share, torques


@dataclass(frozen=True, eq=False)
class Sums:
    """Sums over the samples of recordings in which the joint of torque k moves, all around their means: `gram`
    (K, J, J, P, P) of two joints' columns, or (K, J, P, P) of one's in space, where no reading mixes torques, `slope`
    (K, J, P) of torque k with joint j's columns and `power` (K,) of the torques. `near` (K, K) says which joints are
    neighbours. The first `either` columns may have negative numbers.
    """

    gram: Float
    slope: Float
    power: Float
    near: NDArray[np.bool_]
    either: int = 0


def _sums(motion: Smooth, shares: Float, tau: Float, kind: ConventionHypothesis) -> Sums:
    read = read_so(motion, kind)
    y: Float = np.concatenate([machine_columns(read), _stops(read.q)], axis=2)
    joints, count, size = y.shape
    flat = y.transpose(1, 0, 2).reshape(count, -1)

    def gram(share: Float) -> Float:
        parts = flat - share @ flat
        parts[share == 0.0] = 0.0
        if is_spatial(read.joints):
            alone = parts.reshape(count, joints, size).swapaxes(0, 1)
            return alone.swapaxes(1, 2) @ alone
        return (parts.T @ parts).reshape(joints, size, joints, size).transpose(0, 2, 1, 3)

    different = {share.tobytes(): share for share in shares}  # most often all joints move, and it is one
    made = {key: gram(share) for key, share in different.items()}
    grams = np.array([made[share.tobytes()] for share in shares])
    slope = (tau @ flat).reshape(joints, joints, size)
    return Sums(grams, slope, np.sum(tau**2, axis=1), _near(read.joints), either_sign(read))


def read_so(motion: Smooth, reading: ConventionHypothesis) -> Smooth:
    """The `motion` with its channels read in another way."""
    turn = reading.map.angle.T
    q, tau = reading.map.applied(motion.q, motion.tau)
    return replace(
        motion, q=q, tau=tau, dq=motion.dq @ turn, ddq=motion.ddq @ turn, kept=(*motion.kept, *reading.names)
    )


def _stops(q: Float) -> Float:
    """Return columns (J, K, 2 J) of what pushes back near the ends of each joint's range (stops, tendons, straps):
    without them a machine that runs into its stop would look like one that is read wrongly.
    """
    low, high = np.quantile(q, STOP, axis=0)
    out, each = np.zeros((q.shape[1], len(q), 2 * q.shape[1])), np.arange(q.shape[1])
    out[each, :, 2 * each], out[each, :, 2 * each + 1] = np.maximum(q - high, 0.0).T, np.minimum(q - low, 0.0).T
    return out


def _roots(gram: Float, slope: Float) -> tuple[Float, Float, Float]:
    """Return upper triangular roots (M, P, P), sides (M, P) and sizes (M, P) of columns: of numbers x over these sizes
    |root x - side|² is x·gram·x - 2 x·slope but for a constant.
    """
    square = np.diagonal(gram, axis1=1, axis2=2)
    # Columns that cancel, or of a joint that stands, are zero but for rounding: they are left out.
    size = np.sqrt(np.where(square > ROUNDING * square.max(axis=1, keepdims=True), square, np.inf))
    lower = _factor(gram / (size[:, :, None] * size[:, None, :]) + 1e-10 * np.eye(size.shape[1]))
    side = np.asarray(np.linalg.solve(lower, (slope / size)[:, :, None])[:, :, 0], dtype=float)
    return lower.swapaxes(1, 2), side, size


def some_non_negative(root: Float, side: Float, either: int) -> tuple[Float, float]:
    """Return x (P,) that minimises |root x - side| for an upper triangular root (P, P), none but the first `either` of
    them negative, and that distance.
    """
    rest, left = non_negative(root[either:, either:], side[either:])
    free = np.linalg.solve(root[:either, :either], side[:either] - root[:either, either:] @ rest)
    return np.concatenate([free, rest]), left


def _factor(scaled: Float) -> Float:
    """Return the Cholesky factors of Gram matrices (M, P, P), which rounding may have left slightly indefinite."""
    try:
        return np.asarray(np.linalg.cholesky(scaled), dtype=float)
    except np.linalg.LinAlgError:
        least = np.linalg.eigvalsh(scaled)[:, :1, None]
        lifted = scaled + np.maximum(1e-10 - 2.0 * least, 0.0) * np.eye(scaled.shape[1])
        return np.asarray(np.linalg.cholesky(lifted), dtype=float)


def shares_left(groups: Sequence[Sums], torques: Float) -> Float:
    """Return for each torque map (M, J, J) the share of the power left, each group fitted on its own. What is left
    counts in the torques as they were recorded, so that no reading gains by mixing them.
    """
    power = np.sum([s.power for s in groups], axis=0)
    largest = np.where(groups[0].near, power, 0.0).max(axis=1)
    least = np.where(power < PASSIVE**2 * largest, 1.0, QUIET**2) * largest
    weight = 1.0 / np.maximum(np.maximum(power, least), 1e-24)
    back = np.linalg.inv(torques)
    weighted = weight[:, None] * back
    squares = weighted[:, :, :, None] * back[:, :, None]
    alone = np.diagonal(squares, axis1=2, axis2=3)
    left = np.zeros(len(weighted))
    for s in groups:
        gram = np.tensordot(squares, s.gram, 3) if s.gram.ndim == 5 else np.tensordot(alone, s.gram, 2)
        slope = np.sum(weighted[:, :, :, None] * s.slope, axis=(1, 2))
        roots, sides, _ = _roots(gram, slope)
        # |root x - side|² falls short of the loss by what no x explains.
        left += np.maximum(weight @ s.power - np.sum(sides**2, axis=1), 0.0)
        left += [some_non_negative(*pair, s.either)[1] ** 2 for pair in zip(roots, sides, strict=True)]
    return left


def left_in_part(motions: Sequence[Smooth], reading: ConventionHypothesis) -> float:
    """Return the share of the torques' power that a rough machine leaves in the part of the time that it explains best
    if the channels are read so; NaN where there are too few windows.
    """
    scale = np.sqrt(np.mean([m.tau.var(axis=0) for m in motions], axis=0))
    left, count = 0.0, 0

    def solve(grams: Float, slopes: Float) -> Float:
        roots, sides, sizes = _roots(grams, slopes)
        pairs = zip(roots, sides, strict=True)
        found = [some_non_negative(*pair, len(scale))[0] for pair in pairs]  # offsets of either sign
        return np.array(found) / sizes

    for group in _grouped(motions):
        windows = joined([_windows(motion, reading, scale) for motion in group])
        if (best := trimmed(windows, solve)) is not None:
            left += float(windows.losses(best[0][None])[0, best[1]].sum())
            count += int(best[1].sum())
    return left / count if count else np.nan


def _windows(motion: Smooth, reading: ConventionHypothesis, scale: Float) -> Windows:
    """Return the windows of a motion read in another way, in its own torques: no reading gains by mixing them."""
    rows, back = slice(motion.keep.start, motion.keep.stop), np.linalg.inv(reading.map.torque)
    offsets = np.repeat(np.eye(len(back))[:, None], len(motion.q), axis=1)
    columns = np.concatenate([offsets, machine_columns(read_so(motion, reading))], axis=2)[:, rows]
    columns = np.tensordot(back, columns, 1) / np.maximum(scale, 1e-12)[:, None, None]
    tau = ((motion.tau - motion.tau.mean(axis=0))[rows] / np.maximum(scale, 1e-12)).T
    seen = np.broadcast_to(motion.measured[rows], tau.shape)
    return windows_of(columns, tau, motion.q[rows], motion.dq[rows], seen, max(1, round(WINDOW / motion.step)))
