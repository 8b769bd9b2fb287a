"""Walking of other plants than the bench's, with a ground that nobody measured: contact is suspected, nothing accused.

The first is made as gait laboratories make it, by inverse dynamics of a person whose pelvis moves (Newton and Euler,
written without a look at the package), in a table as OpenSim writes it; the second walks in MuJoCo, whose solver
decides what hard and soft ground do to a foot. The hip stays where it is, so the foot slides, or grips and holds the
leg still until it slips.
"""

import numpy as np
import pytest

from exoid.diagnosis.discovery import discover
from exoid.measurement.bench.walk import Walk
from exoid.measurement.reading.read import read_recording
from exoid.symbolic.model import Model
from tests.walking import on_the_ground

NAMES = ("hip_flexion_r", "knee_angle_r", "hip_flexion_r_moment", "knee_angle_r_moment")
LEG = Model.standard()


def said(recordings):
    """What is said of recordings, the last one held out; nothing may be named, and no channel accused."""
    found = discover(LEG, recordings[:-1], recordings[-1:])
    assert found.verdict == "unexplained" and not found.accepted, found.sentence
    for word in ("convention", "wrong sign", "late", "swapped"):
        assert word not in found.sentence
    assert "outside the model pushes" in found.sentence
    assert "grf_z" in found.next_experiment
    return found.sentence


@pytest.mark.slow
@pytest.mark.parametrize("pelvis", [0.0, 0.5])
def test_inverse_dynamics_of_gait_is_a_foot_on_the_ground(tmp_path, pelvis):
    recordings = []
    for seed in range(3):
        one = on_the_ground(seed, noise=0.05, pelvis=pelvis)
        rows = np.column_stack([one.t, np.degrees(one.q), one.tau])
        head = f"Inverse Dynamics\nversion=1\nnRows={len(rows)}\nnColumns=5\ninDegrees=yes\nendheader\n"
        path = tmp_path / f"walk{seed}.sto"
        np.savetxt(path, rows, "%.8f", delimiter="\t", header=head + "\t".join(("time", *NAMES)), comments="")
        recordings.append(read_recording(path))
    assert "ground" in said(recordings)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("ground", "floor", "grip"),
    [("0.02 1", 0.86, 0.1), ("0.02 1", 0.87, 0.1), ("0.02 1", 0.86, 1.0), ("0.05 1", 0.86, 0.1), ("0.2 1", 0.86, 1.0)],
)
def test_mujocos_foot_on_hard_and_soft_ground_is_contact(monkeypatch, ground, floor, grip):
    pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install 'exoid[peers]'")
    from benchmarks import mujoco_leg

    monkeypatch.setattr(mujoco_leg, "random_trajectory", lambda rng, limits: Walk(stride=1.4).drawn(rng))
    leg = mujoco_leg.Leg(floor=floor, ground=ground, grip=grip)
    said([mujoco_leg.simulate(leg, 0, index)[0] for index in range(4)])
