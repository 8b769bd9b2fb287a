"""Torques of an arm far smaller than the masses in its robot file ask for: those of motors before their gears.

A fit cannot see it: links of a hundredth of the mass, with a hundredth of the friction, move alike under a hundredth of
the torque. So the torque that the file's masses would take is fitted to the measured one, beside friction and an
offset, joint by joint. Masses of a file are often guesses, wrong by a few times; a gear is far more.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from exoid.ground.text import digits
from exoid.ground.thresholds import Threshold
from exoid.measurement.auditing.channels import place_of_all
from exoid.measurement.auditing.power_left import motions_of
from exoid.measurement.auditing.rough import TURNS, Smooth
from exoid.measurement.finding import Finding
from exoid.measurement.reading.conventions import MOTORS
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import HERE, Joint, Vector, is_spatial
from exoid.symbolic.mechanics.base_parameters import Gravity, pull_of
from exoid.symbolic.mechanics.spatial import about_joint, joint_torques
from exoid.symbolic.motion import Float

MASSES = "masses"
"""What the finding is called."""
PARTS = 3
"""Parts of the recordings at least that have to agree."""
FAR: Threshold = 30.0
"""times smaller than the masses ask for, from which torques are taken for motors': masses that are guesses"""
ALIKE: Threshold = 4.0
"""times between what parts of the recordings say at most: torques in which masses have no part"""


def check_masses(recordings: Sequence[Recording], joints: tuple[Joint, ...], gravity: Gravity) -> tuple[Finding, ...]:
    """Warning where torques of an arm are far smaller than the masses of its robot file ask for."""
    # Where a `--convention` says already which side of the gears they are of, nobody need be told.
    said = any("motor" in name for entry in recordings for name in entry.conventions)
    moved = any(entry.base is not None or entry.payloads for entry in recordings)
    if said or moved or not is_spatial(joints) or not _possible(joints):
        return ()
    pull = pull_of(gravity)
    motions = motions_of(recordings, pull)
    if not motions:
        return ()
    count = math.ceil(PARTS / len(motions))
    shares = np.concatenate([_shares(motion, joints, pull, count) for motion in motions])
    least, most = shares.min(axis=0), shares.max(axis=0)
    alike = (least > 0.0) & (most < ALIKE * least)
    driven = np.array([joint.turns and joint.name not in recordings[0].passive for joint in joints])
    far = alike & (most < 1.0 / FAR) & driven
    if not far.any():
        return ()
    times = 1.0 / np.where(far, np.median(shares, axis=0), 1.0)
    times[~far] = np.median(times[far])  # of wrists masses say little: the file does not have their payload
    right = alike & (most > 1.0 / ALIKE)  # a log keeps one side of the gears
    geared = np.flatnonzero(driven & ~right).tolist()
    line = ",".join(f"{joints[k].name}-motor-torque={digits(float(times[k]), 2)}" for k in geared)
    option = f"{MOTORS}-torques" if all(joints[k].motor for k in geared) else line
    names, sizes = [joints[k].name for k in np.flatnonzero(far)], ", ".join(digits(float(x), 2) for x in times[far])
    torques, they = ("torques of {} are", "they look") if len(names) > 1 else ("torque of {} is", "it looks")
    what = f"the {torques.format(', '.join(names))} about {sizes} times smaller than the masses in the robot file ask "
    what += f"for: {they} like that of the motor, before the gear"
    remedy = f"if so, give --convention {option} (better with the ratios of the data sheet: these are as rough as the "
    remedy += f"masses); where the masses are wrong, --convention {names[0]}-motor-torque=1"
    where, most_times = place_of_all(recordings), float(times[far].max())
    consequence = "every parameter is wrong"
    return (Finding(MASSES, "warning", what, where, most_times, FAR, remedy, consequence, "likely"),)


def _possible(joints: Sequence[Joint]) -> bool:
    """True if the file has masses, of bodies no larger than the arm: 1 kg and 1 kg·m² stand for nothing known."""
    size = sum(math.hypot(*(joint.origin or HERE).xyz) for joint in joints[1:])
    bodies = [joint.body for joint in joints if joint.body]
    return bool(bodies) and all(
        body[4] + body[7] + body[9] < 2.0 * body[0] * size**2 and math.hypot(*body[1:4]) < size for body in bodies
    )


def _shares(motion: Smooth, joints: tuple[Joint, ...], pull: Vector, count: int) -> Float:
    """Share (parts, J) of the torques that the file's masses ask for in the measured ones, in each of `count` parts of
    a motion; zero where the masses ask for less than was measured.
    """
    q, dq, ddq, tau = (values[motion.keep].T for values in (motion.q, motion.dq, motion.ddq, motion.tau))
    asked = joint_torques(joints, pull, list(q), list(dq), list(ddq), np, [_numbers(joint) for joint in joints])
    seen = np.flatnonzero(motion.measured[motion.keep])
    found = np.zeros((count, len(joints)))
    for row, part in zip(found, np.array_split(seen, count), strict=True):
        for k, torque in enumerate(asked):
            wanted = np.broadcast_to(torque, q.shape[1])[part]
            if joints[k].turns and 0.0 < tau[k, part].std() < wanted.std():
                friction = [np.tanh(dq[k, part] / TURNS), dq[k, part], np.ones(len(part))]
                row[k] = np.linalg.lstsq(np.column_stack([wanted, *friction]), tau[k, part], rcond=None)[0][0]
    return found


def _numbers(joint: Joint) -> dict[str, float]:
    """Return the ten parameters of the link that a joint moves, as its file has them."""
    if not joint.body:
        return {}
    mass, x, y, z, xx, xy, xz, yy, yz, zz = joint.body
    return about_joint(mass, (x, y, z), ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))
