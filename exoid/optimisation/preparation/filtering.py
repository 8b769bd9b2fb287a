"""One recording made ready for a fit: filtered angles and their derivatives, torque without outliers, what may be used.

Angles are low-passed at twice the common cut-off, torque and model through one common filter afterwards. What must not
count is hidden first: samples at which a joint may be sticking, spikes, torques that are missing, and all torques where
an angle is. Hiding them and filtering is one linear operator, and everything goes through it alike: the measured
torque, the model's, and every column of a regressor. With L = F B (bridges across hidden samples B, low-pass F) and
torque = Y φ + noise,

    L torque - (L Y) φ = L noise,

whichever samples are hidden, rightly or wrongly: a true model leaves filtered noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from exoid.ground.thresholds import Threshold
from exoid.measurement.auditing.channels import NOTHING
from exoid.measurement.logged import Logged
from exoid.measurement.signals.bridging import Bridge, bridging
from exoid.measurement.signals.butterworth import WaveProducts
from exoid.measurement.signals.conditioning import (
    UniformSignals,
    derivatives,
    low_pass,
    low_pass_at,
    low_pass_every,
    middle_range,
    noise_density,
    quiet_noise,
    velocity_noise,
    wave_products,
)
from exoid.measurement.signals.derivatives import METHODS
from exoid.measurement.signals.masks import straight_columns, widen
from exoid.measurement.signals.methods import BUTTERWORTH
from exoid.measurement.signals.spikes import spikes_beside
from exoid.optimisation.linear.loss import Bool
from exoid.optimisation.preparation.sticking import (
    DIRECTION,
    STICK,
    STICK_REACH,
    Direction,
    around_reversals,
    sign_width,
    sticking,
)
from exoid.optimisation.preparation.strides import StrideCut, cut_into_strides
from exoid.symbolic.columns import forces_torque
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float, Motion
from exoid.symbolic.waves import Waves

WORKING_RATE = 100.0
"""Regressors are evaluated at about this rate, Hz (more only for high cut-offs): faster logging is averaged."""
USED = 0.5
"""Part of what the common filter takes that must have been measured; the rest lies on bridges."""
INNER = 2.0
"""Cut-off of the angles over the common one. Angles smoothed at the common cut-off would be smoothed twice (the model's
torque is filtered after them), the torque only once: near the cut-off a model then looks too smooth, as if the drive
were flexible. What noise the wider band lets in, the common filter takes out again."""
LOADED: Threshold = 3.0
"""times the sensor's noise by which the torque of a joint varies that has a drive: noise fitted as torque"""
DECILES = 2.5631
"""Standard deviations between the first and the last decile of noise."""
HELD, SWAY = 0.02, 1.0
"""rad and Hz. A joint whose angle, below the second, has less range than the first, stays where it is: what its encoder
shows is noise. One that moves further but never faster than `STICK` creeps."""
EDGE = 0.5
"""Seconds cut at both ends, where a zero-phase filter is not settled."""


@dataclass(frozen=True, eq=False)
class TorqueRead:
    """The torques of a recording before spikes are hidden: `tau` (N, J) at the working samples, which of them are
    `missing` (N, J), what may be `fitted` (J, K) of the kept ones, and the spikes `brief` (M, J) that were taken out of
    faster samples before these were averaged.
    """

    tau: Float
    missing: Bool
    fitted: Bool
    brief: Bool


@dataclass(frozen=True, eq=False)
class PreparedRecording:
    """A recording ready to be fitted: `motion` at N working samples, `torque` and `used` (J, K) at the K kept ones.

    `kept` (K,) are indices into the working samples, `outliers` (J,) the share of torque samples that are spikes,
    `wide_tau` (N, J) the torque without them and not low-passed, `angle_noise` (J,) rad²/Hz the density of the
    encoders' noise and `band` in Hz what the angles contain of it. `stuck` (N, J) are working samples at which a joint
    may be sticking, `hidden` (N, J) all that are bridged. `standing` (J,) are joints that never move enough to be free
    of dry friction: what a brake, a lock or that friction carries of their load nobody knows, and their torque is not
    fitted. `driven` (J,) are joints with a drive: the torque of the others is zero for certain. `full_rate` in Hz is
    that of the recording, `reach` (J,) what of its own unit each joint moves where a turning one moves 1 rad.
    """

    name: str
    motion: Motion
    torque: Float
    used: Bool
    kept: np.ndarray
    cutoff: float
    rate: float
    outliers: Float
    wide_tau: Float
    angle_noise: Float
    band: float
    stuck: Bool
    hidden: Bool
    standing: Bool
    driven: Bool
    full_rate: float
    reach: Float
    pushed: Float | None = field(default=None, kw_only=True)
    """What measured forces ask of the drives (N, J) at about the right numbers; None where nobody knows."""
    read: TorqueRead | None = field(default=None, kw_only=True)
    """The torques before spikes were hidden; None where there never were any."""
    direction: Direction | None = field(default=None, kw_only=True)
    """What the direction of motion is taken from; None: the velocities themselves."""
    stances: Float | None = field(default=None, kw_only=True)
    """When (S, 2) in s a foot came down and left the ground, where that was measured."""
    logged: Mapping[str, Logged] = field(default_factory=dict, kw_only=True)
    """Further columns that say in what state the machine was."""

    def beside(self, known: Float) -> PreparedRecording:
        """Return the recording with its spikes judged anew, beside the torque `known` (N, J) of a model."""
        if self.read is None:
            return self
        averaged = self.read.brief.size > 0
        return self.without(spikes_beside(self.read.tau, known, self.rate, self.read.missing, averaged=averaged))

    def beside_own(self, known: Float) -> PreparedRecording:
        """Return the recording without a torque `known` (N, J) N·m that belongs to it alone and to no model."""
        read = None if self.read is None else replace(self.read, tau=self.read.tau - known)
        return self.changed(torque=self.torque - self.smooth(known), wide_tau=self.wide_tau - known, read=read)

    def carrying(self, load: Float) -> PreparedRecording:
        """Return the recording with a torque `load` (N, J) N·m that friction feels beside the model's own."""
        return self.changed(motion=replace(self.motion, load=load)) if load.any() else self

    def at_times(self, t: Float) -> PreparedRecording:
        """Return the recording with the motion that it has at other times `t` (N,) in s: those of its torques, which
        whoever wrote them to the times of the angles may have interpolated where friction jumps. Of torques before or
        after the motion nothing is known.
        """
        beyond = ((t < self.motion.t[0]) | (t > self.motion.t[-1]))[:, None]
        motion, stuck, told = replace(self.at(t), t=self.motion.t), self.stuck[self.sample_at(t)], self.direction
        turning = told and replace(told, velocity=told.velocity[self.sample_at(t)])
        moved = replace(self, motion=motion, stuck=stuck, hidden=self.hidden | stuck | beyond, direction=turning)
        if self.read is None:
            return moved
        fitted = ~stuck[self.kept].T & ~self.standing[:, None]
        missing = self.read.missing | beyond | (around_reversals(motion.dq) & ~self.standing)
        return replace(moved, read=replace(self.read, fitted=fitted, missing=missing)).without(self.spikes)

    def shown_later(self, delays: Sequence[tuple[int, float]]) -> PreparedRecording:
        """Return the recording with moments in which a joint may be sticking hidden, too, where its torque shows them
        that comes so late: `delays` are (joint, s). Itself where nothing more is hidden.
        """
        stuck = self.stuck.copy()
        for joint, seconds in delays:
            stuck[:, joint] |= self.stuck[self.sample_at(self.motion.t - seconds), joint]
        if self.read is None or np.array_equal(stuck, self.stuck):
            return self
        read = replace(self.read, fitted=self.read.fitted & ~stuck[self.kept].T)
        return replace(self, stuck=stuck, read=read).without(self.spikes & ~stuck)

    def sample_at(self, t: Float) -> np.ndarray:
        """Return the working sample (M,) at each of the times `t` (M,) in s, or the next one."""
        return np.searchsorted(self.motion.t, t).clip(0, len(self.motion) - 1)

    def at(self, t: Float) -> Motion:
        """Return the motion at other times `t` (M,) in s, beyond its own as at its ends: which way a joint moves is
        asked of its velocity then, since between samples of that a step is none.
        """
        signals, path = self._path
        inside = np.clip(t, self.motion.t[0], self.motion.t[-1])
        ends = np.cumsum([x.shape[1] for x in signals.values()])
        then = dict(zip(signals, np.split(path(inside), ends[:-1], axis=1), strict=True))
        band = self.direction.band if self.direction else self.band
        turning = np.tanh(then.pop("velocity") / sign_width(self.angle_noise, band, self.reach))
        return replace(self.motion, t=t, sign=np.where(self.standing, 0.0, turning), **then)

    @cached_property
    def _path(self) -> tuple[dict[str, Float], Any]:
        """The signals of the motion, {name: (N, S)}, and a spline of all of them."""
        from scipy.interpolate import CubicSpline

        names = ("q", "dq", "ddq", "base", "force", "load")
        signals = {name: x for name in names if (x := getattr(self.motion, name)) is not None}
        signals["velocity"] = self.direction.velocity if self.direction else self.motion.dq
        return signals, CubicSpline(self.motion.t, np.concatenate([*signals.values()], axis=1))

    def changed(self, **values: Any) -> PreparedRecording:
        """Return the recording with other values of its fields, the same samples hidden: their bridges are kept."""
        new = replace(self, **values)
        vars(new)["_bridges"] = self._bridges
        return new

    def with_spikes(self, spikes: Bool) -> PreparedRecording:
        """Return the recording with the samples `spikes` (N, J) hidden in place of its own; itself where it was cut."""
        return self if self.read is None else self.without(spikes)

    def lacking(self, unknown: Bool) -> PreparedRecording:
        """Return the recording with samples `unknown` (N,) hidden at all joints; itself where it was cut."""
        if self.read is None:
            return self
        missing = self.read.missing | unknown[:, None]
        return replace(self, read=replace(self.read, missing=missing)).without(self.spikes)

    @property
    def lost(self) -> Bool:
        """Working samples (N, J) that are hidden whether or not they are spikes."""
        return self.stuck if self.read is None else self.stuck | self.read.missing

    @property
    def spikes(self) -> Bool:
        """Working samples (N, J) that are hidden as spikes."""
        return np.asarray(self.hidden & ~self.lost)

    def times_of_spikes(self, joint: int) -> Float:
        """Times (S,) in s at which torques of a joint (index) are hidden as spikes, in order."""
        times = [self.motion.t[self.spikes[:, joint]]]
        if self.read is not None and self.read.brief.size:
            times.append(self.motion.t[0] + np.flatnonzero(self.read.brief[:, joint]) / self.full_rate)
        return np.sort(np.concatenate(times))

    def without(self, bad: Bool) -> PreparedRecording:
        """Return the recording with the samples `bad` (N, J), spikes, hidden beside those that do not count anyhow."""
        assert self.read is not None
        tau, missing = self.read.tau, self.read.missing
        wide = straight_columns(tau, bad | missing)
        outliers = (bad & ~self.lost).mean(axis=0)
        if self.read.brief.size:
            outliers += self.read.brief.mean(axis=0)
        new = replace(self, hidden=self.lost | bad, wide_tau=wide, outliers=outliers)
        rows = np.concatenate([new.bridged(np.array(tau.T, order="C")), new.hidden.T])
        smooth = low_pass_at(rows, self.cutoff, self.rate, self.kept)
        torque, bridged = smooth[: tau.shape[1]], smooth[tau.shape[1] :]
        return replace(new, torque=np.ascontiguousarray(torque), used=self.read.fitted & (bridged < USED))

    def noisier(self, rng: np.random.Generator) -> PreparedRecording:
        """Return the recording as it would be if its encoders and force sensors had added their noise once more (SIMEX,
        Cook, Stefanski 1994): what a model gains by that, it had gained from noise.
        """
        deviation = np.sqrt(0.5 * self.rate * self.angle_noise)
        white = rng.standard_normal(self.motion.q.shape) * deviation
        added = low_pass(white, self.band, self.rate)
        dq, ddq = derivatives(added, self.rate)
        dq, ddq = np.where(self.standing, 0.0, dq), np.where(self.standing, 0.0, ddq)
        old = self.motion
        told = self.direction or Direction(old.dq, self.band)
        faster = derivatives(low_pass(white, told.band, self.rate), self.rate)[0] if self.direction else dq
        width = sign_width(2.0 * self.angle_noise, told.band, self.reach)
        sign = np.where(self.standing, 0.0, np.tanh((told.velocity + faster) / width))
        force = None if old.force is None else self._noisier_force(old.force, rng)
        motion = replace(old, q=old.q + added, dq=old.dq + dq, ddq=old.ddq + ddq, sign=sign, force=force)
        return self.changed(motion=motion)

    def _noisier_force(self, force: Float, rng: np.random.Generator) -> Float:
        """Return measured forces (N, C) with noise of the size that the top of their spectrum shows."""
        size = quiet_noise(force, self.rate, 0.5 * self.rate, factor=max(1, round(self.full_rate / self.rate)))
        return np.asarray(force + size * rng.standard_normal(force.shape))

    def smooth(self, x: Float) -> Float:
        """Bridge and filter torques `x` (N, J) exactly as the measured one was; return the kept samples (J, K)."""
        return self.smooth_columns(x.T[:, :, None])[:, :, 0]

    def smooth_columns(self, x: Float, joints: Sequence[int] | None = None) -> Float:
        """Do the same to columns (A, N, P) of `joints`, all where none are given, and return (A, K, P)."""
        rows = np.array(x.transpose(0, 2, 1), dtype=float, order="C")
        smooth = self.smooth_rows(rows, range(len(x)) if joints is None else joints, 0)
        return np.ascontiguousarray(smooth.transpose(0, 2, 1))

    def smooth_rows(self, x: Float, joints: Sequence[int], axis: int, out: Float | None = None) -> Float:
        """Do the same to `x` (..., N), which is bridged in place, and return (..., K), in `out` where that is given."""
        self.bridged(x, joints, axis)
        out = np.empty((*x.shape[:-1], len(self.kept))) if out is None else out
        low_pass_at(x.reshape(-1, x.shape[-1]), self.cutoff, self.rate, self.kept, out.reshape(-1, len(self.kept)))
        return out

    def bridged(self, x: Float, joints: Sequence[int] | None = None, axis: int = 0) -> Float:
        """Bridge the hidden samples of `x` (..., N) in place and return it; along `axis` lie `joints`, or all."""
        ahead: tuple[slice | int, ...] = (slice(None),) * axis
        for place, joint in enumerate(range(x.shape[axis]) if joints is None else joints):
            self._bridges[joint].across(x[(*ahead, place)])
        return x

    def wave_products(
        self, waves: Waves, shapes: Float, joints: Sequence[int], weights: Float, signals: Float
    ) -> WaveProducts | None:
        """Return the products of `waves` at `shapes` (V, S), bridged and filtered so, with `weights` (U, A, K) and
        weighted `signals` (S, A, K, Q); None where that cannot be done.
        """
        across = [self._bridges[joint] for joint in joints]
        return wave_products(waves, shapes, across, self.cutoff, self.rate, self.kept, weights, signals)

    @cached_property
    def _bridges(self) -> list[Bridge]:
        """For each joint what bridges its hidden samples."""
        return [bridging(column, self.rate) for column in self.hidden.T]

    @cached_property
    def strides(self) -> StrideCut | None:
        """The strides of its motion at the kept samples; None where it has none."""
        return cut_into_strides(self.motion.q[self.kept], self.t, self.stances, self.reach)

    def starts(self, seconds: float) -> np.ndarray:
        """Return the kept samples at which blocks begin that are compared with one another: its strides, or stretches
        of about so many `seconds` where it has none.
        """
        return self.starts_within(seconds, 0, len(self.kept))

    def starts_within(self, seconds: float, first: int, last: int) -> np.ndarray:
        """Return the same of the part from its kept sample `first` to before `last`, counted from there.

        Stretches are as long as each other: losses of a short and a long one differ whatever a model does.
        """
        if self.strides is not None:
            starts = self.strides.starts(len(self.kept))
            return np.array([0, *(starts[(starts > first) & (starts < last)] - first)])
        count = max(1, round((last - first) / (seconds * self.kept_rate)))
        return np.arange(count) * (last - first) // count

    def parts(self, count: int) -> np.ndarray:
        """Return of every kept sample (K,) in which of `count` about equal parts it is, of whole strides where its
        motion has them: fewer where these are few.
        """
        samples = len(self.kept)
        ends = -(-np.arange(1, count) * samples // count)
        if count > 1 and self.strides is not None:
            starts = self.strides.starts(samples)[1:]
            ends = np.unique(starts[np.abs(starts[:, None] - ends).argmin(axis=0)])
        return np.searchsorted(ends, np.arange(samples), side="right")

    @property
    def t(self) -> Float:
        """Time of the kept samples (K,), s."""
        return np.asarray(self.motion.t[self.kept])

    @property
    def kept_rate(self) -> float:
        """Rate of the kept samples, Hz."""
        return 1.0 / float(self.t[1] - self.t[0])


def driven_joints(recordings: Sequence[PreparedRecording]) -> Bool:
    """Mask (J,) of the joints that have a drive in some recording: the torque of the others is zero for certain."""
    return np.asarray(np.any([recording.driven for recording in recordings], axis=0))


def prepare_one(
    base: Model,
    name: str,
    even: UniformSignals,
    cutoff: float,
    beta: Float | None,
    reach: float = np.inf,
    derivative: str = BUTTERWORTH,
) -> PreparedRecording:
    """Prepare one recording; without `beta` (P,) spikes are found in the torque alone, with it beside `base` too.

    Around samples that may stick, as much is left out as a cut-off of `reach` Hz would ask for, if that is lower.
    """
    factor = max(1, int(even.rate // max(WORKING_RATE, 12.0 * cutoff)))
    tau = even.slower_torque(factor)
    rate = even.rate / factor
    inner = min(INNER * cutoff, 0.4 * even.rate)
    q, dq, ddq, noise = _smoothed(even, inner, factor, derivative, name)
    loads = [p.added(base) for p in (*even.payloads, *((base.wearer,) if base.wearer else ()))]
    payload = np.sum(loads, axis=0) if loads else None
    reach_of = reaches(base.joints)
    near = int(np.ceil(STICK_REACH * rate / min(inner, INNER * reach)))
    told = _direction(even, inner, noise / reach_of**2, factor, derivative, name) or Direction(dq, inner)
    stuck = sticking(told.velocity, reach_of, near)
    held = _held_still(q / reach_of, dq / reach_of, rate, velocity_noise(noise, inner) / reach_of)
    standing = stuck.all(axis=0) | held
    stuck = stuck & ~standing
    turned = around_reversals(told.velocity) & ~standing if factor > 1 else np.zeros(stuck.shape, dtype=bool)
    # A joint that stands has no direction of motion, and what its encoder's noise would give is none.
    sign = np.where(standing, 0.0, np.tanh(told.velocity / sign_width(noise, told.band, reach_of)))
    dq, ddq = np.where(held, 0.0, dq), np.where(held, 0.0, ddq)
    swaying = _base_motion(even, inner, factor, rate) if base.moving_base else None
    motion = Motion(even.t[::factor][: len(q)], q, dq, ddq, sign, payload, swaying, even.slower_force(factor))
    gap = widen(even.gap[::factor][: len(q)], int(np.ceil(0.5 * rate / inner)))
    missing = gap[:, None] | even.slower_gap(factor) | turned
    edge = int(np.ceil(EDGE * rate))
    kept = np.arange(edge, len(q) - edge, max(1, int(rate // (6.0 * cutoff))))
    brief = even.spikes[: 0 if factor == 1 else None]
    recording = PreparedRecording(
        name=name,
        motion=motion,
        torque=np.empty((0, 0)),
        used=np.empty((0, 0), dtype=bool),
        kept=kept,
        cutoff=cutoff,
        rate=rate,
        outliers=np.zeros(tau.shape[1]),
        wide_tau=tau,
        angle_noise=noise,
        band=min(inner, 0.4 * rate),
        stuck=stuck,
        hidden=stuck,
        standing=standing,
        driven=~(even.passive | _reads_nothing(even, cutoff)),
        full_rate=even.rate,
        reach=reach_of,
        pushed=None if beta is None or not base.forces else forces_torque(base, motion, beta),
        read=TorqueRead(tau, missing, ~stuck[kept].T & ~standing[:, None], brief),
        direction=told,
        stances=even.stances,
        logged=even.logged,
    )
    if beta is None:
        return recording.without(_spikes(even, factor))
    return recording.without(even.slower_spikes(factor, lambda: base.torque(motion, beta), missing))


def _spikes(even: UniformSignals, factor: int) -> Bool:
    """Return the spikes (N, J) that show without a model; slower torques are without them already."""
    return even.spikes if factor == 1 else np.zeros(even.slower_torque(factor).shape, dtype=bool)


def _smoothed(
    even: UniformSignals, inner: float, factor: int, derivative: str, name: str
) -> tuple[Float, Float, Float, Float]:
    """Return angles below `inner` Hz and their derivatives (N, J), every `factor`-th sample, and the density (J,) of
    the noise that the angles have then.
    """
    method, noise = METHODS[derivative], noise_density(even)
    if method is None:
        q = low_pass_every(even.q, inner, even.rate, factor)
        return (q, *derivatives(q, even.rate / factor), noise)
    *parts, periods = method(even, inner, name)
    q, dq, ddq = (np.array(part[::factor]) for part in parts)
    return q, dq, ddq, noise / periods


def _direction(
    even: UniformSignals, inner: float, noise: Float, factor: int, derivative: str, name: str
) -> Direction | None:
    """Speeds that tell the direction of motion: the fastest velocities whose noise stays well below the speed at which
    a joint may stick; None where those below `inner` Hz are. `noise` (J,) is the density of that of the angles,
    rad²/Hz.
    """
    most = DIRECTION * STICK
    band = inner * float(np.min((most / np.maximum(velocity_noise(noise, inner), 1e-12)) ** (2.0 / 3.0)))
    band = min(band, 0.4 * even.rate / factor)
    if band <= inner:
        return None
    return Direction(_smoothed(even, band, factor, derivative, name)[1], band)


def _base_motion(even: UniformSignals, inner: float, factor: int, rate: float) -> Float:
    """Motion of a measured base at the working samples (N, 5), in space (N, 12), smoothed as the angles are."""
    assert even.base is not None  # `prepare` has refused the recording otherwise
    smooth = low_pass_every(even.base, inner, even.rate, factor)
    angles = 1 if smooth.shape[1] == 3 else 3
    turning, swinging = derivatives(smooth[:, :angles], rate)
    return np.column_stack([smooth[:, :angles], turning, swinging, smooth[:, angles:]])


def _held_still(q: Float, dq: Float, rate: float, noise: Float) -> Bool:
    """Joints (J,) that stay in one place: their angle has no range, their velocity is `noise` (J,) rad/s."""
    quiet = np.asarray(dq.std(axis=0) < np.maximum(STICK, 3.0 * noise))
    if not quiet.any():
        return quiet
    slow = low_pass(q, min(SWAY, 0.4 * rate), rate)
    reach = np.ptp(np.quantile(slow, (0.02, 0.98), axis=0), axis=0)
    return np.asarray(quiet & (reach < HELD))


def _reads_nothing(even: UniformSignals, cutoff: float) -> Bool:
    """Joints (J,) that have no drive: their torque is zero, or noise and next to nothing beside the others."""
    zero = (even.reach == 0.0) & (even.tau[0] == 0.0)
    span = even.span
    little = span < NOTHING * span.max()
    if not little.any():
        return np.asarray(zero)
    varies = middle_range(low_pass(even.despiked, cutoff, even.rate)) / DECILES  # of which a burst is no part
    return np.asarray(zero | little & (varies <= LOADED * quiet_noise(even.despiked, even.rate, cutoff)))


def reaches(joints: Sequence[Joint]) -> Float:
    """Return for each joint (J,) what of its own unit counts as 1 rad in thresholds written for angles."""
    return np.array([joint.reach for joint in joints])
