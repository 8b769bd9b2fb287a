"""A link that does not stand where its encoder says, as torque texts.

Where the link of joint n stands at θ_n - δ(t), the rigid-body torque is that of the machine there, so the torques of
all joints above and below it change.
To first order in δ,

    Δτ_i = -(∂τ_i/∂θ_n δ + ∂τ_i/∂θ_n' δ' + ∂τ_i/∂θ_n'' δ'') ,

with τ the rigid-body torque of the model, never a measured one. Friction is that of motor and gear, which turn with the
encoder: it stays as it is. The derivatives are words of their own, `tau1_by_theta2` for ∂τ_1/∂θ_2.

Above the resonance of leg and spring the expansion has no meaning, and δ'' is mostly the noise of the encoders; so δ is
taken without what is faster than SLOW.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

from exoid.symbolic.joints import LEG, MOST, Joint, ancestors

STATES = ("theta", "dtheta", "ddtheta")
"""The states of a joint, in the order in which derivatives by them are listed."""

_NUMBERS = range(1, MOST + 1)
SLOPES = frozenset(f"tau{i}_by_{state}{n}" for i in _NUMBERS for state in STATES for n in _NUMBERS)
"""Words for the derivatives of the rigid-body torque."""

SLOW = 3.0
"""Hz; the motion of a leg is slower, the resonance of a drive that is worth a term hardly below."""

_OWN = re.compile(r"\b(theta|dtheta|ddtheta|tau_rigid|tau_model)\b")


def deflected(
    deflection: Mapping[str, str], joint: int, joints: Sequence[Joint] = LEG
) -> Iterator[tuple[int, str]]:
    """Yield (joint index, torque text) of every joint that feels it for a link at `joint` (index) that is deflected.

    These are the joints above and below it. `deflection` gives for each coefficient the angle in rad that one unit of
    it makes; its words for the own joint mean `joint`.
    """
    angles = {key: _OWN.sub(rf"\g<1>{joint + 1}", text) for key, text in deflection.items()}
    related = [k for k in range(len(joints)) if k in ancestors(joints, joint) or joint in ancestors(joints, k)]
    for number in (k + 1 for k in related):
        slopes = [f"tau{number}_by_{state}{joint + 1}" for state in STATES]
        parts = []
        for key, angle in angles.items():
            smooth = f"slow({angle}, {SLOW:g})"
            rates = (smooth, f"ddt({smooth})", f"ddt(ddt({smooth}))")
            parts.append(f"-{key} * (" + " + ".join(f"{s} * {r}" for s, r in zip(slopes, rates, strict=True)) + ")")
        yield number - 1, " ".join(parts)
