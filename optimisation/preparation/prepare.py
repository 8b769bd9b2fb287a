"""From recordings to samples that a fit may use: derivatives, one cut-off for all, outliers taken out.

The cut-off matters more than any added term (docs: how the numbers are made), so it is chosen from the data and
its reason is told. Outliers of the torque are judged against the *local median of the residual* of a robust
eight-parameter fit: an unmodelled effect moves that median and is kept, a single bad sample does not. They are
bridged before filtering, once, before anything is diagnosed, so that every model sees the same samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ground.errors import RecordingError
from ground.html import bullets, lines, table
from measurement.auditing.checks.motion import NOTHING
from measurement.auditing.convention import check_conventions
from measurement.finding import Finding
from measurement.overlap import held_apart
from measurement.recording import Recording
from measurement.signals.conditioning import (
    Bridge,
    EvenSignals,
    acceleration_noise,
    acceleration_quality,
    bridging,
    decimate,
    derivatives,
    even_clock,
    fine_derivatives,
    low_pass,
    low_pass_at,
    median_outliers,
    noise_density,
    quiet_noise,
    velocity_noise,
    widen,
)
from measurement.signals.derivatives import BUTTERWORTH, METHODS, check_method
from optimisation.fitting.assemble import assemble
from optimisation.linear.loss import Bool
from optimisation.linear.problem import LinearData
from optimisation.linear.solve import delta_rule, solve_huber, solve_sse
from symbolic.model import Model, require_leg
from symbolic.motion import Float, Motion
from symbolic.quantity import JOINTS

CUTOFFS = (3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0)
"""Cut-off frequencies tried, Hz."""
COMMON_BAND = 3.0
"""Every cut-off is judged on the unseen torque below this frequency, Hz."""
BIAS_LIMIT = 0.005
"""Largest share of noise in the accelerations: about the relative bias of an inertia."""
NOISE_LIMIT = 0.05
"""Largest noise power that accelerations may carry into the model's torque, relative to the torque sensor's own: more,
and effects that happen to smooth the model (a flexible drive) look real."""
TOLERANCE = 0.03
"""A cut-off may predict this much worse than the best one; then the faster one is preferred (more information)."""
NOISE_SEEN = 1e-4
"""Share of noise in the accelerations at the fastest cut-off tried from which on the spectrum of the angles plainly
shows the encoders' noise, so that what it does at every cut-off is known."""
LOOSE_TOLERANCE = 0.25
"""The same where the noise is known: unseen torque is then mostly predicted worse because faster motion shows more of
what the base model misses (friction near standstill), which is no reason to look away."""
WORKING_RATE = 100.0
"""Regressors are evaluated at about this rate, Hz (more only for high cut-offs): faster logging is averaged."""
OUTLIER = 4.0
"""Robust deviations from the local median beyond which a torque sample is an outlier."""
SIGN_WIDTH = (1e-4, 5e-2)
"""Bounds in rad/s of the velocity below which the sign of a measured velocity fades, as its noise demands."""
INNER = 2.0
"""Cut-off of the angles over the common one. Angles smoothed at the common cut-off would be smoothed twice (the model's
torque is filtered after them), the torque only once: near the cut-off a model then looks too smooth, as if the drive
were flexible. What noise the wider band lets in, the common filter takes out again."""
STICK = 0.03
"""Velocity in rad/s below which a joint may be sticking: dry friction then takes any value up to its limit, which no
function of the motion can tell, so these samples of that joint are not fitted."""
STICK_REACH = 0.5
"""Periods of the angles' cut-off by which these samples reach into their neighbours: there velocity and direction are
smeared. The torque of all of them, and every column of a model alike, is replaced by a straight line before the common
filter, so that nothing of it gets into the samples that are fitted."""
LOADED = 3.0
"""A joint that stands shows its load where its torque varies by more than this many times the sensor's noise."""
HELD, SWAY = 0.02, 1.0
"""rad and Hz. A joint whose angle, below the second, has less range than the first, stays where it is. One that moves
further but never faster than `STICK` creeps: of its dry friction nothing is known, and its torque is not fitted."""
EDGE = 0.5
"""Seconds cut at both ends, where a zero-phase filter is not settled."""

LEAST_CYCLES = 2.0
"""Cycles of the cut-off that the shortest recording must hold: below, the filter leaves a line."""


@dataclass(frozen=True, eq=False)
class PreparedRecording:
    """A recording ready to be fitted: `motion` at N working samples, `tau` and `use` (K, J) at the K kept ones.

    `kept` (K,) are indices into the working samples, `outliers` (J,) the share of torque samples bridged,
    `wide_tau` (N, J) the torque with outliers bridged but not low-passed, `angle_noise` (J,) rad²/Hz the density of the
    encoders' noise and `band` in Hz what the angles contain of it. `stuck` (N, J) are working samples at which a joint
    may be sticking; its torque there is bridged. `standing` (J,) are joints that never move enough to be free of dry
    friction: their torque, where they have one to show, is used without friction and not bridged. `driven` (J,) are
    joints with a drive: the torque of the others is zero for certain. `full_rate` in Hz is that of the recording.
    """

    name: str
    motion: Motion
    tau: Float
    use: Bool
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
        width = sign_width(2.0 * self.angle_noise, self.band)
        sign = np.where(self.standing, 0.0, np.tanh((old.dq + dq) / width))
        motion = Motion(old.t, q, old.dq + dq, old.ddq + ddq, sign, old.payload)
        return replace(self, motion=motion)

    def smooth(self, x: Float, joints: Sequence[int] = (0, 1), axis: int = 1) -> Float:
        """Bridge and filter `x` (N, ...) exactly as the torque was; return the kept samples (K, ...).

        `axis` of `x` has the rows of `joints`.
        """
        rows = np.array(np.moveaxis(x, 0, -1), dtype=float, order="C")
        return np.ascontiguousarray(np.moveaxis(self.smooth_rows(rows, joints, axis - 1), -1, 0))

    def smooth_rows(self, x: Float, joints: Sequence[int], axis: int) -> Float:
        """Do the same to `x` (..., N), which is bridged in place, and return (..., K)."""
        for place, joint in enumerate(joints):
            self._bridges[joint].across(np.moveaxis(x, axis, 0)[place])
        flat = low_pass_at(x.reshape(-1, x.shape[-1]), self.cutoff, self.rate, self.kept)
        return flat.reshape(*x.shape[:-1], -1)

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


@dataclass(frozen=True)
class CutoffChoice:
    """The common cut-off in Hz and, in words, why it is that one. `table` holds (cut-off, error, noise share)."""

    cutoff: float
    reason: str
    automatic: bool = True
    table: tuple[tuple[float, float, float], ...] = field(default=())


@dataclass(frozen=True, eq=False)
class Prepared:
    """All recordings of one question, prepared alike: `train` to fit, `verify` never fitted.

    `misread` are those of the `findings` that say in which convention the recordings seem to be (`--convention`).
    `noise_floor` (J,) N·m is what no model can get below: noise of the torque, of the angles, and `filter_error` (J,),
    what filter and derivatives get wrong. `acceleration_noise` is the share of noise in the accelerations.
    """

    train: tuple[PreparedRecording, ...]
    verify: tuple[PreparedRecording, ...]
    choice: CutoffChoice
    noise_floor: Float
    filter_error: Float
    acceleration_noise: float
    findings: tuple[Finding, ...] = ()
    derivative: str = BUTTERWORTH
    misread: tuple[Finding, ...] = ()

    @property
    def all(self) -> tuple[PreparedRecording, ...]:
        """Training recordings, then verification recordings."""
        return self.train + self.verify

    def __repr__(self) -> str:
        names = ", ".join(one.name for one in self.train), ", ".join(one.name for one in self.verify) or "none"
        return f"Prepared(train: {names[0]}; verify: {names[1]}; cut-off {self.choice.reason})"

    def _repr_html_(self) -> str:
        rows = [
            (one.name, use, len(one.t), one.kept_rate, *(f"{100 * float(x):.1f} %" for x in one.outliers))
            for use, group in (("fitted", self.train), ("unseen", self.verify))
            for one in group
        ]
        head = ("recording", "used as", "samples", "Hz", "hip torque bridged", "knee torque bridged")
        return lines(f"cut-off: {self.choice.reason}") + table(head, rows) + bullets(self.findings)


def prepare(
    model: Model,
    recordings: Sequence[Recording],
    verify: Sequence[Recording] = (),
    *,
    cutoff: float | None = None,
    derivative: str = BUTTERWORTH,
) -> Prepared:
    """Prepare `recordings` and `verify` for `model`, whose geometry (not whose effects) is used to find outliers.

    `cutoff` in Hz; None chooses it. `derivative` is one of `measurement.signals.derivatives.METHODS`. Refuses any that
    are too short or too slow for the cut-off, motion that does not repeat where periods are to be averaged, and unseen
    recordings that share samples with fitted ones. Samples that two fitted recordings share count once.
    """
    check_method(derivative)
    require_leg(model, "identification")
    if not recordings:
        raise RecordingError("there is no recording to fit", remedy="name at least one recording")
    recordings, verify, doubled = held_apart(recordings, verify)
    base = model.base()
    even = [even_clock(r) for r in (*recordings, *verify)]
    names = [r.name for r in (*recordings, *verify)]
    slowest = min(e.rate for e in even)
    if cutoff is not None and not 0.0 < cutoff <= 0.4 * slowest:
        raise RecordingError(
            f"a cut-off of {cutoff:g} Hz does not fit recordings sampled at {slowest:.4g} Hz",
            remedy=f"choose a cut-off between 0.5 and {0.4 * slowest:.3g} Hz, or leave the choice to exoid",
        )
    shortest = min(float(e.t[-1] - e.t[0]) for e in even)
    if cutoff is not None and cutoff * shortest < LEAST_CYCLES:
        raise RecordingError(
            f"a cut-off of {cutoff:g} Hz leaves nothing of a recording of {shortest:.3g} s",
            remedy=f"choose a cut-off between 0.5 and {0.4 * slowest:.3g} Hz, or leave the choice to exoid",
        )
    count = len(recordings)
    inputs = list(zip(names, even, strict=True))
    beta = _robust_base(
        base, [_prepare_one(base, n, e, COMMON_BAND, None, derivative=derivative) for n, e in inputs[:count]]
    )
    if cutoff is None:
        choice = _choose(base, names[:count], even[:count], beta, derivative)
    else:
        choice = CutoffChoice(cutoff, f"{cutoff:g} Hz, as asked for", automatic=False)
    done = [_prepare_one(base, n, e, choice.cutoff, beta, derivative=derivative) for n, e in inputs]
    misread = (*check_conventions(recordings), *check_conventions(verify))
    known = tuple(f for r in (*recordings, *verify) for f in r.findings)
    wrong = np.sqrt(_mean_square(_torque_of_filter(base, beta, done), done))
    return Prepared(
        train=tuple(done[:count]),
        verify=tuple(done[count:]),
        choice=choice,
        noise_floor=np.sqrt(
            _noise_floor(done, choice.cutoff) ** 2 + wrong**2 + _mean_square(_torque_of_noise(base, beta, done), done)
        ),
        filter_error=wrong,
        acceleration_noise=_noise_share(done[:count], even[:count], choice.cutoff),
        findings=(*known, *doubled, *(f for f in misread if f not in known), *_outlier_findings(done)),
        derivative=derivative,
        misread=misread,
    )


def _prepare_one(
    base: Model,
    name: str,
    even: EvenSignals,
    cutoff: float,
    beta: Float | None,
    reach: float = np.inf,
    derivative: str = BUTTERWORTH,
) -> PreparedRecording:
    """Prepare one recording; without `beta` the outliers are judged by the torque's own running median.

    Around samples that may stick, as much is left out as a cut-off of `reach` Hz would ask for, if that is lower.
    """
    factor = max(1, int(even.rate // max(WORKING_RATE, 12.0 * cutoff)))
    tau = np.array(decimate(even.despiked if factor > 1 else even.tau, factor, even.rate))
    rate = even.rate / factor
    driven = ~(even.passive | _reads_nothing(even.tau, tau, rate, cutoff))
    inner = min(INNER * cutoff, 0.4 * even.rate)
    smoothed = METHODS[derivative]
    noise = noise_density(even)
    if smoothed is None:
        q = np.array(low_pass(even.q, inner, even.rate)[::factor])
        dq, ddq = derivatives(q, rate)
    else:
        *parts, periods = smoothed(even, inner, name)
        q, dq, ddq = (np.array(part[::factor]) for part in parts)
        noise = noise / periods
    payload = np.sum([p.added(base) for p in even.payloads], axis=0) if even.payloads else None
    near = int(np.ceil(STICK_REACH * rate / min(inner, INNER * reach)))
    stuck = np.column_stack([widen(np.abs(dq[:, j]) < STICK, near) for j in range(len(JOINTS))])
    held = _held_still(q, dq, rate, velocity_noise(noise, inner))
    standing = stuck.all(axis=0) | held
    stuck = stuck & ~standing
    # A joint that stands has no direction of motion, and what its encoder's noise would give is none.
    sign = np.where(standing, 0.0, np.tanh(dq / sign_width(noise, inner)))
    dq, ddq = np.where(held, 0.0, dq), np.where(held, 0.0, ddq)
    motion = Motion(even.t[::factor][: len(q)], q, dq, ddq, sign, payload)
    known = tau * 0.0 if beta is None else base.torque(motion, beta)
    bad, middle = median_outliers(tau - known, 0.11, rate, OUTLIER if beta is not None else 6.0)
    bad = bad & (np.ptp(even.tau, axis=0) > 0.0)  # a channel that is constant has no outliers, whatever a model says
    tau = np.where(bad, known + middle, tau)
    gap = widen(even.gap[::factor][: len(q)], int(0.5 * rate / cutoff))
    edge = int(np.ceil(EDGE * rate))
    kept = np.arange(edge, len(q) - edge, max(1, int(rate // (6.0 * cutoff))))
    use = ~gap[kept, None] & ~stuck[kept] & ~(standing & ~(held & _bears_load(tau, rate, cutoff)))
    level = np.ascontiguousarray(bridged(tau, stuck, rate).T)
    return PreparedRecording(
        name=name,
        motion=motion,
        tau=np.ascontiguousarray(low_pass_at(level, cutoff, rate, kept).T),
        use=use,
        kept=kept,
        cutoff=cutoff,
        rate=rate,
        outliers=bad.mean(axis=0),
        wide_tau=tau,
        angle_noise=noise,
        band=min(inner, 0.4 * rate),
        stuck=stuck,
        standing=standing,
        driven=driven,
        full_rate=even.rate,
    )


def _held_still(q: Float, dq: Float, rate: float, noise: Float) -> Bool:
    """Return which joints (J,) stay in one place: their angle has no range, their velocity is `noise` (J,) rad/s."""
    slow = low_pass(q, min(SWAY, 0.4 * rate), rate)
    reach = np.ptp(np.quantile(slow, (0.02, 0.98), axis=0), axis=0)
    return np.asarray((reach < HELD) & (dq.std(axis=0) < np.maximum(STICK, 3.0 * noise)))


def _bears_load(tau: Float, rate: float, cutoff: float) -> Bool:
    """Return for each joint (J,) whether its torque tells something about the load while it stands.

    Where a brake, a lock or dry friction carries the load, the torque stays as it is while the other joint moves.
    """
    return np.asarray(low_pass(tau, cutoff, rate).std(axis=0) > LOADED * quiet_noise(tau, rate, cutoff))


def _reads_nothing(logged: Float, tau: Float, rate: float, cutoff: float) -> Bool:
    """Return which joints (J,) have no drive: their torque is zero, or noise and next to nothing beside the others."""
    zero = (np.ptp(logged, axis=0) == 0.0) & (logged[0] == 0.0)
    span = np.ptp(np.quantile(logged, (0.1, 0.9), axis=0), axis=0)
    return np.asarray(zero | (span < NOTHING * span.max()) & ~_bears_load(tau, rate, cutoff))


def bridged(x: Float, stuck: Bool, rate: float) -> Float:
    """Return `x` (N, J, ...) bridged where each joint may stick, (N, J)."""
    out = np.array(np.moveaxis(x, 0, -1), dtype=float, order="C")
    for row, column in zip(out, stuck.T, strict=True):
        bridging(column, rate).across(row)
    return np.moveaxis(out, -1, 0)


def sign_width(noise: Float, band: float) -> Float:
    """Return the velocity (J,) in rad/s over which the sign fades: a part of the noise of a velocity.

    `noise` (J,) is the density of the angle noise in rad²/Hz, `band` in Hz what is left of it.
    """
    return np.clip(0.3 * velocity_noise(noise, band), *SIGN_WIDTH)


def _fit(data: LinearData) -> Float:
    first = solve_sse(data)
    return solve_huber(data, delta_rule(data.residual(first), use=data.use), first)


def _robust_base(base: Model, prepared: Sequence[PreparedRecording]) -> Float:
    return _fit(assemble(base, prepared))


def _part(data: LinearData, keep: np.ndarray) -> LinearData:
    return replace(
        data, columns=data.columns[:, keep], tau=data.tau[:, keep], groups=data.groups[keep], use=data.use[:, keep]
    )


def _folds(groups: np.ndarray) -> list[np.ndarray]:
    """Return masks of held-out samples: whole recordings, or four long blocks of a single one."""
    labels = np.unique(groups)
    if labels.size > 1:
        return [groups == label for label in labels]
    block = np.arange(groups.size) * 4 // groups.size
    return [block == b for b in range(4)]


def _choose(
    base: Model, names: Sequence[str], even: Sequence[EvenSignals], beta: Float, derivative: str
) -> CutoffChoice:
    """Choose the fastest cut-off that predicts unseen torque as well as any and keeps accelerations clean."""
    slowest = min(e.rate for e in even)
    tried = [c for c in CUTOFFS if c <= 0.25 * slowest] or [0.2 * slowest]
    inputs = list(zip(names, even, strict=True))
    slow = min(COMMON_BAND, tried[0])
    judge = assemble(base, [_prepare_one(base, n, e, slow, beta, derivative=derivative) for n, e in inputs])
    errors, shares, carried = [], [], []
    for cutoff in tried:
        # All on motion equally far from standstill: nearer to it friction is more than the base model knows, and a
        # faster cut-off, which gets nearer, would be blamed for that.
        prepared = [_prepare_one(base, n, e, cutoff, beta, COMMON_BAND, derivative) for n, e in inputs]
        data = assemble(base, prepared)
        square = np.zeros(2)
        for held, out in zip(_folds(data.groups), _folds(judge.groups), strict=True):
            square += np.sum(_part(judge, out).residual(_fit(_part(data, ~held))) ** 2, axis=1)
        errors.append(np.sqrt(square / np.maximum(judge.use.sum(axis=1), 1)))
        # The cleanest recording of each joint decides: a joint held still has no acceleration to get wrong.
        shares.append(_noise_share(prepared, even, cutoff))
        carried.append(_carried_noise(beta, even, cutoff, _noise_floor(prepared, cutoff)))
    least = np.min(errors, axis=0)
    relative = np.max(np.array(errors) / np.where(least > 0.0, least, 1.0), axis=1, where=least > 0.0, initial=1.0)
    tolerance = LOOSE_TOLERANCE if shares[-1] >= NOISE_SEEN else TOLERANCE
    predicts = relative <= 1.0 + tolerance
    clean = (np.array(shares) <= BIAS_LIMIT) & (np.array(carried) <= NOISE_LIMIT)
    good = [i for i in range(len(tried)) if predicts[i] and clean[i]]
    index = good[-1] if good else int(np.argmin(relative + np.array(shares)))
    table = tuple((c, float(r), s) for c, r, s in zip(tried, relative, shares, strict=True))
    return CutoffChoice(tried[index], _reason(tried, index, relative, shares, carried, tolerance), table=table)


def _noise_share(prepared: Sequence[PreparedRecording], even: Sequence[EvenSignals], cutoff: float) -> float:
    """Return the share of noise in the accelerations, of the worse joint in its cleanest recording.

    A joint that is held still has no acceleration to get wrong.
    """
    quality = np.array([acceleration_quality(e, cutoff) for e in even])
    moves = ~np.array([one.standing for one in prepared])
    best = np.min(quality, axis=0, where=moves, initial=np.inf)
    return float(np.max(best[np.isfinite(best)], initial=0.0))


def _carried_noise(beta: Float, even: Sequence[EvenSignals], cutoff: float, floor: Float) -> float:
    """Return the noise power that accelerations carry into the model's torque, relative to the torque's own."""
    first, second, coupling = abs(beta[0]), abs(beta[1]), abs(beta[2])
    hip, knee = np.median([acceleration_noise(e, cutoff) for e in even], axis=0) ** 2
    power = np.array(
        [
            (first + 2.0 * coupling) ** 2 * hip + (second + coupling) ** 2 * knee,
            (second + coupling) ** 2 * hip + second**2 * knee,
        ]
    )
    return float(np.max(power / np.maximum(floor**2, 1e-300)))


def _reason(
    tried: Sequence[float],
    index: int,
    relative: Float,
    shares: Sequence[float],
    carried: Sequence[float],
    tolerance: float,
) -> str:
    text = f"{tried[index]:g} Hz: noise makes up {100 * shares[index]:.2g} % of the accelerations"
    if index + 1 == len(tried):
        return text + ", and no faster cut-off was tried"
    after = index + 1
    beyond = f"{text}; at {tried[after]:g} Hz"
    if relative[after] > 1.0 + tolerance:
        return f"{beyond} unseen torque is predicted {100 * (relative[after] - 1):.0f} % worse than at best"
    if shares[after] > BIAS_LIMIT:
        return f"{beyond} it would be {100 * shares[after]:.2g} %, a bias towards zero for every inertia"
    return f"{beyond} they would carry {100 * carried[after]:.0f} % of the torque sensor's noise power into the model"


def _noise_floor(prepared: Sequence[PreparedRecording], cutoff: float) -> Float:
    """Return the RMS (J,) in N·m that sensor noise leaves below the cut-off, from the top of the torque's spectrum.

    Estimated without a model, from recordings in which the joint is driven: a torque that is zero for certain has no
    noise. A torque sensor whose noise is not white has a floor of its own; this one is then low.
    """
    square = np.array([quiet_noise(p.wide_tau, p.rate, cutoff) ** 2 for p in prepared])
    driven = np.array([p.driven for p in prepared])
    return np.sqrt(np.sum(square, axis=0, where=driven) / np.maximum(driven.sum(axis=0), 1))


def _torque_of_filter(base: Model, beta: Float, prepared: Sequence[PreparedRecording]) -> list[Float]:
    """Return for each recording what filter and derivatives get wrong, (K, J) N·m: the model's torque once more with
    the angles filtered twice and differentiated more exactly.
    """
    out = []
    for one in prepared:
        q = low_pass(one.motion.q, one.band, one.rate)
        dq, ddq = fine_derivatives(q, one.rate)
        out.append(
            _torque_change(base, beta, one, q, np.where(one.standing, 0.0, dq), np.where(one.standing, 0.0, ddq))
        )
    return out


def _torque_of_noise(base: Model, beta: Float, prepared: Sequence[PreparedRecording]) -> list[Float]:
    """Return for each recording what noise of the angles makes in the model's torque, (K, J) N·m."""
    out = []
    for index, one in enumerate(prepared):
        other = one.noisier(np.random.default_rng(index)).motion
        out.append(_torque_change(base, beta, one, other.q, other.dq, other.ddq))
    return out


def _torque_change(base: Model, beta: Float, one: PreparedRecording, q: Float, dq: Float, ddq: Float) -> Float:
    old = one.motion
    changed = Motion(old.t, q, dq, ddq, old.sign, old.payload)
    return one.smooth(base.torque(changed, beta) - base.torque(old, beta))


def _mean_square(change: Sequence[Float], prepared: Sequence[PreparedRecording]) -> Float:
    """Return the mean square (J,) of changes (K, J) over the usable samples of all recordings."""
    square = np.sum(
        [np.sum(np.where(p.use, x, 0.0) ** 2, axis=0) for x, p in zip(change, prepared, strict=True)], axis=0
    )
    return np.asarray(square / np.maximum(np.sum([p.use.sum(axis=0) for p in prepared], axis=0), 1))


def _outlier_findings(prepared: Sequence[PreparedRecording]) -> tuple[Finding, ...]:
    most = np.max([one.outliers for one in prepared], axis=0)
    if most.max() < 0.01:
        return ()
    shares = ", ".join(f"{joint} up to {100 * share:.0f} %" for joint, share in zip(JOINTS, most, strict=True))
    what = f"torque samples far off their neighbours were bridged before filtering ({shares})"
    remedy = "look at the torque sensor and its cable if this is unexpected"
    return (Finding("torque_outliers", "repaired", what, "all recordings", float(most.max()), 0.01, remedy, True),)
