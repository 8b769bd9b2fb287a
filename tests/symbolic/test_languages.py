"""Every effect of the catalogue gives the same torque in NumPy, in CasADi's virtual machine and in compiled C."""

import numpy as np
import pytest

from exoid.symbolic import Model, Motion
from exoid.symbolic.codegen.kernel import compiled
from exoid.symbolic.effect_catalogue import catalogue

TERMS = [
    (effect.id, joint) for effect in catalogue().values() for joint in ((None,) if effect.on_both else effect.joints)
]


def gait(n=80):
    """A smooth motion inside Table 1, so that exponentials and end stops stay moderate."""
    t = np.cumsum(np.random.default_rng(5).uniform(0.008, 0.012, n))
    w = np.array([5.0, 7.0])
    centre, size = np.array([0.56, -0.92]), np.array([0.6, 0.6])
    phase = np.outer(t, w)
    return Motion(t, centre + size * np.sin(phase), size * w * np.cos(phase), -size * w**2 * np.sin(phase))


def compare(model, backend):
    motion = gait()
    linear = np.random.default_rng(6).normal(size=len(model.parameters))
    wanted, other = model.columns(motion, None, linear), compiled(model, backend)
    size = np.abs(wanted).max(axis=(0, 1)) + 1e-300
    assert np.abs((other.columns(motion, None, linear) - wanted) / size).max() < 1e-11
    tau = model.torque(motion, linear)
    assert other.inverse_dynamics(motion, linear) == pytest.approx(tau, rel=1e-10, abs=1e-10 * np.abs(tau).max())


@pytest.mark.parametrize(("effect", "joint"), TERMS)
def test_virtual_machine(effect, joint):
    compare(Model.standard().with_effect(effect, joint), "vm")


@pytest.mark.slow
def test_the_whole_catalogue_at_once_in_c():
    model = Model.standard()
    for effect, joint in TERMS:
        model = model.with_effect(effect, joint)
    compare(model, "auto")
