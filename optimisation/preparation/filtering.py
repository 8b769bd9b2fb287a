"""One recording made ready for a fit: filtered angles and their derivatives, torque without outliers, what may be used.

Angles are low-passed at twice the common cut-off, torque and model through one common filter afterwards. Where a joint
may be sticking its torque carries no information on the model, and is bridged; so is every outlier.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ground.thresholds import Threshold
from measurement.auditing.checks.motion import NOTHING
from measurement.signals.bridging import Bridge, bridging
from measurement.signals.butterworth import WaveProducts
from measurement.signals.conditioning import (
    UniformSignals,
    acceleration_deviation,
    derivatives,
    fine_derivatives,
    low_pass,
    low_pass_at,
    low_pass_every,
    median_outliers,
    noise_density,
    quiet_noise,
    velocity_noise,
    wave_products,
    widen,
)
from measurement.signals.derivatives import METHODS
from measurement.signals.methods import BUTTERWORTH
from optimisation.linear.loss import Bool
from symbolic.joints import Joint
from symbolic.model import Model
from symbolic.motion import Float, Motion
from symbolic.waves import Waves

WORKING_RATE = 100.0
"""Regressors are evaluated at about this rate, Hz (more only for high cut-offs): faster logging is averaged."""
OUTLIER_SECONDS = 0.11
"""Width of the local median, s."""
OUTLIER = Threshold(
    4.0,
    "robust deviations from the local median beyond which a torque sample is replaced: spikes spread by the filter",
)
QUICK = Threshold(
    0.1,
    "noise of accelerations in the whole band, of the accelerations' own size, up to which outliers are looked for "
    "beside them: a jump of the force, which slower angles cannot follow, passes for a spike",
)
MANY = Threshold(
    0.1,
    "share of a joint's samples far off their neighbours beyond which they are no spikes, which are rare, unless they "
    "are far off beside hardly filtered angles too: fewer jumps are left out, where clocks that differ count most",
)
SPIKE = Threshold(
    0.6,
    "part of its distance from its neighbours that a torque sample keeps beside angles that are hardly filtered, from "
    "which it is an outlier: a jump of the force, which the motion follows, is taken off the torque",
)
SIGN_WIDTH = (1e-4, 5e-2)
"""Bounds in rad/s of the velocity below which the sign of a measured velocity fades, as its noise demands."""
INNER = 2.0
"""Cut-off of the angles over the common one. Angles smoothed at the common cut-off would be smoothed twice (the model's
torque is filtered after them), the torque only once: near the cut-off a model then looks too smooth, as if the drive
were flexible. What noise the wider band lets in, the common filter takes out again."""
STICK = Threshold(
    0.03,
    "rad/s below which a joint may stick and is not fitted: dry friction takes any value there, which no "
    "function of motion tells",
)
STICK_REACH = Threshold(0.5, "periods of the cut-off by which such samples reach further: direction is smeared there")
LOADED = Threshold(
    3.0,
    "times the sensor's noise by which the torque of a standing joint varies when it shows its load: noise "
    "fitted as load",
)
HELD, SWAY = 0.02, 1.0
"""rad and Hz. A joint whose angle, below the second, has less range than the first, stays where it is. One that moves
further but never faster than `STICK` creeps: of its dry friction nothing is known, and its torque is not fitted."""
RESTS = Threshold(
    0.5,
    "share of a recording in which a joint sticks, from which deviations are those of rest: motion taken for outliers",
)
EDGE = 0.5
"""Seconds cut at both ends, where a zero-phase filter is not settled."""


@dataclass(frozen=True, eq=False)
class PreparedRecording:
    """A recording ready to be fitted: `motion` at N working samples, `torque` and `used` (J, K) at the K kept ones.

    `kept` (K,) are indices into the working samples, `outliers` (J,) the share of torque samples bridged,
    `wide_tau` (N, J) the torque with outliers bridged but not low-passed, `angle_noise` (J,) rad²/Hz the density of the
    encoders' noise and `band` in Hz what the angles contain of it. `stuck` (N, J) are working samples at which a joint
    may be sticking; its torque there is bridged. `standing` (J,) are joints that never move enough to be free of dry
    friction: their torque, where they have one to show, is used without friction and not bridged. `driven` (J,) are
    joints with a drive: the torque of the others is zero for certain. `full_rate` in Hz is that of the recording,
    `reach` (J,) what of its own unit each joint moves where a turning one moves 1 rad. `logged_tau` (N, J) is the
    torque with its outliers, where it is known.
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
    standing: Bool
    driven: Bool
    full_rate: float
    reach: Float
    logged_tau: Float | None = field(default=None, kw_only=True)

    def noisier(self, rng: np.random.Generator) -> PreparedRecording:
        """Return the recording as it would be if its encoders had added their noise once more (SIMEX, Cook, Stefanski
        1994): what a model gains by that, it had gained from noise.
        """
        deviation = np.sqrt(0.5 * self.rate * self.angle_noise)
        white = rng.standard_normal(self.motion.q.shape) * deviation
        dq, ddq = derivatives(low_pass(white, self.band, self.rate), self.rate)
        dq, ddq = np.where(self.standing, 0.0, dq), np.where(self.standing, 0.0, ddq)
        old = self.motion
        q = old.q + low_pass(white, self.band, self.rate)
        width = sign_width(2.0 * self.angle_noise, self.band, self.reach)
        sign = np.where(self.standing, 0.0, np.tanh((old.dq + dq) / width))
        motion = Motion(old.t, q, old.dq + dq, old.ddq + ddq, sign, old.payload, old.base)
        return replace(self, motion=motion)

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
        ahead: tuple[slice | int, ...] = (slice(None),) * axis
        for place, joint in enumerate(joints):
            self._bridges[joint].across(x[(*ahead, place)])
        out = np.empty((*x.shape[:-1], len(self.kept))) if out is None else out
        low_pass_at(x.reshape(-1, x.shape[-1]), self.cutoff, self.rate, self.kept, out.reshape(-1, len(self.kept)))
        return out

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
        """For each joint what bridges the samples at which it may be sticking."""
        return [bridging(column, self.rate) for column in self.stuck.T]

    @property
    def t(self) -> Float:
        """Time of the kept samples (K,), s."""
        return self.motion.t[self.kept]

    @property
    def kept_rate(self) -> float:
        """Rate of the kept samples, Hz."""
        return 1.0 / float(self.t[1] - self.t[0])


def prepare_one(
    base: Model,
    name: str,
    even: UniformSignals,
    cutoff: float,
    beta: Float | None,
    reach: float = np.inf,
    derivative: str = BUTTERWORTH,
) -> PreparedRecording:
    """Prepare one recording; without `beta` outliers are found by the torque's own running median.

    Around samples that may stick, as much is left out as a cut-off of `reach` Hz would ask for, if that is lower.
    """
    factor = max(1, int(even.rate // max(WORKING_RATE, 12.0 * cutoff)))
    tau = even.slower_torque(factor)
    rate = even.rate / factor
    inner = min(INNER * cutoff, 0.4 * even.rate)
    q, dq, ddq, noise = _smoothed(even, inner, factor, derivative, name)
    payload = np.sum([p.added(base) for p in even.payloads], axis=0) if even.payloads else None
    reach_of = reaches(base.joints)
    near = int(np.ceil(STICK_REACH * rate / min(inner, INNER * reach)))
    stuck = np.column_stack([widen(slow, near) for slow in (np.abs(dq) < STICK * reach_of).T])
    held = _held_still(q / reach_of, dq / reach_of, rate, velocity_noise(noise, inner) / reach_of)
    standing = stuck.all(axis=0) | held
    stuck = stuck & ~standing
    # A joint that stands has no direction of motion, and what its encoder's noise would give is none.
    sign = np.where(standing, 0.0, np.tanh(dq / sign_width(noise, inner, reach_of)))
    dq, ddq = np.where(held, 0.0, dq), np.where(held, 0.0, ddq)
    swaying = _base_motion(even, inner, factor, rate) if base.moving_base else None
    motion = Motion(even.t[::factor][: len(q)], q, dq, ddq, sign, payload, swaying)
    asked = beta is not None and METHODS[derivative] is None
    quick = _quick(motion, even, factor, rate, noise, reach_of) if asked else None
    bad, usual = _outliers(tau, rate, base, beta, stuck, motion, quick)
    bad = bad & (even.reach > 0.0)  # a channel that is constant has no outliers, whatever a model says
    logged, tau = tau, np.where(bad, usual, tau)
    gap = widen(even.gap[::factor][: len(q)], int(0.5 * rate / cutoff))
    edge = int(np.ceil(EDGE * rate))
    kept = np.arange(edge, len(q) - edge, max(1, int(rate // (6.0 * cutoff))))
    loaded = held & _bears_load(tau, rate, cutoff) if held.any() else held
    use = ~gap[kept, None] & ~stuck[kept] & ~(standing & ~loaded)
    return PreparedRecording(
        name=name,
        motion=motion,
        torque=low_pass_at(np.ascontiguousarray(bridged(tau, stuck, rate).T), cutoff, rate, kept),
        used=np.ascontiguousarray(use.T),
        kept=kept,
        cutoff=cutoff,
        rate=rate,
        outliers=bad.mean(axis=0),
        wide_tau=tau,
        angle_noise=noise,
        band=min(inner, 0.4 * rate),
        stuck=stuck,
        standing=standing,
        driven=~(even.passive | _reads_nothing(even, cutoff)),
        full_rate=even.rate,
        reach=reach_of,
        logged_tau=logged,
    )


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


def _outliers(
    tau: Float, rate: float, base: Model, beta: Float | None, stuck: Bool, motion: Motion, quick: Motion | None
) -> tuple[Bool, Float]:
    """Return which torque samples (N, J) are outliers, and what stands there instead (N, J): by the torque's own
    running median, or with `beta` (P,) by that of what `base` leaves along `motion`.

    Where these are many, along the `quick` motion too, of angles that are hardly filtered, if there is one.
    """
    if beta is None:
        return median_outliers(tau, OUTLIER_SECONDS, rate, 6.0)
    known = base.torque(_at_rest(motion, stuck), beta)
    bad, middle = median_outliers(tau - known, OUTLIER_SECONDS, rate, OUTLIER)
    if quick is not None and np.any(bad.mean(axis=0) > MANY):
        beside_quick = tau - base.torque(_at_rest(quick, stuck), beta)
        too, around = median_outliers(beside_quick, OUTLIER_SECONDS, rate, OUTLIER)
        spikes = too & (np.abs(beside_quick - around) > SPIKE * np.abs(tau - known - middle))
        bad = bad & (spikes | (bad.mean(axis=0) <= MANY))
    return bad, known + middle


def _base_motion(even: UniformSignals, inner: float, factor: int, rate: float) -> Float:
    """Return how a measured base moves at the working samples (N, 5), smoothed as the angles are."""
    assert even.base is not None  # `prepare` has refused the recording otherwise
    smooth = low_pass_every(even.base, inner, even.rate, factor)
    turning, swinging = derivatives(smooth[:, :1], rate)
    return np.column_stack([smooth[:, :1], turning, swinging, smooth[:, 1:]])


def _at_rest(motion: Motion, stuck: Bool) -> Motion:
    """Return `motion` without a direction where a joint sticks that does so for much of the time: the sign of noise
    would make outliers of a constant torque.
    """
    rests = stuck & (stuck.mean(axis=0) > RESTS)
    return replace(motion, sign=np.where(rests, 0.0, motion.sign)) if rests.any() else motion


def _quick(motion: Motion, even: UniformSignals, factor: int, rate: float, noise: Float, reach: Float) -> Motion | None:
    """Return `motion` with angles filtered as little as the torque is; None where they are too noisy for that.

    Where the force jumps, it differs from what slower angles ask for as if it had outliers there.
    """
    band = 0.4 * rate
    if np.any(acceleration_deviation(noise, band) > QUICK * motion.ddq.std(axis=0)):
        return None
    angles = low_pass(even.q, band, even.rate)
    q, dq, ddq = (part[::factor] for part in (angles, *fine_derivatives(angles, even.rate)))
    sign = np.where(motion.sign == 0.0, 0.0, np.tanh(dq / sign_width(noise, band, reach)))
    return replace(motion, q=q, dq=dq, ddq=ddq, sign=sign)


def _held_still(q: Float, dq: Float, rate: float, noise: Float) -> Bool:
    """Return which joints (J,) stay in one place: their angle has no range, their velocity is `noise` (J,) rad/s."""
    quiet = np.asarray(dq.std(axis=0) < np.maximum(STICK, 3.0 * noise))
    if not quiet.any():
        return quiet
    slow = low_pass(q, min(SWAY, 0.4 * rate), rate)
    reach = np.ptp(np.quantile(slow, (0.02, 0.98), axis=0), axis=0)
    return np.asarray(quiet & (reach < HELD))


def _bears_load(tau: Float, rate: float, cutoff: float) -> Bool:
    """Return for each joint (J,) whether its torque tells something about the load while it stands.

    Where a brake, a lock or dry friction carries the load, the torque stays as it is while the other joint moves.
    """
    return np.asarray(low_pass(tau, cutoff, rate).std(axis=0) > LOADED * quiet_noise(tau, rate, cutoff))


def _reads_nothing(even: UniformSignals, cutoff: float) -> Bool:
    """Return which joints (J,) have no drive: their torque is zero, or noise and next to nothing beside the others."""
    zero = (even.reach == 0.0) & (even.tau[0] == 0.0)
    span = even.span
    little = span < NOTHING * span.max()
    if not little.any():
        return zero
    return np.asarray(zero | little & ~_bears_load(even.despiked, even.rate, cutoff))


def bridged(x: Float, stuck: Bool, rate: float) -> Float:
    """Return `x` (N, J, ...) bridged where each joint may stick, (N, J)."""
    out = np.array(np.moveaxis(x, 0, -1), dtype=float, order="C")
    for row, column in zip(out, stuck.T, strict=True):
        bridging(column, rate).across(row)
    return np.moveaxis(out, -1, 0)


def sign_width(noise: Float, band: float, reach: Float) -> Float:
    """Return the velocity (J,) in rad/s over which the sign fades: a part of the noise of a velocity.

    `noise` (J,) is the density of the angle noise in rad²/Hz, `band` in Hz what is left of it, `reach` (J,) as of a
    PreparedRecording.
    """
    low, high = SIGN_WIDTH
    return np.clip(0.3 * velocity_noise(noise, band), low * reach, high * reach)


def reaches(joints: Sequence[Joint]) -> Float:
    """Return for each joint (J,) what of its own unit counts as 1 rad in thresholds written for angles."""
    return np.array([joint.reach for joint in joints])
