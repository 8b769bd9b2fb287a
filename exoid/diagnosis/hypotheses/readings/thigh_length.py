"""Another thigh length than the model's.

The weight of the shank and its coupling with the thigh have the ratio g / a_th, so a wrong length is a weight of the
shank that the model lacks, k sin(θ1 + θ2) at both joints.
"""

from __future__ import annotations

from collections.abc import Sequence

from exoid.diagnosis.evidence.channel_doubt import Doubt
from exoid.diagnosis.hypotheses.readings import unchanged
from exoid.diagnosis.rules import Rules
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.fitting.thigh_length import COUPLING, has_a_length
from exoid.optimisation.preparation.prepare import Prepared
from exoid.symbolic.effect import Coefficient, Effect
from exoid.symbolic.model import Model

EFFECT = Effect(
    id="thigh_length",
    title="Another thigh length",
    explains="The weight of the shank does not fit its coupling with the thigh.",
    torque=dict.fromkeys(("hip", "knee"), "k * sin(theta1 + theta2)"),
    joints=("both",),
    machines="leg",
    coefficients={"k": Coefficient("N·m", explains="weight of the shank that the model lacks")},
    family="reading",
    custom=True,
)


def entry(model: Model, prepared: Prepared) -> Effect | None:
    """Return the entry where recordings can tell a length of the thigh."""
    return EFFECT if has_a_length(model, prepared) else None


def objection(fit: Fit, name: str, explained: float, rules: Rules) -> str:
    """Objection to a length that is practically that of the model."""
    return unchanged(abs(_lengths(fit, name)[0] / fit.model.thigh_length - 1.0), rules)


def _lengths(fit: Fit, name: str) -> tuple[float, float, float]:
    """Return the length that recordings want and the ends of its interval, m."""
    more, coupling = fit.estimate(f"{name}.k"), fit.estimate(COUPLING).value
    weight = fit.model.gravity / fit.model.thigh_length
    value, *ends = (fit.model.gravity / (weight + k / coupling) for k in (more.value, more.low, more.high))
    return value, min(ends), max(ends)


def what_is_wrong(fit: Fit, names: Sequence[str]) -> Doubt:
    """Doubt about the length, with the one that the recordings want."""
    value, low, high = _lengths(fit, names[0])
    return Doubt(
        f"another thigh length, {value:.3g} m, explains more than every entry of the catalogue, and more than its own "
        "placebos",
        f"The thigh length contradicts the recordings: they want {value:.3g} m ({low:.3g} to {high:.3g}), not the "
        f"{fit.model.thigh_length:g} m of the model. No effect is named on top of a wrong length.",
        f"measure the thigh; the recordings want [geometry] thigh_length = {value:.3g} in a model file",
    )
