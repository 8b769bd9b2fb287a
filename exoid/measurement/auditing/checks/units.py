"""Sizes that no leg has in SI units."""

from __future__ import annotations

import numpy as np

from exoid.ground.thresholds import Threshold
from exoid.measurement.auditing.channels import channels, place
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import is_leg

CHECK = "units"
"""What these findings are called."""
TURNS: Threshold = 4 * np.pi
"""rad: a link that swings right over (2π and a little more) would be taken for degrees"""
EACH: Threshold = np.pi
"""rad, reached by every angle that is read in degrees: one in rad beside it would be as well"""
ROUND: Threshold = 270.0
"""degrees that a limb reaches at most, from any zero: counts of an encoder would be read so"""
STRONG: Threshold = 1000.0
"""N·m, as a median: the torque of a strong drive would be taken for mN·m"""
WEAK: Threshold = 0.1
"""N·m, reached by the stronger torque: the smallest rig would be taken for kN·m"""
FAR: Threshold = 20.0
"""m: a long slide would be taken for millimetres"""
LITTLE: Threshold = 0.3
"""rad, over which the joint that moves most swings: a small motion would be taken for turns"""


def check(recording: Recording) -> list[Finding]:
    """Warn of angles beyond two turns (degrees?) or very small ones (turns?), and of torques beyond 1000 N·m (mN·m?)
    or far too small for a leg (kN·m?).
    """
    found = _too_small(recording)
    for channel in channels(recording, "q"):
        reach = channel.largest
        if reach > FAR and not channel.joint.turns:
            what = f"the {channel.label} reaches {reach:.4g} m: it looks like millimetres"
            found.append(_finding(recording, channel.name, what, reach, FAR, f"--units {channel.name}=mm"))
        elif reach > TURNS and is_leg(recording.joints):
            what = f"the {channel.label} reaches {reach:.4g} rad: it looks like degrees"
            found.append(_finding(recording, channel.name, what, reach, TURNS, "--units q=deg"))
    for channel in channels(recording, "tau"):
        usual = float(np.median(np.abs(channel.some))) if channel.values.size else 0.0
        if usual > STRONG and is_leg(recording.joints):
            what = f"the {channel.label} is {usual:.4g} N·m in the median: it looks like mN·m"
            found.append(_finding(recording, channel.name, what, usual, STRONG, "--units tau=mNm"))
    return found


def _too_small(recording: Recording) -> list[Finding]:
    """Return a finding for every quantity that is smaller in all joints than in any leg: one unit too large was written
    for both.
    """
    angles, torques = list(channels(recording, "q")), list(channels(recording, "tau"))
    # Other machines come in all sizes.
    if not is_leg(recording.joints) or min(channel.values.size for channel in (*angles, *torques)) < 10:
        return []
    found = []
    swing = max(channel.span(2) for channel in angles)
    if 0.0 < swing < LITTLE:
        what = f"no joint swings further than {swing:.3g} rad: it looks like turns, or there is little motion"
        found.append(_finding(recording, "q1 and q2", what, swing, LITTLE, "--units q=turns"))
    size = max(channel.largest for channel in torques)
    if 0.0 < size < WEAK:
        unit, option = ("MN·m", "MNm") if size < 1e-3 * WEAK else ("kN·m", "kNm")
        what = f"no torque reaches more than {size:.3g} N·m, which carries no leg: it looks like {unit}"
        found.append(_finding(recording, "tau1 and tau2", what, size, WEAK, f"--units tau={option}"))
    return found


def _finding(recording: Recording, column: str, what: str, value: float, limit: float, option: str) -> Finding:
    where, remedy = place(recording, column), f"say so with {option}, or write the unit into the header"
    return Finding(CHECK, "warning", what, where, value, limit, remedy, "every parameter is wrong", "likely")
