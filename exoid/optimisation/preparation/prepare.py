"""From recordings to samples that a fit may use: derivatives, one cut-off for all, outliers taken out.

The cut-off matters more than any added term (docs: how the numbers are made), so it is chosen from the data and
its reason is reported. Outliers of the torque are found against the *local median of the residual* of a robust
fit of the base model: an unmodelled effect moves that median and is kept, a single bad sample does not. They are
bridged before filtering, once, before anything is diagnosed, so that every model sees the same samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exoid.ground.engines.memory import reuse_freed_memory
from exoid.ground.errors import NotEnoughDataError, RecordingError
from exoid.ground.html import bullets, lines, table
from exoid.ground.thresholds import Threshold
from exoid.ground.ties import index_of_greatest
from exoid.measurement.auditing.convention import check_conventions
from exoid.measurement.auditing.masses import check_masses
from exoid.measurement.auditing.scale import check_scales
from exoid.measurement.finding import EVERY, Finding
from exoid.measurement.forces import force_signals, unused_forces
from exoid.measurement.overlap import held_apart
from exoid.measurement.reading.given import Given, question_of
from exoid.measurement.recording import Recording, base_columns
from exoid.measurement.signals.conditioning import UniformSignals, middle_range, uniform_sampling
from exoid.measurement.signals.derivatives import check_method
from exoid.measurement.signals.methods import BUTTERWORTH
from exoid.optimisation.preparation.cutoff import (
    COMMON_BAND,
    CutoffChoice,
    choose_cutoff,
    noise_share,
    robust_base,
    typical,
)
from exoid.optimisation.preparation.filtering import PreparedRecording, prepare_one
from exoid.optimisation.preparation.noise import mean_square, noise_floor, torque_of_filter, torque_of_noise
from exoid.optimisation.preparation.smoothed import FILTERED, TORQUES, smoothed_findings
from exoid.symbolic.joints import LEG, Joint, names
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

SWAYS: Threshold = 0.02
"""rad by which a base taken to stand still may turn: its motion passes for effects"""
LEAST_CYCLES: Threshold = 2.0
"""cycles of the cut-off in the shortest recording: the filter leaves a line"""
NOTED: Threshold = 0.005
"""share of a torque hidden as spikes from which it is said: a spike or two are no finding"""
MANY: Threshold = 0.02
"""share from which it is a warning with the place: a bad sensor is passed over"""
SPIKES = "torque_outliers"
"""What the finding on them is called."""
UNDRIVEN: Threshold = 0.5
"""part of the largest torque that a joint said to be passive may show: a driven joint fitted as free"""


@dataclass(frozen=True, eq=False)
class Prepared:
    """All recordings of one question, prepared alike: `train` to fit, `verify` never fitted.

    `misread` are those of the `findings` that say in which convention (`--convention`) or unit the recordings are.
    `noise_floor` (J,) N·m is what no model can get below: noise of the torque, of the angles, and `filter_error` (J,),
    what filter and derivatives get wrong. `acceleration_noise` is the share of noise in the accelerations. Torques of
    the joints (indices) `zeroed` are without the zeros that each recording has of its own.
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
    joints: tuple[Joint, ...] = LEG
    zeroed: tuple[int, ...] = ()

    @property
    def all(self) -> tuple[PreparedRecording, ...]:
        """Training recordings, then verification recordings."""
        return self.train + self.verify

    def with_recordings(self, recordings: Sequence[PreparedRecording]) -> Prepared:
        """The same with other recordings in place of all, training ones first."""
        count = len(self.train)
        return replace(self, train=tuple(recordings[:count]), verify=tuple(recordings[count:]))

    @property
    def noise_is_known(self) -> bool:
        """True if what noise the torques hold is that of their sensors: of filtered ones it is no measure."""
        return not any(finding.check == TORQUES for finding in self.findings)

    @property
    def angles_were_filtered(self) -> bool:
        """True if the angles hold no sensor's noise, and the torques do: no simulation that is exact."""
        return any(finding.check == FILTERED for finding in self.findings)

    def __repr__(self) -> str:
        fitted, unseen = (", ".join(item.name for item in group) or "none" for group in (self.train, self.verify))
        return f"Prepared(train: {fitted}; verify: {unseen}; cut-off {self.choice.reason})"

    def _repr_html_(self) -> str:
        rows = [
            (item.name, use, len(item.t), item.kept_rate, *(f"{100 * float(x):.1f} %" for x in item.outliers))
            for use, group in (("fitted", self.train), ("unseen", self.verify))
            for item in group
        ]
        head = ("recording", "used as", "samples", "Hz", *(f"{joint} torque bridged" for joint in names(self.joints)))
        return lines(f"cut-off: {self.choice.reason}") + table(head, rows) + bullets(self.findings)


def prepare(
    model: Model,
    recordings: Given,
    verify: Given = (),
    *,
    cutoff: float | None = None,
    derivative: str = BUTTERWORTH,
) -> Prepared:
    """Prepare `recordings` and `verify` for `model`, whose geometry (not whose effects) is used to find outliers.

    `cutoff` in Hz; None chooses it. `derivative` is one of `exoid.measurement.signals.derivatives.METHODS`. Refuses any
    that are too short or too slow for the cut-off, motion that does not repeat where periods are to be averaged, and
    unseen recordings that share samples with fitted ones. Samples that two fitted recordings share count once.
    """
    model, recordings, verify = question_of(model, recordings, verify)
    check_method(derivative)
    reuse_freed_memory()
    if not recordings:
        raise RecordingError("there is no recording to fit", remedy="name at least one recording")
    recordings, verify = ([item.of_machine(model.joints) for item in group] for group in (recordings, verify))
    swayed, unused = _check_base(model, (*recordings, *verify)), unused_forces(model, (*recordings, *verify))
    for recording in (*recordings, *verify):
        _refuse_driven(recording)
    recordings, verify, doubled = held_apart(recordings, verify)
    base = model.base()
    even = [uniform_sampling(r, force_signals(model, r)) for r in (*recordings, *verify)]
    called = [r.name for r in (*recordings, *verify)]
    _check_cutoff(cutoff, even)
    count = len(recordings)
    inputs = list(zip(called, even, strict=True))
    judged = [(name, part) for name, whole in inputs[:count] for part in typical(whole)]
    beta = robust_base(base, [prepare_one(base, n, e, COMMON_BAND, None, derivative=derivative) for n, e in judged])
    _refuse_free_swing(even[:count])
    if cutoff is None:
        choice = choose_cutoff(base, judged, beta, derivative)
    else:
        choice = CutoffChoice(cutoff, f"{cutoff:g} Hz, as asked for")
    done = [prepare_one(base, n, e, choice.cutoff, beta, derivative=derivative) for n, e in inputs]
    meant = model.forces or None
    misread = check_conventions((*recordings, *verify), model.pull, meant)
    misread = misread or check_scales(recordings) or check_masses(recordings, model.joints, model.pull)
    known = tuple(f for r in (*recordings, *verify) for f in r.findings)
    outliers = _outlier_findings(done, model.joint_names)
    wrong = np.sqrt(mean_square(torque_of_filter(base, beta, done), done))
    return Prepared(
        train=tuple(done[:count]),
        verify=tuple(done[count:]),
        choice=choice,
        noise_floor=np.sqrt(
            noise_floor(done) ** 2 + wrong**2 + mean_square(torque_of_noise(base, beta, done), done)
        ),
        filter_error=wrong,
        acceleration_noise=noise_share(done[:count], even[:count], choice.cutoff),
        findings=(
            *known, *swayed, *unused, *doubled, *misread, *outliers,
            *smoothed_findings(called, even, model.joints),
        ),
        derivative=derivative,
        misread=misread,
        joints=model.joints,
    )


def judged_anew(prepared: Prepared, torques: Sequence[Float]) -> Prepared:
    """Return the recordings with spikes judged anew, beside the torque (N, J) that a model has on each; as they are
    where the same samples are spikes.
    """
    done = [item.beside(known) for item, known in zip(prepared.all, torques, strict=True)]
    if all(np.array_equal(entry.hidden, old.hidden) for entry, old in zip(done, prepared.all, strict=True)):
        return prepared
    kept = [finding for finding in prepared.findings if finding.check != SPIKES]
    findings = (*kept, *_outlier_findings(done, names(prepared.joints)))
    return replace(prepared.with_recordings(done), findings=findings)


def _check_cutoff(cutoff: float | None, even: Sequence[UniformSignals]) -> None:
    """Refuse a cut-off that is too fast for the slowest recording, or too slow for the shortest."""
    if cutoff is None:
        return
    slowest = min(e.rate for e in even)
    shortest = min(float(e.t[-1] - e.t[0]) for e in even)
    remedy = f"choose a cut-off between 0.5 and {0.4 * slowest:.3g} Hz, or leave the choice to exoid"
    if not 0.0 < cutoff <= 0.4 * slowest:
        what = f"a cut-off of {cutoff:g} Hz does not fit recordings sampled at {slowest:.4g} Hz"
        raise RecordingError(what, remedy=remedy)
    if cutoff * shortest < LEAST_CYCLES:
        what = f"a cut-off of {cutoff:g} Hz leaves nothing of a recording of {shortest:.3g} s"
        raise RecordingError(what, remedy=remedy)


def _refuse_free_swing(even: Sequence[UniformSignals]) -> None:
    """Refuse recordings in which no joint has a drive: all parameters may be doubled without a difference."""
    if any(recording.tau.any() for recording in even):
        return
    raise NotEnoughDataError(
        "every torque is zero: a free swing tells only ratios of parameters (inertia to weight, friction to inertia), "
        "because all of them may be doubled and the motion stays the same",
        where="the fitted recordings",
        remedy="fit it together with motion in which at least one joint is driven and its torque recorded; if a joint "
        "was driven, the torque columns are wrong (--map)",
    )


def _refuse_driven(recording: Recording) -> None:
    """Refuse a joint that was declared passive and whose torque changes about as much as that of a driven one."""
    turning = np.array([joint.turns for joint in recording.joints])  # a force is not compared with a torque
    tau = recording.tau[recording.valid][:, turning]
    called = [joint.name for joint in recording.joints if joint.turns]
    idle = np.array([name in recording.passive for name in called])
    if idle.all() or not idle.any() or not len(tau):
        return
    span = middle_range(tau)
    worst = index_of_greatest(np.where(idle, span, -1.0))
    if span[worst] > UNDRIVEN * span[~idle].max():
        joint = called[worst]
        raise RecordingError(
            f"the {joint} is declared passive, and its torque spans {span[worst]:.2g} N·m, the largest of the others "
            f"{span[~idle].max():.2g} N·m: it was driven",
            where=recording.name,
            remedy=f"leave --passive {joint} away, or check which column is which (--map)",
        )


def _check_base(model: Model, recordings: Sequence[Recording]) -> tuple[Finding, ...]:
    """Findings on the bases of recordings; RecordingError where a measured one is missing."""
    if not model.moving_base:
        turns = sum(unit == "rad" for unit in base_columns(model.joints).values())
        moved = [
            (recording, float(np.ptp(recording.base[recording.valid, :turns], axis=0).max()))
            for recording in recordings
            if recording.base is not None
        ]
        what = "the base turns by {:.2g} rad, and that of the model stands still"
        remedy = 'write [base] motion = "measured" into the model file'
        return tuple(
            Finding("base", "warning", what.format(turned), entry.source.path or entry.name, turned, SWAYS, remedy)
            for entry, turned in moved
            if turned > SWAYS
        )
    for item in recordings:
        if item.base is None:
            known = base_columns(model.joints)
            angles, others = ([n for n, unit in known.items() if (unit == "rad") == turns] for turns in (True, False))
            raise RecordingError(
                f"the recording has no {', '.join(angles)}, and the base of the model is measured",
                where=item.source.path or item.name,
                remedy=f"--map {','.join(f'{name}=COLUMN' for name in angles)} (rad; {', '.join(others)} in m/s² where "
                'there are any), or [base] motion = "fixed" where the base stood still',
            )
    return ()


def _outlier_findings(prepared: Sequence[PreparedRecording], joints: Sequence[str]) -> tuple[Finding, ...]:
    """Share of the torques that is hidden as spikes, a warning where it is more than a few, with the place."""
    shares = np.array([recording.outliers for recording in prepared])
    most = shares.max(axis=0)
    if most.max() < NOTED:
        return ()
    many = bool(most.max() > MANY)
    worst = _most_spikes(prepared[index_of_greatest(shares.max(axis=1))], joints) if many else EVERY
    told = ", ".join(f"{joint} up to {100 * share:.2g} %" for joint, share in zip(joints, most, strict=True))
    what = f"spikes of the torque were hidden before filtering ({told} of the samples)"
    remedy = "look at the torque sensor and its cable" + ("" if many else " if this is unexpected")
    severity, limit = ("warning", MANY) if many else ("repaired", NOTED)
    return (Finding(SPIKES, severity, what, worst, float(most.max()), limit, remedy),)


def _most_spikes(one: PreparedRecording, joints: Sequence[str]) -> str:
    """Place of most spikes in a recording: the joint, and the stretch of time that has most of them."""
    joint = index_of_greatest(one.outliers)
    first, last = np.quantile(one.times_of_spikes(joint), (0.1, 0.9))
    place = f"{one.name}, {joints[joint]}"
    if last - first > 0.6 * (one.motion.t[-1] - one.motion.t[0]):
        return f"{place}, all the time"
    return f"{place}, most of them from {first:.3g} to {last:.3g} s"
