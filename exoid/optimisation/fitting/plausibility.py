"""Does the fit describe a leg that could exist? Findings in words, for someone who has to act on them.

Checked: every parameter against its physical bounds (friction cannot push), the mass matrix over the joint
range (a leg cannot have negative inertia in any posture), and whether some positive masses, lengths and
inertias could produce Φ1 to Φ4 at all.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exoid.ground.ties import index_of_least
from exoid.measurement.finding import Finding
from exoid.optimisation.linear.bodies import nearest_bodies
from exoid.optimisation.linear.links import nearest_links
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float, Motion
from exoid.symbolic.quantity import Estimate

POSTURES = 300
"""Postures of a machine of more than two joints in which its mass matrix is looked at."""


def check_plausibility(
    model: Model, linear: Float, estimates: Sequence[Estimate], shape: Float | None = None, *, realisable: bool = False
) -> tuple[Finding, ...]:
    """Findings of what is physically doubtful about `linear` (P,) with shape values (S,); none when all is well.

    `estimates` give the intervals: a value whose interval reaches the bound is called indistinguishable
    from it. `realisable` says that positive masses are known to have these numbers: at the edge of what is possible
    they are not easily found again.
    """
    found = _bounds(model, linear, estimates)
    inertial = [e for e in estimates if e.name.startswith("Phi")]
    if all(np.isfinite([e.low, e.high]).all() for e in inertial):  # else some are not known, and nothing is wrong
        found += _inertia(model, linear, shape)
        found += [] if realisable else _realisable(model, linear)
    return tuple(found)


def _bounds(model: Model, linear: Float, estimates: Sequence[Estimate]) -> list[Finding]:
    found = []
    for parameter, value, estimate in zip(model.parameters, linear, estimates, strict=False):
        low, high = parameter.min, parameter.max
        if low is not None and value < low:
            limit, below = float(low), True
        elif high is not None and value > high:
            limit, below = float(high), False
        else:
            continue
        word = "negative" if below and limit == 0.0 else f"{'below' if below else 'above'} {limit:g} {parameter.unit}"
        reaches = estimate.low <= limit <= estimate.high
        if reaches:
            verdict = f"but its 95 % interval reaches {limit:g}: these recordings cannot tell it from that"
            remedy = "record motion that excites it more, or leave it out"
        else:
            verdict = f"and its 95 % interval excludes {limit:g}"
            remedy = "a missing effect or a wrong sign hides in it: run `exoid diagnose`"
        value_text = f"{parameter.label} = {value:.4g} {parameter.unit}"
        what = f"{value_text} is {word}, which is physically impossible, {verdict}"
        severity = "info" if reaches else "warning"
        found.append(Finding("bounds", severity, what, parameter.name, float(value), limit, remedy))
    return found


def mass_matrix(model: Model, linear: Float, shape: Float | None, angles: Float) -> Float:
    """Return the mass matrix (N, J, J) in kg·m² at joint `angles` (N, J), from the model's own torque."""
    count = len(angles)
    still = np.zeros_like(angles)
    reference = linear if model.needs_reference else None

    def torque(joint: int | None) -> Float:
        acceleration = still.copy()
        if joint is not None:
            acceleration[:, joint] = 1.0
        motion = Motion(0.01 * np.arange(count, dtype=float), angles, still, acceleration, still)
        return np.asarray(model.columns(motion, shape, reference) @ linear)

    rest = torque(None)
    return np.stack([(torque(joint) - rest).T for joint in range(angles.shape[1])], axis=2)


def _postures(model: Model) -> Float:
    """Return postures (N, J) within the limits, of joints without any all round (rad) or up to 1 m to either side.

    The first joint stays in the middle: the mass matrix of a chain does not depend on it.
    """
    ends = []
    for joint in model.joints:
        limit = model.limits.get(joint.name)
        low, high = limit.angle if limit is not None else (-np.inf, np.inf)
        ends.append((low, high) if np.isfinite([low, high]).all() else (-np.pi, np.pi) if joint.turns else (-1.0, 1.0))
    low, high = np.array(ends).T
    share = np.full((61 if len(ends) < 3 else POSTURES, len(ends)), 0.5)
    if len(ends) == 2:
        share[:, 1] = np.linspace(0.0, 1.0, len(share))
    else:
        share[:, 1:] = np.random.default_rng(0).random((len(share), len(ends) - 1))
    return np.asarray(low + share * (high - low))


def _inertia(model: Model, linear: Float, shape: Float | None) -> list[Finding]:
    angles = _postures(model)
    mass = mass_matrix(model, linear, shape, angles)
    smallest = np.linalg.eigvalsh(0.5 * (mass + mass.transpose(0, 2, 1)))[:, 0]
    if np.all(smallest > 0.0):
        return []
    worst = index_of_least(smallest)
    moved = list(model.joints)[1:]
    where = f"in {np.mean(smallest <= 0.0):.0%} of all postures"
    if len(moved) == 1:
        bad = angles[smallest <= 0.0, 1]
        where = f"for {moved[0].name} angles from {bad.min():.2f} to {bad.max():.2f} {moved[0].unit('q')}"
    what = (
        f"the mass matrix is not positive definite {where}: "
        "the machine would gain energy by being accelerated, and a simulation of it diverges"
    )
    remedy = "record faster motion with more acceleration of every joint; check the filter cut-off"
    place = ", ".join(
        f"{joint.name} = {value:.2f} {joint.unit('q')}" for joint, value in zip(moved, angles[worst, 1:], strict=True)
    )
    return [Finding("inertia", "warning", what, place or "every posture", float(smallest[worst]), 0.0, remedy)]


def _realisable(model: Model, linear: Float) -> list[Finding]:
    """The leg's Φ comes from some positive m, l, I exactly when Φ2, Φ3 > 0 and Φ3²/Φ2 < Φ1 - Φ2 + min(0, Φ4).

    Reason: I_sh > 0 means m_sh a² > Φ3²/Φ2; I_th + m_th l_th² = Φ1 - Φ2 - m_sh a² and m_th a l_th = Φ4 + that
    must stay positive; a short thigh lever with a large mass then always leaves I_th > 0.
    """
    at = {p.name: i for i, p in enumerate(model.parameters)}
    if model.chain:
        return _links(model, linear)
    if any(name not in at for name in ("Phi1", "Phi2", "Phi3", "Phi4")):
        return []
    phi1, phi2, phi3, phi4 = (float(linear[at[f"Phi{i}"]]) for i in range(1, 5))
    remedy = "no masses and lengths can be computed from this fit; its torque prediction may still be good"
    for name, value in (("Phi2", phi2), ("Phi3", phi3)):
        if value <= 0.0 and model.parameters[at[name]].min is None:  # else _bounds has said it
            what = f"{name} = {value:.4g} kg·m², but a shank with mass has a positive one"
            return [Finding("realisable", "warning", what, name, value, 0.0, remedy)]
    if phi2 <= 0.0 or phi3 <= 0.0:
        return []
    room = phi1 - phi2 + min(0.0, phi4)
    if phi3**2 / phi2 < room:
        return []
    what = "no positive masses, lengths and inertias give Φ1 to Φ4 (Φ3²/Φ2 must be below Φ1 - Φ2 + min(0, Φ4))"
    return [Finding("realisable", "warning", what, "Phi1..Phi4", phi3**2 / phi2, room, remedy)]


def _links(model: Model, linear: Float) -> list[Finding]:
    """Say where no links of positive mass and inertia have the inertial parameters of a machine."""
    count = len(model.inertial)
    if any(p.min is not None and value <= p.min for p, value in zip(model.inertial, linear, strict=False)):
        return []  # `_bounds` has said it
    phi = np.asarray(linear[:count])
    if model.spatial:
        return [] if nearest_bodies(model, phi) is not None else [_no_bodies(count)]
    if nearest_links(model, phi) is not None:
        return []
    what = f"no links of positive mass and inertia have Φ1 to Φ{count}"
    remedy = "its torque prediction may still be good; --physical asks for the best fit that a machine can have"
    return [Finding("realisable", "warning", what, f"Phi1..Phi{count}", 0.0, 0.0, remedy)]


def _no_bodies(count: int) -> Finding:
    """Return the same of an arm in space. It is no warning: a hand's inertia is often smaller than its interval."""
    what = f"no bodies of positive mass and inertia have exactly Φ1 to Φ{count}"
    remedy = (
        "its torque prediction may still be good; --physical asks for the best fit that a machine can have, and faster "
        "motion of the last joints determines their small inertias"
    )
    return Finding("realisable", "info", what, f"Phi1..Phi{count}", 0.0, 0.0, remedy)
