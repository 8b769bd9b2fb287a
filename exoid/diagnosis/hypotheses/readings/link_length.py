"""Another length of a link than `[[joints]]` say, on machines that are not the leg.

Base parameters contain inertia, first moment and mass of what hangs further out; how it couples with the links before
it is proportional to their lengths, and its weight is not. So a wrong length is a coupling that the model lacks.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from exoid.diagnosis.evidence.channel_doubt import Doubt
from exoid.diagnosis.hypotheses.readings import unchanged
from exoid.diagnosis.rules import Rules
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.preparation.prepare import Prepared
from exoid.symbolic.effect import Coefficient, Effect
from exoid.symbolic.joints import Joint, ancestors, parents
from exoid.symbolic.mechanics.base_parameters import base_parameters
from exoid.symbolic.model import Model
from exoid.symbolic.quantity import Estimate


def derive(mechanism: Any, symbols: Mapping[str, Any]) -> Any:
    """Return the machine with the longer link."""
    link = mechanism.links[mechanism.own]
    return mechanism.with_link(link.name, length=link.length + symbols["more"])


EFFECT = Effect(
    id="link_length",
    title="Another link length",
    explains="What hangs further out does not couple with this link as its weight says.",
    derive=derive,
    machines="others",
    coefficients={"more": Coefficient("m", explains="what the link is longer than the model says")},
    family="reading",
    custom=True,
)


def entry(model: Model, prepared: Prepared) -> Effect | None:
    """Return the entry at every link that carries another and enters linearly; None for the leg or if misread."""
    joints = model.chain
    carrying = {above for above in parents(joints) if above is not None}
    # Where the mass of what hangs further out is a number of its own (behind a sliding joint), a length enters squared.
    found = base_parameters(joints, model.pull, model.moving_base)
    squared = {k for item in found if item.kind == "m" for k in ancestors(joints, item.link)[:-1]}
    places = tuple(joint.name for k, joint in enumerate(joints) if k in carrying - squared and joint.length)
    return replace(EFFECT, joints=places) if places and not prepared.misread else None


def objection(fit: Fit, name: str, explained: float, rules: Rules) -> str:
    """Objection to a length that is practically that of the model."""
    more, link = _change(fit, name)
    return unchanged(abs(more.value) / float(link.length or 1.0), rules)


def _change(fit: Fit, name: str) -> tuple[Estimate, Joint]:
    """Length in m by which a link is longer than the model says, and the link."""
    link = name.partition(":")[2]
    return fit.estimate(f"{name}.more"), next(joint for joint in fit.model.joints if joint.name == link)


def what_is_wrong(fit: Fit, names: Sequence[str]) -> Doubt:
    """Doubt about lengths, with those that the recordings want."""
    wrong, mend = [], []
    for more, link in (_change(fit, name) for name in names):
        assumed = float(link.length or 0.0)
        value, low, high = (assumed + x for x in (more.value, more.low, more.high))
        wrong.append(
            f"The length of link {link.name} contradicts the recordings: they want {value:.3g} m ({low:.3g} to "
            f"{high:.3g}), not the {assumed:g} m of the model. "
        )
        mend.append(f'length = {value:.3g} at [[joints]] "{link.name}"')
    return Doubt(
        "another length of a link explains more than every entry of the catalogue, and more than its own placebos",
        f"{''.join(wrong)}No effect is named on top of a wrong length.",
        f"measure the link, from joint to joint; the recordings want {' and '.join(mend)} in the model file",
    )
