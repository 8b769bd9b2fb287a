"""Is a drive so soft that its encoder, at the motor, does not say where the link is?

The entry `motor_elasticity` predicts the twist from the motion of the encoder, to first order. Near the resonance of
link and drive that fails: there the motion of the encoder no longer determines that of the link. The measured torque
still does: what gear, belt or cable pass on is the torque without the friction before it, and the twist is that over
the stiffness. So the link's motion is found from both, and the rigid body is fitted to it:

    δ = argmin Σ (δ - c τ)² + (δ + c (K δ + D δ' + M δ'') - c τ_0)² ,

with τ the measured torque without friction, τ_0 the rigid-body torque at the encoder's motion, and K, D, M its slopes.
The first term is noisy above the resonance, the second one says nothing at it. A model made from a measured torque
predicts nothing, so this is no entry: it only says what the matter is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from exoid.diagnosis.evidence.enough_motion import little_motion
from exoid.diagnosis.evidence.fitted import FittedModel, pooled_rms
from exoid.diagnosis.evidence.gram import numbers_of
from exoid.diagnosis.evidence.swinging import swinging
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.minimum import minimum
from exoid.ground.ties import least_of
from exoid.measurement.signals.compiled import solved_banded
from exoid.symbolic.evaluation import carrying
from exoid.symbolic.language.torque import is_transform
from exoid.symbolic.motion import Float, slope_by

ENTRY = "motor_elasticity"
SOFTEST, STIFFEST, TRIED = 0.3, 6.0, 8
"""Resonances in Hz between which compliances are tried, and how many of them: above, the entry holds."""
REACH, CLOSE = 1.6, 0.005
"""Factor about the best one within which it is refined, and how closely."""
STATES = ("q", "dq", "ddq")
"""What a rigid-body torque has slopes by."""
ROUNDS = 2
"""Times that the numbers are fitted: friction and inertia enter the twist."""
NO_BETTER = 0.95
"""Share of the fitted squared error that the coarse search leaves, beyond which it ends there, for speed."""


@dataclass(frozen=True, eq=False)
class SoftDrive:
    """A drive at `joint` whose `compliance`, angle per torque, lets its link swing at `hertz`.

    Read so, the model leaves `after` (J,) N·m instead of `before` on the motion by which it is judged, and `fitted`
    (J,) on fitted motion; of what was more than noise it leaves the `share`. `sure` is the joint where the other
    joints' errors fall as well.
    """

    joint: str
    compliance: float
    hertz: float
    before: Float
    after: Float
    fitted: Float
    share: float = 1.0
    sure: bool = True

    @property
    def name(self) -> str:
        """Full name of the entry of the catalogue that comes nearest."""
        return f"{ENTRY}:{self.joint}"


def soft_drive(
    base: FittedModel, last: FittedModel, noise: Float, rules: Rules = RULES, follows: str | None = None
) -> SoftDrive | None:
    """Return the soft drive that explains far more than everything in `last`, None where there is none.

    `base` is the model the search began with, `noise` (J,) in N·m what nothing can explain, `follows` the joint whose
    error still follows a variable. Not asked of little motion, which some compliance fits by chance, nor where a model
    leaves no more than is near the noise, unless that follows something and effects have not explained nearly all.
    """
    asked = last.evaluation_rms > rules.near_noise * noise
    now, before = (np.maximum(item.evaluation_rms**2 - noise**2, 0.0) for item in (last, base))
    asked |= (now > (1.0 - rules.most) * before) & [name == follows for name in last.model.joint_names]
    # Of what swings by itself a link on a spring takes up much.
    if not asked.any() or little_motion(base.prepared, rules) or swinging(last) is not None:
        return None
    found = []
    added = {*last.model.effects} - {*base.model.effects}
    for fitted in (base, last) if added else (last,):
        for joint in range(len(last.model.joints)):
            drive = _best(fitted, joint)
            if drive is None:
                continue
            before = last.evaluation_rms
            falls = (drive.after**2 <= rules.half * base.evaluation_rms**2) | (base.evaluation_rms <= noise)
            others = np.arange(len(before)) != joint
            share = _share_left(drive.after[asked], before[asked], noise[asked])
            drive = replace(drive, before=before, share=share, sure=bool(falls[others].all()))
            beside = fitted is base and drive.name in added and len(added) > 1
            # What explains unseen motion better than the motion it was fitted to does so by chance.
            left = max(share, _share_left(drive.fitted[asked], last.train_rms[asked], noise[asked]))
            if left <= (rules.most if beside else rules.half) and np.all(drive.after <= drive.before * (1.0 + ~asked)):
                found.append(drive)
    return least_of(found, lambda one: one.share, 1.0) if found else None


def _share_left(after: Float, before: Float, noise: Float) -> float:
    """Return the share that is left of squared errors (J,) beyond their `noise`, each in units of that, together."""
    rest, whole = (float(np.sum(np.maximum((rms / noise) ** 2 - 1.0, 0.0))) for rms in (after, before))
    return rest / whole if whole > 0.0 else 1.0


def _best(fitted: FittedModel, joint: int) -> SoftDrive | None:
    """The drive at `joint` that leaves least of the fitted torque; None where none helps, and where the model has terms
    that change its mechanism or its whole torque.
    """
    train = fitted.prepared.train
    if fitted.model.derived or any(is_transform(term) for term in fitted.model.terms):
        return None
    if not any(recording.driven[joint] and not recording.standing[joint] for recording in train):
        return None
    links = [_Link(fitted, k, joint) for k in range(len(fitted.prepared.all))]
    # What the torque rises by with the acceleration, at the median of the motion.
    inertia = float(np.median(np.concatenate([link.slopes(fitted.linear)[2] for link in links])))
    if not inertia > 0.0:
        return None
    count, scale = len(train), np.maximum(fitted.train_rms, 1e-12)

    def cost(compliance: float, rounds: int = ROUNDS) -> float:
        left = _left(links[:count], count, compliance, scale, fitted.linear, rounds)
        return float(np.mean((pooled_rms(left, train) / scale) ** 2))

    tried = ((2.0 * np.pi * hertz) ** -2.0 / inertia for hertz in np.geomspace(SOFTEST, STIFFEST, TRIED).tolist())
    least, coarse = min((cost(compliance, 1), compliance) for compliance in tried)
    if least > NO_BETTER:
        return None
    low, high = float(np.log(coarse / REACH)), float(np.log(coarse * REACH))
    compliance = float(np.exp(minimum(lambda x: cost(float(np.exp(x))), low, high, CLOSE)[0]))
    left, every = _left(links, count, compliance, scale, fitted.linear), fitted.prepared.all
    judged = slice(count, None) if fitted.verified else slice(0, count)
    return SoftDrive(
        joint=fitted.model.joint_names[joint],
        compliance=compliance,
        hertz=float((compliance * inertia) ** -0.5 / (2.0 * np.pi)),
        before=fitted.evaluation_rms,
        after=pooled_rms(left[judged], every[judged]),
        fitted=pooled_rms(left[:count], train),
    )


class _Link:
    """One recording and the link behind one drive in it, beside the shape values of a fitted model."""

    def __init__(self, fitted: FittedModel, index: int, joint: int) -> None:
        self.model, self.one, self.joint = fitted.model, fitted.prepared.all[index], joint
        self.shape, self.motion = fitted.shapes[index], self.one.motion
        self.inertial = slice(0, len(self.model.inertial))
        self.reference = fitted.linear if self.model.needs_reference else None
        self.bare, self.only = self.model.base(), np.eye(self.motion.q.shape[1])[joint]
        self.own = self.bare.whole_columns(self.motion)[joint]

    @cached_property
    def still(self) -> Float:
        """The filtered columns (J, K, P), or (J, K, P + 1) with measured forces, with the link where the encoder is."""
        return self.one.smooth_columns(self.model.whole_columns(self.motion, self.shape, self.reference))

    @cached_property
    def bends(self) -> Float:
        """Derivatives (3, N, P) of the joint's rigid-body columns by its angle, velocity and acceleration."""
        slopes = (slope_by(self.bare.columns, self.motion, state, self.joint) for state in STATES)
        return np.array([slope[self.joint, :, self.inertial] for slope in slopes])

    def slopes(self, linear: Float) -> Float:
        """Return the derivatives (3, N) of the joint's rigid-body torque by its angle, velocity and acceleration."""
        return np.asarray(self.bends @ self._carried(linear)[self.inertial])

    def _carried(self, linear: Float) -> Float:
        """Return the numbers of the bare model among `linear` (P,), known loads included."""
        return carrying(self.bare, self.motion, linear[: self.bare.base_count])

    def read(self, compliance: float, linear: Float) -> tuple[Float, Float]:
        """Return the filtered columns (J, K, P) where the link stands behind its twist, and the torque (J, K) that they
        must explain; `linear` (P,) are the numbers that the twist is found with.
        """
        own, carried, rate = self.own, self._carried(linear), self.one.rate
        outside = slice(self.inertial.stop, None)
        load = self.one.wide_tau[:, self.joint] - own[:, outside] @ carried[outside]
        rigid = own[:, self.inertial] @ carried[self.inertial]
        turned = twist(load, rigid, self.slopes(linear), compliance, rate)[:, None]
        speed, rise = np.gradient(turned, 1.0 / rate, axis=0), np.zeros_like(turned)
        rise[1:-1] = (turned[2:] - 2.0 * turned[1:-1] + turned[:-2]) * rate**2  # as the twist was found with
        at, only = self.motion, self.only
        link = replace(at, q=at.q - turned * only, dq=at.dq - speed * only, ddq=at.ddq - rise * only)
        columns = self.still.copy()
        columns[:, :, self.inertial] = self.one.smooth_columns(self.bare.columns(link)[:, :, self.inertial])
        known = columns @ carrying(self.model, at, np.zeros(len(linear)))
        return columns[:, :, : len(linear)], self.one.torque - known


def _left(
    links: Sequence[_Link], count: int, compliance: float, scale: Float, linear: Float, rounds: int = ROUNDS
) -> list[Float]:
    """Residual (J, K) of every recording at the numbers that fit the first `count` best."""
    own = f"{ENTRY}:{links[0].model.joint_names[links[0].joint]}"
    free = np.array([entry.term != own for entry in links[0].model.parameters])
    linear = np.where(free, linear, 0.0)  # the twist is not in the model a second time
    weights = [link.one.used / scale[:, None] ** 2 for link in links[:count]]
    for _ in range(rounds):
        pairs = [link.read(compliance, linear) for link in links]
        gram = slope = np.zeros(())
        for (columns, wanted), weight in zip(pairs, weights, strict=False):  # the first, which are fitted
            rows = columns[:, :, free].reshape(weight.size, -1)
            weighted = rows * weight.reshape(-1, 1)
            gram, slope = gram + weighted.T @ rows, slope + weighted.T @ wanted.ravel()
        linear = np.zeros(len(linear))
        linear[free] = numbers_of(gram, slope)
    return [wanted - columns @ linear for columns, wanted in pairs]


def twist(load: Float, rigid: Float, slopes: Sequence[Float] | Float, compliance: float, rate: float) -> Float:
    """Return the twist (N,) that both the measured `load` (N,) and the link's equation of motion want.

    `rigid` (N,) is the rigid-body torque at the encoder's motion, `slopes` its derivatives (N,) by angle, velocity and
    acceleration, `compliance` in rad/(N·m), `rate` in Hz.
    """
    by_angle, by_speed, by_acceleration = (compliance * slope for slope in slopes)
    below, above = (by_acceleration * rate**2 + side * 0.5 * by_speed * rate for side in (-1.0, 1.0))
    middle, wanted = 1.0 + by_angle - 2.0 * by_acceleration * rate**2, compliance * rigid
    for row in (below, middle, above, wanted):  # at both ends only the load is asked
        row[[0, -1]] = 0.0
    banded = np.zeros((3, len(load)))
    banded[2] = 1.0 + middle**2
    banded[2, :-1] += below[1:] ** 2
    banded[2, 1:] += above[:-1] ** 2
    banded[1, 1:] = middle[:-1] * above[:-1] + below[1:] * middle[1:]
    banded[0, 2:] = below[1:-1] * above[1:-1]
    right = compliance * load + middle * wanted
    right[:-1] += below[1:] * wanted[1:]
    right[1:] += above[:-1] * wanted[:-1]
    return solved_banded(banded, right)
