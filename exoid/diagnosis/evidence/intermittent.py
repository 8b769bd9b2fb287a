"""Does something that nobody measured act on the machine in part of the time: the ground under a foot, a hand?

Then the model as it stands, with numbers fitted to the rest of the time alone (least trimmed squares over windows),
leaves noise there; what is left otherwise is far from noise, comes and goes in every recording, and is no function of
the motion: neither with other numbers nor with smooth curves in angles and velocities is it predicted in a recording
that was left out, nor does an entry of the catalogue explain much of it. A stop, a bump or another load in part of the
time is one of these, and is the search's to find.
What moves every joint is the ground however well the motion predicts it, where one force upwards on the last link would
do it, or where it acts while that link's foot moves one way and not while it moves the other, as a foot on the ground
does: steps resemble each other, and soft ground is a spring at a height.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from exoid.diagnosis.evidence.best_effects import most_effects
from exoid.diagnosis.evidence.columns import stacked
from exoid.diagnosis.evidence.curves import splines_along
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gram import numbers_of
from exoid.diagnosis.evidence.model_error import LEAST_NOISE, is_near_noise
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.thresholds import Threshold
from exoid.ground.ties import index_of_greatest, index_of_least
from exoid.measurement.auditing.trimmed import Windows, joined, trimmed, windows_of
from exoid.optimisation.preparation.filtering import EDGE, PreparedRecording
from exoid.optimisation.preparation.noise import torque_noise
from exoid.symbolic.force import Force
from exoid.symbolic.joints import Joint, is_spatial
from exoid.symbolic.mechanics.newton_euler import STILL, BaseMotion
from exoid.symbolic.mechanics.pushed import placed_joints, pushed_torques
from exoid.symbolic.motion import Float

TIMES: Threshold = 3.0
"""times that it comes and goes in half of the recordings: a load hung up once"""
ADVICE = (
    "measure it: a force plate or an instrumented treadmill (columns grf_x, grf_z), cuffs with force sensors (f1, f2), "
    "or at least when it acts (a foot switch, column contact: 1 while it does); or record the motion without it, on a "
    "stand or with the foot in the air"
)
"""What to do about it."""
WINDOW = 0.1
"""s, of a window."""
LEAST, SELDOM = 0.1, 0.02
"""Parts of the windows that it must leave free, and that it must act in."""
FAINT = 1e-3
"""Part of the median error of a window that counts as none: logarithms have no zero."""
PLACES = tuple(np.linspace(0.05, 1.5, 30))
"""Where on the last link a force is tried, in lengths of the link above."""


@dataclass(frozen=True, eq=False)
class Intermittent:
    """Something outside the model that acts during `share` of the time, `seconds` long at a time, every `period` s.

    `torque` (J,) is its RMS while it acts, `quiet` (J,) that of the error meanwhile it does not, N·m; `force` says what
    force it would be, and `foot` what a foot does meanwhile, in words.
    """

    share: float
    seconds: float
    period: float
    torque: Float
    quiet: Float
    force: str
    foot: str

    @property
    def likeness(self) -> str:
        """The sign that it is told by, in words."""
        return "as the ground under a foot does" if self.force or self.foot else "and is no function of the motion"

    def sentence(self, joints: Sequence[Joint]) -> str:
        """Sentence for people: how often it acts, how long, and how large it is."""
        sizes = [
            ", ".join(f"{joint.name} {x:.3g} {joint.unit('tau')}" for joint, x in zip(joints, part, strict=True))
            for part in (self.torque, self.quiet)
        ]
        return (
            f"Something outside the model pushes in part of the time: about every {self.period:.2g} s, for "
            f"{self.seconds:.2g} s ({100 * self.share:.0f} % of the time). While it acts it makes {sizes[0]} "
            f"(RMS); the rest of the time the model as it is leaves {sizes[1]}, before any filter."
            + "".join(f" {said[0].upper()}{said[1:]}." for said in (self.force, self.foot) if said)
            + (f" Is it {'the ground under a foot' if self.force or self.foot else 'a person, or something touched'}?")
        )


@dataclass(frozen=True, eq=False)
class _View:
    """A recording before the common filter: columns (J, N, P), torque (J, N) without what is known, both over the noise
    of a sample, `scale` (J, 1) N·m, and which samples (J, N) are `seen`; windows are `length` samples long, the link
    above the last one `reach` m.
    """

    recording: PreparedRecording
    columns: Float
    tau: Float
    scale: Float
    seen: NDArray[np.bool_]
    length: int
    joints: tuple[Joint, ...]
    reach: float

    def pushed(self, there: NDArray[np.intp], way: Float, reach: float) -> Float:
        """Return the torques (K, J) that one newton one `way`, forwards and upwards, asks for `reach` m along the last
        link, at the samples `there` (K,).
        """
        motion, force = self.recording.motion, Force("foot", self.joints[-1].name, ("grf_x", "grf_z"))
        base = STILL if motion.base is None else BaseMotion(*motion.base[there].T)
        return pushed_torques(self.joints, motion.q[there], force, reach, np.tile(way, (len(there), 1)), base)


def intermittent(base: FittedModel, rules: Rules = RULES) -> Intermittent | None:
    """Torque that acts in part of the time of all recordings; None where nothing does, or little is left. An effect may
    act in part of the time as well, as friction does that some angles lack: it is a rival.
    """
    if is_near_noise(base, rules):
        return None
    sample = np.maximum(torque_noise(base.prepared.all), LEAST_NOISE)
    views = [_view(base, index, sample) for index in range(len(base.prepared.all))]
    parts = [windows_of(v.columns, v.tau, v.recording.motion.q, v.recording.motion.dq, v.seen, v.length) for v in views]
    windows = joined(parts)
    found = _quiet_part(windows, rules)
    if found is None:
        return None
    x, quiet = found
    losses = windows.losses(x[None])[0]
    level, away = float(np.mean(losses[quiet])), ~quiet
    ends = np.cumsum([len(part.first) for part in parts])[:-1]
    pairs = list(zip(views, parts, np.split(away, ends), strict=True))
    acts, calm = map(list, zip(*itertools.starmap(_spread, pairs), strict=True))
    episodes = [_episodes(act, view.recording.rate) for act, view in zip(acts, views, strict=True)]
    if np.mean([len(own) >= TIMES for own in episodes]) < 0.5:
        return None
    rest = [view.tau - view.columns @ x for view in views]
    own = [part * view.scale for part, view in zip(rest, views, strict=True)]
    joints, force, foot = views[0].joints, "", ""
    if len(joints) > 1 and joints[-1].turns and not is_spatial(joints):
        force, foot = _force(views, own, acts), _foot(views, acts, rules)
    far = rules.near_noise * float(np.sqrt(level))
    if not (force or foot) or np.any(_rms(views, rest, acts) < far):
        # What is now large and now small has no quiet part: windows are of two kinds where it has, and three quarters
        # of the other kind are far from it.
        far_away, size = np.quantile(losses[away], 0.25) > far**2, _logarithms(losses)
        between = float(np.var(np.where(quiet, size[quiet].mean(), size[away].mean())))
        two_kinds = between / max(float(np.var(size)), 1e-300) >= rules.most
        plain = far_away and all(map(len, episodes)) and two_kinds
        large = _rms(views, rest, acts) > rules.artefact * far
        if not plain or not np.any(large & _beyond_curves(base, x, acts, rules)):
            return None
        if most_effects(base, rules).model is not base.model:  # an entry of the catalogue explains much of it
            return None
    sizes = [_rms(views, own, chosen) for chosen in (acts, calm)]
    times = [each / view.recording.rate for view, each in zip(views, episodes, strict=True)]
    return Intermittent(
        share=float(np.mean(np.concatenate(acts))),
        seconds=float(np.median(np.diff(np.concatenate(times)))),
        period=float(np.median(np.concatenate([np.diff(each[:, 0]) for each in times]))),
        torque=sizes[0],
        quiet=sizes[1],
        force=force,
        foot=foot,
    )


def _view(base: FittedModel, index: int, sample: Float) -> _View:
    recording, (columns, known) = base.prepared.all[index], base.unfiltered(index)
    scale = (sample * np.sqrt(0.5 * recording.rate))[:, None]
    weight = 1.0 / scale
    seen = ~recording.hidden.T
    edge = int(EDGE * recording.rate)
    seen[:, :edge] = seen[:, len(recording.motion) - edge :] = False
    tau = (recording.wide_tau.T - known) * weight
    length = max(1, round(WINDOW * recording.rate))
    joints = placed_joints(base.model)
    reach = joints[-2:][0].length or base.model.thigh_length
    return _View(recording, columns * weight[:, :, None], tau, scale, seen, length, joints, reach)


def _quiet_part(windows: Windows, rules: Rules) -> tuple[Float, NDArray[np.bool_]] | None:
    """Return the numbers (P,) that explain part of the windows best, and which (M,) they explain; None where these are
    too few, or nearly all.
    """
    best = trimmed(windows, numbers_of)
    if best is None:
        return None
    x, quiet = _settled(windows, best[0], _lower)
    x, quiet = _settled(windows, x, lambda losses: losses <= rules.robust**2 * np.median(losses[_lower(losses)]))
    return (x, quiet) if LEAST < quiet.mean() < 1.0 - SELDOM else None


def _settled(
    windows: Windows, x: Float, chosen: Callable[[Float], NDArray[np.bool_]]
) -> tuple[Float, NDArray[np.bool_]]:
    """Return numbers (P,) and windows (M,) that are `chosen` by their losses at these numbers, which fit them best."""
    quiet = np.zeros(len(windows.power), dtype=bool)
    for _ in range(20):
        now = chosen(windows.losses(x[None])[0])
        if np.array_equal(now, quiet):
            break
        quiet = now
        x = windows.solved(quiet[None], numbers_of)[0]
    return x, quiet


def _lower(losses: Float) -> NDArray[np.bool_]:
    """Mask (M,) of the `losses` of the lower kind, if there are two kinds: each is as near as can be to its own mean of
    logarithms (2-means, which along a line is found exactly). What is hidden in the machine makes the error of the
    quiet part uneven; what pushes is of another size.
    """
    size = _logarithms(losses)
    ordered, lower = np.sort(size), np.arange(1, len(size))
    sums = np.cumsum(ordered)
    between = sums[:-1] ** 2 / lower + (sums[-1] - sums[:-1]) ** 2 / (len(size) - lower)
    return np.asarray(size <= ordered[index_of_greatest(between)])


def _logarithms(losses: Float) -> Float:
    return np.asarray(np.log(np.maximum(losses, FAINT * float(np.median(losses)) + 1e-300)))


def _spread(view: _View, part: Windows, away: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return at which samples (N,) it acts, a single window between two of the other kind being of theirs; and those of
    the windows in which it does not for certain.
    """
    samples = len(view.recording.motion)
    kind = np.full(samples // view.length + 1, -1)
    kind[part.first // view.length] = away
    known, filled = np.flatnonzero(kind >= 0), kind > 0
    if known.size:
        filled = filled[known[np.abs(np.arange(len(kind))[:, None] - known).argmin(axis=1)]]
    filled[1:-1] ^= (filled[1:-1] != filled[:-2]) & (filled[1:-1] != filled[2:])
    acts, calm = (np.repeat(chosen, view.length)[:samples] for chosen in (filled, kind == 0))
    return acts, calm & ~acts


def _episodes(acts: NDArray[np.bool_], rate: float) -> NDArray[np.int_]:
    """First sample of each time it acts and the first after it (E, 2); those at the ends of the recording, and short
    ones, are left out.
    """
    edges = np.flatnonzero(np.diff(acts)) + 1
    pairs = np.array([*itertools.pairwise(edges)], dtype=int).reshape(-1, 2)
    return pairs[acts[pairs[:, 0]] & (np.diff(pairs)[:, 0] >= WINDOW * rate)]


def _beyond_curves(base: FittedModel, x: Float, acts: list[NDArray[np.bool_]], rules: Rules) -> NDArray[np.bool_]:
    """Mask (J,) of the joints at which smooth curves in the angles and velocities beside other numbers of the model,
    fitted to the other recordings, leave a good part of what acts beside the numbers `x` (P,).
    """
    squares, count = replace(rules, robust=np.inf), len(base.model.joints)
    evidence = base.evidence(seed=0, draws=0, sigma=np.ones(count), rules=squares)
    asked = itertools.product(("q", "dq"), range(1, count + 1), range(count))
    found = [splines_along(base, f"{word}{k}", joint, "", rules.knots) for word, k, joint in asked]
    curves = stacked([item.columns for item in found if item is not None], count)
    moved = np.zeros(evidence.prior.size)
    moved[: len(x)] = x - base.linear
    left, whole = np.zeros((2, count))
    for unit, step, coefficients in evidence.held_out_fits(evidence.plain(curves), rules.curve_ridge):
        k, weight = evidence.units[unit]
        there = (weight > 0.0) & acts[k][base.prepared.all[k].kept]
        left += np.sum(evidence.left(k, step, curves[k], coefficients) ** 2 * there, axis=1)
        whole += np.sum(evidence.left(k, moved) ** 2 * there, axis=1)
    return np.asarray(left > rules.unexplained_share**2 * whole)


def _rms(views: list[_View], torques: list[Float], chosen: list[NDArray[np.bool_]]) -> Float:
    """Return the RMS (J,) of torques (J, N) over the `chosen` samples (N,) of all recordings that are seen."""
    masks = [view.seen & own for view, own in zip(views, chosen, strict=True)]
    square = np.sum([np.sum(x**2 * mask, axis=1) for x, mask in zip(torques, masks, strict=True)], axis=0)
    return np.asarray(np.sqrt(square / np.maximum(np.sum([mask.sum(axis=1) for mask in masks], axis=0), 1)))


def _foot(views: list[_View], acts: list[NDArray[np.bool_]], rules: Rules) -> str:
    """Direction in which a foot on the last link moves while it acts and not otherwise, in words; "" for none."""
    speeds, on = [], []
    for view, act in zip(views, acts, strict=True):
        there = np.flatnonzero(view.seen.all(axis=0))
        asked = view.pushed(there, np.array([1.0, 0.0]), view.reach)
        speeds.append(-np.sum(asked * view.recording.motion.dq[there], axis=1))  # what one newton forwards works at
        on.append(act[there])
    acting, speed = np.concatenate(on), np.concatenate(speeds)
    if not acting.any() or acting.all():
        return ""
    back = 0.5 * (np.mean(speed[acting] < 0.0) + np.mean(speed[~acting] > 0.0))
    if max(back, 1.0 - back) < rules.most:
        return ""
    way, other = ("backwards", "forwards") if back > 0.5 else ("forwards", "backwards")
    return f"a foot on the link after the {views[0].joints[-1].name} moves {way} while it acts, and {other} otherwise"


def _force(views: list[_View], own: list[Float], acts: list[NDArray[np.bool_]]) -> str:
    """The force on the last link that would do this, in words; "" where none would, or one that pulls downwards.

    Two joints are moved by a force at any point of a link alike: it is told for as far along as the link above is long.
    Three tell the point, the one at which a force leaves least.
    """
    joints = views[0].joints
    tried = [views[0].reach * part for part in (PLACES if len(joints) > 2 else (1.0,))]
    found = [_forces(views, own, acts, reach) for reach in tried]
    best = index_of_least([left for _, left in found])
    (force, left), reach = found[best], tried[best]
    size = np.abs(force[:, 1]).sum()
    up = float(np.maximum(force[:, 1], 0.0).sum() / max(size, 1e-300))
    if up < 0.9 or left > 0.1:
        return ""
    where = f"{reach:.2g} m along" if len(joints) > 2 else f"if it acts {reach:.2g} m along"
    return (
        f"one force on the link after the {joints[-1].name} would do it, {100 * up:.0f} % of its impulse upwards and "
        f"about {np.median(force[:, 1]):.2g} N, {where}: so the ground pushes a foot"
    )


def _forces(views: list[_View], own: list[Float], acts: list[NDArray[np.bool_]], reach: float) -> tuple[Float, float]:
    """Return the force (K, 2) on the last link, `reach` m along it, that comes nearest to what acts, and the share of
    its square that this leaves.
    """
    forces, whole, left = [], 0.0, 0.0
    for view, x, act in zip(views, own, acts, strict=True):
        there = np.flatnonzero(act & view.seen.all(axis=0))
        unit = np.stack([view.pushed(there, way, reach) for way in np.eye(2)], axis=2)
        tau, turn = x[:, there].T[:, :, None], unit.swapaxes(1, 2)
        found = np.linalg.solve(turn @ unit + 1e-9 * np.eye(2), turn @ tau)
        whole, left = whole + float(np.sum(tau**2)), left + float(np.sum((tau - unit @ found) ** 2))
        forces.append(found[:, :, 0])
    return np.concatenate(forces), left / max(whole, 1e-300)
