"""A leg that walks on the bench: its strides, the ground under its foot, and what its recordings have of that."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from exoid.ground.errors import ExoidError
from exoid.measurement.bench.sensors import Sensors
from exoid.measurement.bench.simulation import Bench, BenchError, run_bench, simulate
from exoid.measurement.bench.walk import Walk
from exoid.measurement.bench.wearer import FOOT, Wearer
from exoid.measurement.recording import to_csv
from exoid.measurement.trajectories.trajectory import paper_trajectory
from exoid.symbolic.force import Force
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model

IDEAL = Bench(duration=6.0, sensors=Sensors.ideal(), walk=Walk())
WORN = replace(IDEAL, wearer=Wearer())


def test_speeds_and_accelerations_of_a_gait_are_those_of_its_angles():
    t = np.arange(0.0, 8.0, 1e-3)
    motion = Walk().drawn(np.random.default_rng(3)).at(t)
    inner = slice(5, -5)
    assert np.gradient(motion.q, t, axis=0)[inner] == pytest.approx(motion.dq[inner], abs=2e-3)
    assert np.gradient(motion.dq, t, axis=0)[inner] == pytest.approx(motion.ddq[inner], abs=2e-2)
    assert motion.q[:, 1].max() < 0.0 < motion.q[:, 0].max()


def test_no_two_strides_are_alike_and_the_foot_bears_load_in_stance_alone():
    t = np.arange(0.0, 60.0, 0.01)
    ground = Walk(stride=1.2, load=300.0, stance=0.6).drawn(np.random.default_rng(0)).ground(t)
    loaded = ground[:, 1] > 1.0
    assert loaded.mean() == pytest.approx(0.6, abs=0.05)
    assert np.abs(ground[~loaded]).max() < 2.0
    begins = np.flatnonzero(np.diff(loaded.astype(int)) == 1)
    assert np.diff(t[begins]).mean() == pytest.approx(1.2, rel=0.1) and np.diff(t[begins]).std() > 0.02
    peaks = [ground[a:b, 1].max() for a, b in pairwise(begins)]
    assert np.std(peaks) > 10.0 and np.mean(peaks) == pytest.approx(300.0, rel=0.2)


@pytest.mark.slow
def test_the_ground_closes_the_equation_of_motion():
    one = run_bench(seed=1, bench=IDEAL)
    x, z = one.recording.forces["grf_x"], one.recording.forces["grf_z"]
    q1, shank = one.motion.q[:, 0], one.motion.q.sum(axis=1)
    knee = FOOT * (np.cos(shank) * x + np.sin(shank) * z)
    hip = 0.40 * (np.cos(q1) * x + np.sin(q1) * z) + knee
    alone = replace(one.motion, force=np.zeros((len(one.motion), 2)))
    assert one.torque + np.column_stack([hip, knee]) == pytest.approx(one.true.torque(alone), abs=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("measured", "columns"),
    [
        (None, ["f1", "f2", "grf_x", "grf_z"]),
        (("cuffs",), ["f1", "f2"]),
        (("plate",), ["grf_x", "grf_z"]),
        (("cuffs", "switch"), ["f1", "f2", "contact"]),
        ((), []),
    ],
)
def test_recordings_have_the_columns_that_are_asked_for(measured, columns):
    whole, some = (run_bench(seed=2, bench=replace(WORN, measured=names)).recording for names in (None, measured))
    assert list(some.columns()) == ["t", "q1", "q2", "tau1", "tau2", *columns]
    assert np.array_equal(some.tau, whole.tau)
    if some.contact is not None:
        assert np.array_equal(some.contact > 0.0, whole.forces["grf_z"] > 5.0)


@pytest.mark.slow
def test_the_same_seed_walks_the_same_and_another_does_not():
    first, again, other = (to_csv(run_bench(seed=seed, bench=WORN).recording) for seed in (5, 5, 6))
    assert first == again != other


def test_what_is_simulated_for_use_leaves_stance_out_as_reading_does():
    bench = replace(IDEAL, measured=("switch",))
    used, whole = simulate(bench=bench, seed=2), run_bench(bench=bench, seed=2).recording
    assert whole.torque_valid.all()
    assert used.torque_valid.all(axis=1).mean() == pytest.approx(0.37, abs=0.08)
    assert any("stance" in finding.what for finding in used.findings)


def test_forces_of_a_model_file_keep_their_columns():
    model = Model.standard().with_forces(Force("sole", "knee", ("load",), 0.4, frame="vertical"))
    assert list(run_bench(model, seed=2, bench=IDEAL).recording.forces) == ["load"]


def test_what_makes_no_walk_is_refused():
    with pytest.raises(ExoidError, match="no sensor called 'plates'"):
        Bench(measured=("plates",))
    with pytest.raises(ExoidError, match="no ground under the foot"):
        simulate(bench=Bench(duration=4.0, wearer=Wearer(), measured=("switch",)))
    with pytest.raises(BenchError, match="hip and knee"):
        simulate(Model(joints=(Joint("axis"),)), bench=IDEAL)
    with pytest.raises(BenchError, match="no other motion"):
        simulate(bench=IDEAL, excitation=paper_trajectory())
    with pytest.raises(ExoidError, match="stance = -1"):
        Walk(stance=-1.0)
    with pytest.raises(ExoidError, match=r"0.5 to 10 s"):
        Walk(stride=0.1)
