"""Planar trees of any size: Lagrange by columns against Newton and Euler, and what is left as a parameter."""

import casadi
import numpy as np
import pytest

from exoid.ground.errors import EffectError
from exoid.symbolic.codegen.translate import casadi_from_sympy
from exoid.symbolic.joints import Joint, ancestors, check_joints, parents
from exoid.symbolic.mechanics.base_parameters import base_parameters
from exoid.symbolic.mechanics.newton_euler import link_torques
from exoid.symbolic.mechanics.tree import tree_form


def chain(count):
    return tuple(Joint(f"j{k + 1}", length=0.3 + 0.05 * k) for k in range(count))


CART = (Joint("cart", "prismatic", length=0.1), Joint("pole"))
LEGS = (
    Joint("left_hip", length=0.42, parent="base"),
    Joint("left_knee"),
    Joint("right_hip", length=0.42, parent="base"),
    Joint("right_knee"),
)
FORK = (Joint("trunk", length=0.4), Joint("one", length=0.2), Joint("other", parent="trunk"))
ARM = (Joint("a", length=0.3), Joint("slide", "prismatic", length=0.2), Joint("b"))
MACHINES = [(chain(1), 9.81), (chain(2), 9.81), (chain(3), 9.81), (chain(3), 0.0), (chain(5), 9.81), (CART, 9.81),
            (LEGS, 9.81), (FORK, 9.81), (ARM, 9.81), ((Joint("drive", "prismatic"),), 0.0)]  # fmt: skip


@pytest.mark.parametrize(("joints", "gravity"), MACHINES, ids=range(len(MACHINES)))
def test_lagrange_and_newton_euler_agree(joints, gravity):
    form, count = tree_form(joints, gravity), len(joints)
    words = [f"{stem}{k + 1}" for stem in ("theta", "dtheta", "ddtheta") for k in range(count)]
    symbols = {word: casadi.SX.sym(word) for word in words}
    function = casadi.Function(
        "Y", [casadi.vertcat(*symbols.values())], [casadi.vertcat(*casadi_from_sympy(list(form.matrix), symbols))]
    )
    rng = np.random.default_rng(3)
    for _ in range(5):
        state = rng.normal(size=3 * count)
        found = np.asarray(function(state)).reshape(count, -1)
        links = link_torques(joints, gravity, *np.split(state, 3), np)
        wanted = np.array([links[p.link][p.kind] for p in form.parameters], dtype=float).T
        np.testing.assert_allclose(found, wanted, atol=1e-12 * max(1.0, np.abs(wanted).max()))


@pytest.mark.parametrize(("joints", "gravity"), MACHINES, ids=range(len(MACHINES)))
def test_base_parameters_carry_the_torque_of_any_masses(joints, gravity):
    rng = np.random.default_rng(4)
    links = [dict(zip("JXm", rng.uniform(0.1, 3.0, 3), strict=True)) for _ in joints]
    state = rng.normal(size=(3, len(joints), 7))
    torques = link_torques(joints, gravity, *state, np)

    def total(numbers):
        rows = {(k, kind): np.array([row + np.zeros(7) for row in torques[k][kind]]) for k, kind, _ in numbers}
        return sum(value * rows[k, kind] for k, kind, value in numbers)

    everything = [(k, kind, value) for k, one in enumerate(links) for kind, value in one.items()]
    base = [
        (p.link, p.kind, links[p.link][p.kind] + sum(factor * links[k][kind] for k, kind, factor in p.parts))
        for p in base_parameters(joints, gravity)
    ]
    np.testing.assert_allclose(total(base), total(everything), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    ("joints", "gravity", "formulas"),
    [
        (chain(1), 9.81, ["J_j1", "X_j1"]),
        (chain(1), 0.0, ["J_j1"]),
        (chain(2), 9.81, ["J_j1 + 0.09 m_j2", "X_j1 + 0.3 m_j2", "J_j2", "X_j2"]),
        ((Joint("drive", "prismatic"),), 0.0, ["m_drive"]),
        (CART, 9.81, ["m_cart + m_pole", "J_pole", "X_pole"]),
    ],
)
def test_what_a_motion_shows(joints, gravity, formulas):
    assert [p.formula(joints) for p in base_parameters(joints, gravity)] == formulas


def test_a_chain_has_two_parameters_per_joint():
    assert [len(base_parameters(chain(n), 9.81)) for n in (1, 2, 3, 4)] == [2, 4, 6, 8]


def test_who_hangs_from_whom():
    assert parents(LEGS) == (None, 0, None, 2)
    assert ancestors(FORK, 2) == (0, 2)


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        ((), "0 joints"),
        ((Joint("a"), Joint("b")), "the length of a is missing"),
        ((Joint("a", length=0.3), Joint("a")), "two joints called 'a'"),
        ((Joint("a", "helical"),), "unknown kind 'helical'"),
        ((Joint("a", length=-1.0),), "length is -1.0"),
        ((Joint("a", length=float("nan")),), "length is nan"),
        ((Joint("a", length=0.3, parent="b"), Joint("b")), "no joint 'b' before it"),
        ((Joint("both"),), "no joint can be called .both., which has a meaning"),
        ((Joint("a b"),), "is not a joint's name"),
    ],
)
def test_joints_that_make_no_machine(joints, message):
    with pytest.raises(EffectError, match=message):
        check_joints(joints)
