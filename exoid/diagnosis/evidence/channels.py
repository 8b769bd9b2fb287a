"""Can the channels be what they say? If not, nothing is accepted: an effect named on top of them is nonsense.

Asked before the search: whether the encoders' noise leaves accelerations worth the name, whether a measured force is
turned round or was not tared, whether friction would have to drive a joint, whether the torque would fit far better if
it were read earlier, or as what a slow filter made of it, and whether anything but the angles made it. Asked of the
best model that the search finds: whether it leaves more of the torque than a third.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from exoid.diagnosis.evidence.channel_doubt import Doubt, left_share
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gram import left_of
from exoid.diagnosis.evidence.model_error import times_noise
from exoid.diagnosis.evidence.pushes import turned_force
from exoid.diagnosis.evidence.timing import late_torque
from exoid.diagnosis.rules import RULES, Rules
from exoid.measurement.finding import Finding
from exoid.measurement.stance import UPWARDS
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.optimisation.preparation.smoothed import FILTERED
from exoid.symbolic.joints import machine_word
from exoid.symbolic.motion import Float

TARED = "tared"
"""The check of recordings that says which force is not zero while nothing pushes."""
NOTHING_EXPLAINED = 0.9
"""Share of a torque's variance left from which its joint may have no drive; it only adds to what is advised."""


def doubts_before(
    base: FittedModel, rules: Rules = RULES, explained: Callable[[], float] = lambda: 0.0
) -> Doubt | None:
    """Doubt that makes a search pointless, judged with the model that is there; None where nothing does.

    `explained` returns what share of the squared error the best entry of the catalogue explains: one that leaves less
    than another timing of the torque is the nearer answer, as dry friction that builds up slowly.
    """
    return (
        _noisy_angles(base, rules)
        or turned_force(base, rules)
        or _untared(base)
        or _driven_by_friction(base)
        or _late(base, rules, explained)
        or _follows_the_angles(base, rules)
    )


def _untared(base: FittedModel) -> Doubt | None:
    """Recordings that have a measured force that is not zero while the foot is in the air: its load of every
    joint, which is not there, resembles a spring.
    """
    found = [finding for finding in base.prepared.findings if finding.check == TARED]
    if UPWARDS not in base.model.channels or not found:
        return None
    where = "; ".join(f"{item.where}: {item.what}" for item in found)
    remedies = "; ".join(dict.fromkeys(item.remedy for item in found))
    rule = f"{UPWARDS} is not zero while the foot is in the air"
    return Doubt(rule, f"A force was not tared: {where}.", remedies)


def filtered_angles(base: FittedModel, rules: Rules = RULES) -> Doubt | None:
    """Doubt where angles were filtered, the torques not, and the model leaves what that may have taken away; asked
    before anything outside is looked for.
    """
    prepared = base.prepared
    if not prepared.angles_were_filtered or np.all(base.evaluation_rms <= rules.near_noise * prepared.noise_floor):
        return None
    (filtered,) = [finding for finding in prepared.findings if finding.check == FILTERED]
    return Doubt(
        "the angles hold less noise than any sensor has, the torques do not, and the model leaves more than noise",
        f"{filtered.what[0].upper()}{filtered.what[1:]}. The torques were not: what a filter took out of the angles is "
        "missing in the model's torque, and looks like a delay, a soft drive or friction.",
        filtered.remedy,
    )


def _late(base: FittedModel, rules: Rules, explained: Callable[[], float]) -> Doubt | None:
    late = late_torque(base, rules)
    return None if late is not None and 1.0 - explained() < late.share else late


def doubts_after(base: FittedModel, last: FittedModel, rules: Rules = RULES) -> Doubt | None:
    """Doubt by which the best model that was found (`last`) is no answer, None without; `base` is the model that the
    search began with.
    """
    return _unexplained_torque(base, last, rules) or _impossible_base(base, last, rules) or _without_mass(last, rules)


def _noisy_angles(base: FittedModel, rules: Rules) -> Doubt | None:
    share = base.prepared.acceleration_noise
    if not share > rules.angle_noise:
        return None
    density = np.max([recording.angle_noise * 0.5 * recording.full_rate for recording in base.prepared.train], axis=0)
    size = " and ".join(f"{x:.2g}" for x in np.sqrt(density)) + f" rad at {' and '.join(base.model.joint_names)}"
    return Doubt(
        f"noise of the angles makes {100 * share:.0f} % of the accelerations, at {base.prepared.choice.cutoff:g} Hz",
        f"The angles are too noisy for their accelerations ({size}): at the slowest useful cut-off "
        f"noise makes {100 * share:.0f} % of them, so every inertia comes out too small by about that part, and "
        "whatever smooths the model looks like an effect.",
        "check the encoders and the columns of the angles; record faster motion, or repeat one periodic motion many "
        "times and use --derivative fourier",
    )


def _driven_by_friction(base: FittedModel) -> Doubt | None:
    """Doubt where friction of a joint, dry and viscous alike, drives it: its torque or angle has the wrong sign."""
    rigid, found = len(base.model.base().inertial), []
    for k, joint in enumerate(base.model.joints):
        dry, viscous = base.fit.estimates[rigid + 2 * k : rigid + 2 * k + 2]
        if dry.high < 0.0 and viscous.value < 0.0 and any(recording.driven[k] for recording in base.prepared.train):
            found.append((k, joint))
    if not found:
        return None
    names = " and ".join(joint.name for _, joint in found)
    units = {"N·m": "Nm"}
    options = ",".join(f"tau{k + 1}=-{units.get(joint.unit('tau'), joint.unit('tau'))}" for k, joint in found)
    angles = ",".join(f"q{k + 1}=-{joint.unit('q')}" for k, joint in found)
    return Doubt(
        f"dry and viscous friction of the {names} are negative, and the interval of the dry one excludes 0",
        f"Friction would have to drive the {names}, where friction can only brake: torque and angle are not counted in "
        "the same direction.",
        f"find out which has the other sign: --units {options} if the torque has, --units {angles} if the angle has",
    )


def _follows_the_angles(base: FittedModel, rules: Rules) -> Doubt | None:
    """Doubt where every torque is a function of the angles alone, and inertia and friction explain less than half of
    what these leave: a machine that is moved by hand while its drives carry its weight.
    """
    still, left = [_at_rest(base, recording) for recording in base.prepared.train], []
    for joint in range(len(base.model.joints)):
        tau, residual, rest = _left_beside(base, still, joint)
        if tau.size and tau.var() > 0.0:
            if rest.var() > rules.negligible * tau.var() or np.mean(residual**2) < rules.half * rest.var():
                return None
            left.append(rest.var() / tau.var())
    if not left:
        return None
    return Doubt(
        f"the angles alone explain all but {100 * max(left):.2g} % of the torques' variance, and inertia and friction "
        "less than half of that",
        "The torque follows from the angles alone, whichever way and however fast the joints move: neither inertia nor "
        "friction is in it. So it is when a machine is moved by hand while its drives carry its weight, or when the "
        "column is a command computed from the angles. What is left of it is no effect of the machine.",
        "record motion that the drives make, and log the torque that they produce",
    )


def _left_beside(fitted: FittedModel, columns: Sequence[Float], joint: int) -> tuple[Float, Float, Float]:
    """A torque where its joint moves in fitted motion, what the model leaves of it, and what `columns` (J, K, P) of
    each recording do.
    """
    train, residuals = fitted.prepared.train, fitted.residuals
    seen = [item.used[joint] & (item.driven[joint] and not item.standing[joint]) for item in train]
    tau, left, rows = (
        np.concatenate([part[joint][use] for part, use in zip(parts, seen, strict=False)])
        for parts in ([item.torque for item in train], residuals, columns)
    )
    return tau, left, left_of(rows, tau)


def _at_rest(base: FittedModel, one: PreparedRecording) -> Float:
    """Columns (J, K, P) of a recording's postures alone, without velocity and acceleration, and a column of ones."""
    zero = np.zeros(one.motion.q.shape)
    held = replace(one.motion, dq=zero, ddq=zero, sign=zero)
    columns = base.model.base().columns(held)
    return one.smooth_columns(np.concatenate([columns, np.ones((*columns.shape[:2], 1))], axis=2))


def _unexplained_torque(base: FittedModel, last: FittedModel, rules: Rules) -> Doubt | None:
    share = left_share(last)
    if not np.nanmax(share, initial=0.0) > rules.unexplained_share:
        return None
    parts = ", ".join(f"{joint} {100 * x:.0f} %" for joint, x in finite(share, last.model.joint_names))
    machine = machine_word(last.model.joints)
    odd = _odd_recordings(base, rules)
    files = " and ".join(odd)
    which = f" Fitted alone, {files} cannot be explained either, and the other recordings can." if odd else ""
    return Doubt(
        f"the best model leaves more than {100 * rules.unexplained_share:.0f} % of the variance of a torque: {parts}",
        f"The torque is not that of this {machine} in this motion: the best model that was found leaves {parts} of "
        f"its variance unexplained.{which} Nothing is named on top of that.",
        (f"begin with {files}: {COLUMNS}" if odd else COLUMNS) + _undriven(share, last.model.joint_names),
    )


def _undriven(share: Float, joints: Sequence[str]) -> str:
    """Advice if the joints of which next to nothing is explained, unlike others, have no drive; "" where none is so."""
    idle = [joint for joint, x in finite(share, joints) if x > NOTHING_EXPLAINED]
    if not idle or len(idle) == len(joints):
        return ""
    options = " ".join(f"--passive {joint}" for joint in idle)
    return f"; if the {' and the '.join(idle)} had no drive in these recordings, say so: {options}"


def _odd_recordings(base: FittedModel, rules: Rules) -> list[str]:
    """Return the names of recordings of which the model leaves much of the torque even if it is fitted to one alone,
    where it explains the others so; [] where they are alike, or most of them odd.
    """
    evidence, odd, every = base.evidence(seed=0, draws=0, rules=rules), [], base.prepared.all
    for k, (item, step) in enumerate(zip(every, evidence.alone.step, strict=True)):
        own = replace(base.prepared, train=(item,), verify=())
        share = left_share(replace(base, residuals=(evidence.left(k, step),), prepared=own))
        if np.nanmax(share, initial=0.0) > rules.unexplained_share:
            odd.append(item.name)
    return odd if 2 * len(odd) < len(every) else []


COLUMNS = (
    "check the columns and their order (--map), units (--units), the signs and zeros of angles and torques, and "
    "whether torque and motion are of the same run; draw them over time, or start with a slow motion of one joint"
)


def _impossible_base(base: FittedModel, last: FittedModel, rules: Rules) -> Doubt | None:
    """Doubt where an effect had to rescue a rigid machine that explains little and could not exist.

    One that leaves next to the noise, or little of the torque, with numbers that are possible, has not: a strong spring
    is no wrong channel.
    """
    share, wrong = left_share(base), _impossible(base)
    if not np.nanmax(share, initial=0.0) > rules.half or not wrong:
        return None
    near = np.all(last.evaluation_rms <= rules.near_noise * last.prepared.noise_floor)
    if not _impossible(last) and (near or np.nanmax(left_share(last), initial=0.0) <= rules.worth_telling):
        return None
    parts = ", ".join(f"{joint} {100 * x:.0f} %" for joint, x in finite(share, base.model.joint_names))
    machine = machine_word(base.model.joints)
    return Doubt(
        f"the rigid {machine} leaves {parts} of the torque's variance, and its numbers are impossible "
        f"({wrong[0].what})",
        f"The channels do not fit a {machine}: weight, inertia and friction together leave {parts} of the torque's "
        f"variance unexplained, with numbers that no {machine} has. What then explains the rest only makes up for a "
        "wrong sign, zero or column.",
        COLUMNS,
    )


def _impossible(fitted: FittedModel) -> list[Finding]:
    """Findings that the numbers are those of no machine."""
    return [
        f for f in fitted.fit.plausibility if f.severity == "warning" and f.check in ("bounds", "inertia", "realisable")
    ]


def _without_mass(last: FittedModel, rules: Rules) -> Doubt | None:
    """Doubt where a model near the noise explains every torque as well without weight and inertia, at every joint
    that moves: no machine is without mass, so the torque is another one, or these recordings do not carry an answer.
    """
    if np.any(times_noise(last) > rules.near_noise):
        return None
    model, train = last.model, last.prepared.train
    columns = [item.smooth_columns(last.unfiltered(k)[0])[:, :, len(model.inertial) :] for k, item in enumerate(train)]
    told = []
    for j, joint in enumerate(model.joints):
        tau, residual, without = _left_beside(last, columns, j)
        if not np.any(tau):
            continue
        share = 1.0 - float(np.sum(residual**2) / max(float(np.sum(without**2)), 1e-300))
        if share >= rules.worth_telling:
            return None
        told.append(f"{joint.name} {100 * max(share, 0.0):.1g} %")
    if not told:
        return None
    machine = machine_word(model.joints)
    return Doubt(
        f"weight and inertia explain less than {100 * rules.worth_telling:g} % of what friction leaves of every torque",
        f"No weight and no inertia show in the torques ({', '.join(told)} of what friction and the like leave), and no "
        f"{machine} is without: either these are not the torques of this {machine} (a column computed from the "
        "velocity looks so), or these recordings do not carry an answer: its mass asks for less than the noise.",
        "check what the torque columns hold; if they are right, record faster motion, or motion against gravity",
    )


def finite(share: Float, joints: Sequence[str]) -> Iterator[tuple[str, float]]:
    """Joints of which something can be left, with the share that is."""
    return ((joint, float(x)) for joint, x in zip(joints, share, strict=True) if np.isfinite(x))
