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
    """Warn of angles that look like degrees or turns, of torques like mN·m or kN·m, and of slides like millimetres."""
    angles, torques, leg = [*channels(recording, "q")], [*channels(recording, "tau")], is_leg(recording.joints)
    found = []

    def add(column: str, what: str, value: float, limit: float, option: str) -> None:
        where, remedy = place(recording, column), f"say so with {option}, or write the unit into the header"
        consequence = "every parameter is wrong"
        found.append(Finding(CHECK, "warning", what, where, value, limit, remedy, consequence, "likely"))

    # Other machines come in all sizes. A leg is small in all joints where one unit too large was written for both.
    if leg and min(channel.values.size for channel in (*angles, *torques)) >= 10:
        swing, size = max(channel.span(2) for channel in angles), max(channel.largest for channel in torques)
        if 0.0 < swing < LITTLE:
            what = f"no joint swings further than {swing:.3g} rad: it looks like turns, or there is little motion"
            add("q1 and q2", what, swing, LITTLE, "--units q=turns")
        if 0.0 < size < WEAK:
            unit, option = ("MN·m", "MNm") if size < 1e-3 * WEAK else ("kN·m", "kNm")
            what = f"no torque reaches more than {size:.3g} N·m, which carries no leg: it looks like {unit}"
            add("tau1 and tau2", what, size, WEAK, f"--units tau={option}")
    for channel in angles:
        reach = channel.largest
        if reach > FAR and not channel.joint.turns:
            what = f"the {channel.label} reaches {reach:.4g} m: it looks like millimetres"
            add(channel.name, what, reach, FAR, f"--units {channel.name}=mm")
        elif reach > TURNS and leg:
            what = f"the {channel.label} reaches {reach:.4g} rad: it looks like degrees"
            add(channel.name, what, reach, TURNS, "--units q=deg")
    for channel in torques:
        usual = float(np.median(np.abs(channel.some))) if channel.values.size else 0.0
        if usual > STRONG and leg:
            what = f"the {channel.label} is {usual:.4g} N·m in the median: it looks like mN·m"
            add(channel.name, what, usual, STRONG, "--units tau=mNm")
    return found
