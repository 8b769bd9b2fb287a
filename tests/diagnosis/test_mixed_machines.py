"""Turning and sliding joints in one machine, chains and trees, in a plane and in space: every question is answered."""

from contextlib import suppress

import numpy as np
import pytest
from exoid.diagnosis.discover import discover
from exoid.diagnosis.trials.cases import singles

from exoid.diagnosis.evidence.fitted import fitted_model
from exoid.diagnosis.evidence.proxies import _bumps
from exoid.measurement.bench.simulation import Bench, BenchError, run_bench
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.joints import Joint, Origin
from exoid.symbolic.model import Model

ALL, DAILY = 50, ()
"""Machines, and those of every day."""


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


def recordings_of(seed):
    """A machine and runs of it: nothing is hidden in every third, in the others any effect at any joint."""
    rng, bench = np.random.default_rng(seed), Bench(duration=10.0)
    model = mixed_machine(rng)
    for hidden in map(str, rng.permutation(singles(model))) if seed % 3 else ((),):
        with suppress(BenchError):  # some effects are too much for some machines
            runs = [run_bench(model, effects=hidden, seed=seed, index=k, bench=bench) for k in range(3)]
            return model, [run.recording for run in runs]
    raise AssertionError("the bench moves no machine")


@pytest.mark.parametrize("seed", [pytest.param(k, marks=[] if k in DAILY else pytest.mark.slow) for k in range(ALL)])
def test_a_machine_of_both_kinds_of_joints_is_answered(seed):
    model, runs = recordings_of(seed)
    answer = discover(model, runs[:2], verify=runs[2:], seed=seed)
    assert answer.verdict and answer.sentence and all(one.name for one in answer.model.terms)


def test_curves_compete_with_an_effect_at_every_joint():
    """Bumps, in angles and positions, against a term with many numbers: their units are those of the joints."""
    model, runs = recordings_of(1)
    now = fitted_model(identify(model, prepare(model, runs).train, optimisers=()), prepare(model, runs))
    for joint in model.joints:
        bumps = _bumps(now, joint.name)
        assert {one.term.joint for one in bumps} == {joint.name} and len(bumps) == len(model.joints) + 1
        assert {one.term.parameters[0].unit for one in bumps} == {joint.unit("tau")}
