"""Turning and sliding joints in one machine, chains and trees, in a plane and in space: every question is answered."""

from contextlib import suppress
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exoid.diagnosis.discovery import discover
from exoid.diagnosis.evidence.fitted import fitted_model
from exoid.diagnosis.evidence.proxies import _bumps
from exoid.diagnosis.hypotheses.readings import link_length
from exoid.ground.errors import ExpressionError
from exoid.measurement.bench.simulation import Bench, BenchError, run_bench
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic import Coefficient, Effect, Shape
from exoid.symbolic.effect_catalogue import catalogue
from exoid.symbolic.joints import Joint, Origin
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Motion
from exoid.symbolic.term import Term, places_of

ALL = 50
"""Machines."""


def mixed_machine(rng):
    """A machine of two or three joints, of both kinds, one hanging from another as chance has it."""
    count, spatial = int(rng.integers(2, 4)), bool(rng.integers(2))
    kinds = rng.permutation(["revolute", "prismatic", *rng.choice(["revolute", "prismatic"], count - 2)])
    joints = []
    for k, kind in enumerate(kinds):
        above = None if k < 2 else joints[int(rng.integers(k))].name
        more = {"length": 0.3} if not spatial else {}
        if spatial:
            axis = rng.normal(size=3)
            place = tuple(float(x) for x in rng.uniform(-0.3, 0.3, 3))
            more = {"axis": tuple(float(x) for x in axis / np.linalg.norm(axis)), "origin": Origin(place)}
        joints.append(Joint(f"j{k}", str(kind), parent=above, **more))
    return Model("mixed", joints=tuple(joints))


def catalogue_terms(model):
    """The name of every effect of the catalogue at every joint, but for what the base model holds already."""
    return [
        Term(effect, joint, model.joints).name
        for effect in catalogue(model.joints).values()
        for joint in places_of(effect, model.joints)
        if joint not in effect.absorbed_on
    ]


def recordings_of(seed):
    """A machine and runs of it: nothing is hidden in every third, in the others any effect at any joint."""
    rng, bench = np.random.default_rng(seed), Bench(duration=10.0)
    model = mixed_machine(rng)
    for hidden in map(str, rng.permutation(catalogue_terms(model))) if seed % 3 else ((),):
        with suppress(BenchError):  # some effects are too much for some machines
            runs = [run_bench(model, effects=hidden, seed=seed, index=k, bench=bench) for k in range(3)]
            return model, [run.recording for run in runs]
    raise AssertionError("the bench moves no machine")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(ALL))
def test_a_machine_of_both_kinds_of_joints_is_answered(seed):
    model, runs = recordings_of(seed)
    answer = discover(model, runs[:2], verify=runs[2:], seed=seed)
    assert answer.verdict and answer.sentence and all(one.name for one in answer.model.terms)


@pytest.mark.slow
def test_one_of_them_is_answered_in_every_run():
    """A cart that slides and a pole that hangs from it, an offset of the cart's force."""
    model = Model("cart", joints=(Joint("cart", "prismatic", axis=(1, 0, 0)), Joint("pole", axis=(0, -1, 0))))
    bench = Bench(duration=6.0)
    runs = [run_bench(model, effects="torque_offset:cart", seed=1, index=k, bench=bench).recording for k in range(3)]
    answer = discover(model, runs[:2], verify=runs[2:])
    assert answer.sentence


@pytest.mark.parametrize(
    ("text", "units", "joint"),
    [
        ("c * exp(-((theta2 - m)/w)**2)", ("N", "rad"), "cart"),
        ("c * exp(-((theta1 - m)/w)**2)", ("N·m", "m"), "pole"),
        ("c * dtheta2 * theta * tanh((theta - m)/w)", ("N·s/(m·rad)", "m"), "cart"),
    ],
)
def test_an_effect_of_ones_own_couples_a_sliding_joint_with_a_turning_one(text, units, joint):
    force, place = units
    shape = {"m": Shape(place, -1.0, 1.0), "w": Shape(place, 0.1, 1.0)}
    effect = Effect("own", "", text, None, (joint,), {"c": Coefficient(force)}, shape, custom=True)
    model = Model("cart", joints=(Joint("cart", "prismatic", axis=(1, 0, 0)), Joint("pole", axis=(0, -1, 0))))
    assert model.with_effect(effect, joint).parameters[-1].unit == force
    with pytest.raises(ExpressionError, match=r"comes out in|are added"):
        model.with_effect(replace(effect, coefficients={"c": Coefficient("A")}), joint)


def test_a_length_that_enters_squared_is_not_tried_as_a_number():
    """Behind a sliding joint the mass is a number of its own, and its inertia grows with the square of the length."""
    model = Model("crane", joints=(Joint("boom", length=0.4), Joint("reach", "prismatic", length=0.2), Joint("tip")))
    chain = Model("chain", joints=(Joint("a", length=0.4), Joint("b", length=0.3), Joint("c")))
    for machine, tried in ((model, ("reach",)), (chain, ("a", "b"))):
        motion = Motion(np.arange(5.0), *(np.ones((5, 3)) for _ in range(3)))
        entry = link_length.entry(machine, SimpleNamespace(misread=()))
        assert entry.joints == tried
        for joint in tried:  # refused where the torque is not linear
            assert machine.with_effect(entry, joint).columns(motion).any()


@pytest.mark.slow
def test_curves_compete_with_an_effect_at_every_joint():
    """Bumps, in angles and positions, against a term with many numbers: their units are those of the joints."""
    model, runs = recordings_of(1)
    now = fitted_model(identify(model, prepare(model, runs).train, optimisers=()), prepare(model, runs))
    for joint in model.joints:
        bumps = _bumps(now, joint.name)
        assert {one.term.joint for one in bumps} == {joint.name} and len(bumps) == len(model.joints) + 1
        assert {one.term.parameters[0].unit for one in bumps} == {joint.unit("tau")}
