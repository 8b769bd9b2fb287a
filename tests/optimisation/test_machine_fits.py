"""Recordings of any machine are prepared and fitted: its numbers are found again, with proof."""

from dataclasses import replace

import numpy as np
import pytest

from exoid.ground.errors import RecordingError
from exoid.measurement.bench.simulation import Bench, run_bench
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.linear.loss import huber
from exoid.optimisation.linear.physical import physics
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model

DRIVE = Model("drive", joints=(Joint("drive"),))
CHAIN = Model("arm", joints=(Joint("shoulder", length=0.3), Joint("elbow")))
SLIDE = Model("slide", gravity=0.0, joints=(Joint("stage", "prismatic"),))


@pytest.mark.slow
@pytest.mark.parametrize("model", [DRIVE, SLIDE], ids=["drive", "slide"])
def test_the_numbers_of_the_bench_are_found_again(model):
    runs = [run_bench(model, seed=4, index=k, bench=Bench(duration=20.0)) for k in range(2)]
    fit = identify(model, [run.recording for run in runs], optimisers=(), physical=True)
    assert fit.certificate.holds and fit.to_json()["joints"] == list(model.joint_names)
    for estimate, true in zip(fit.estimates, runs[0].true.linear, strict=True):
        assert abs(estimate.value - true) < 0.1 * abs(true) + 1e-3, estimate
    assert len(fit.plot().axes) == 4


@pytest.mark.slow
@pytest.mark.parametrize("chain", [(Joint("hip", length=0.4), Joint("knee", length=0.4), Joint("ankle")), DRIVE.chain])
def test_the_best_possible_links_of_any_machine(chain):
    model = Model("machine", joints=chain)
    run = run_bench(model, seed=4, bench=Bench(duration=8.0)).recording
    last = np.eye(len(chain))[-1]
    wrong = replace(run, tau=run.tau - 1.2 * last * run.tau)  # the last drive seems to push the wrong way a little
    free = identify(model, [wrong], optimisers=())
    held = identify(model, [wrong], optimisers=(), physical=True)
    assert held.certificate.holds and held.certificate.gap < 1e-7 and held.held.cost > 0.0
    assert any("no links of positive mass" in text for text in held.held.broken)
    assert held.loss > free.loss
    possible = physics(model)
    numbers = possible.lift.start(held.linear)
    for one in possible.lift.inner.inequalities:  # rods are possible, and no better
        assert np.linalg.eigvalsh(one.matrix(numbers))[0] > 0.0
    rods = np.asarray(possible.lift.matrix @ numbers)
    assert huber(held.data.residual(rods), held.delta) > held.loss


@pytest.mark.slow
def test_links_that_cannot_be_are_told():
    run = run_bench(CHAIN, seed=4, bench=Bench(duration=8.0)).recording
    fit = identify(CHAIN, [replace(run, tau=run.tau * [1.0, -0.2])], optimisers=())
    assert any(finding.check in ("realisable", "inertia", "bounds") for finding in fit.plausibility)


def test_a_joint_that_rests_most_of_the_time_makes_no_outliers():
    run = run_bench(SLIDE, seed=1, bench=Bench(duration=20.0)).recording
    step = float(np.median(np.diff(run.t)))
    count = 3 * len(run)
    rng = np.random.default_rng(0)
    rest = run.q[-1] + 1e-7 * rng.standard_normal((count, 1)), run.tau[-1] + 0.1 * rng.standard_normal((count, 1))
    t = np.concatenate([run.t, run.t[-1] + step * np.arange(1, count + 1)])
    longer = replace(
        run, t=t, q=np.concatenate([run.q, rest[0]]), tau=np.concatenate([run.tau, rest[1]]), valid=None, row=None,
        angle_valid=None, torque_valid=None,
    )
    assert prepare(SLIDE, [longer], cutoff=6.0).train[0].outliers.max() < 0.15


def test_recordings_of_another_machine_are_refused():
    run = run_bench(DRIVE, seed=4, bench=Bench(duration=5.0)).recording
    with pytest.raises(RecordingError, match="machine with drive, the model has stage"):
        prepare(SLIDE, [run])
    unnamed = replace(run, joints=(Joint("joint1", length=1.0),))
    assert prepare(DRIVE, [unnamed]).joints == DRIVE.joints
