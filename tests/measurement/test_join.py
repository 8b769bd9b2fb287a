"""One trial in two files with clocks of their own."""

import numpy as np
import pytest

from exoid.ground.errors import RecordingError
from exoid.measurement.reading.read import read_recording
from exoid.measurement.reading.resample import onto


def trial(seconds=40.0, seed=1):
    """Functions of time: angles (N, 2) and torques (N, 2) of a pendulum that never repeats itself."""
    rng = np.random.default_rng(seed)
    phases, rates = rng.uniform(0, 6, (2, 4)), rng.uniform(0.6, 3.5, (2, 4))

    def q(t):
        waves = [sum(0.25 * np.sin(r * t + p) for r, p in zip(rates[j], phases[j], strict=True)) for j in (0, 1)]
        return np.column_stack([0.5 + waves[0], -0.9 + waves[1]])

    def tau(t):
        h = 1e-3
        v, a = (q(t + h) - q(t - h)) / (2 * h), (q(t + h) - 2 * q(t) + q(t - h)) / h**2
        here = q(t)
        knee = 0.6 * a.sum(axis=1) + 10 * np.sin(here.sum(axis=1)) + v[:, 1] + np.tanh(v[:, 1] / 0.02)
        return np.column_stack([2 * a[:, 0] + 30 * np.sin(here[:, 0]) + 2 * v[:, 0] + knee, knee])

    return q, tau


def write(path, t, values, names):
    rows = np.column_stack([t, values])
    path.write_text("t," + names + "\n" + "\n".join(",".join(f"{x:.9g}" for x in row) for row in rows) + "\n")
    return path


def files(tmp_path, shift, offset=0.0, clock=0.0, seconds=40.0):
    """Angles at 100 Hz from 0 s, torques at 250 Hz from `offset` s, whose clock reads `shift` s more."""
    rng = np.random.default_rng(2)
    q, tau = trial()
    t, late = np.arange(0, seconds, 0.01), np.arange(offset, offset + seconds, 0.004)
    motion = write(tmp_path / "mocap.csv", t, q(t) + 1e-4 * rng.normal(size=(t.size, 2)), "hip_angle,knee_angle")
    torque = write(
        tmp_path / "torque.csv", late + shift + clock, tau(late) + 0.2 * rng.normal(size=(late.size, 2)),
        "hip_torque,knee_torque",
    )  # fmt: skip
    return motion, torque, tau(t), t


@pytest.mark.parametrize("shift", [0.0, 0.352, -7.13, 5000.0])
def test_the_lag_that_physics_says(shift, tmp_path):
    motion, torque, wanted, _ = files(tmp_path, shift, offset=3.0)
    recording = read_recording(motion, join=[torque])
    (said,) = [f for f in recording.findings if f.check == "join"]
    assert abs(said.value - shift) < 0.01 and "95 %" in said.what
    good = recording.complete
    assert recording.valid.all() and not good[:290].any() and good[400:3900].mean() > 0.95
    assert np.sqrt(np.mean((recording.tau[good] - wanted[good]) ** 2)) < 0.5


def test_the_recording_may_be_the_one_with_the_torques(tmp_path):
    motion, torque, _, t = files(tmp_path, 0.352)
    recording = read_recording(torque, join=[motion])
    assert len(recording) == t.size
    assert abs(next(f for f in recording.findings if f.check == "join").value - 0.352) < 0.01


def test_a_lag_that_is_given_is_taken_and_checked(tmp_path):
    motion, torque, _, _ = files(tmp_path, 0.352)
    recording = read_recording(motion, join=[(torque, 0.1)])
    (said,) = [f for f in recording.findings if f.check == "join"]
    assert said.severity == "warning" and "given lag of 0.1 s" in said.what and "0.35" in said.what


def test_clocks_since_1970_are_believed_and_checked(tmp_path):
    motion, torque, wanted, t = files(tmp_path, 0.0, offset=2.0, clock=1.7e9)
    q, _ = trial()
    rows = "\n".join(f"{1.7e9 + a:.4f},{b:.9g},{c:.9g}" for a, (b, c) in zip(t, q(t), strict=True))
    motion.write_text("timestamp,hip_angle,knee_angle\n" + rows + "\n")
    text = torque.read_text().splitlines()
    late = np.arange(2.0, 42.0, 0.004)
    body = [f"{1.7e9 + a:.4f}," + row.partition(",")[2] for a, row in zip(late, text[1:], strict=True)]
    torque.write_text("\n".join([text[0], *body]) + "\n")
    recording = read_recording(motion, join=[torque])
    (said,) = [f for f in recording.findings if f.check == "join"]
    assert "time since 1970" in said.what and said.severity == "repaired"
    good = recording.complete
    assert np.sqrt(np.mean((recording.tau[good] - wanted[good]) ** 2)) < 0.5


def test_motion_that_repeats_is_a_question(tmp_path):
    t = np.arange(0, 30, 0.01)
    q = np.column_stack([0.5 + 0.4 * np.sin(2 * np.pi * t), -0.9 + 0.4 * np.sin(2 * np.pi * t + 1)])
    tau = np.column_stack([30 * np.sin(q[:, 0]), 10 * np.sin(q.sum(axis=1))])
    motion = write(tmp_path / "a.csv", t, q, "q1,q2")
    torque = write(tmp_path / "b.csv", t, tau, "tau1,tau2")
    with pytest.raises(RecordingError, match="repeats itself") as asked:
        read_recording(motion, join=[torque])
    assert "@LAG" in asked.value.remedy
    recording = read_recording(motion, join=[(torque, 0.0)])
    np.testing.assert_allclose(recording.tau[recording.valid], tau[recording.valid], atol=1e-6)


def test_files_of_different_trials_are_refused(tmp_path):
    motion, torque, _, _ = files(tmp_path, 0.0)
    _, tau = trial(seed=9)
    late = np.arange(0, 40, 0.004)
    write(torque, late, tau(late), "hip_torque,knee_torque")
    with pytest.raises(RecordingError, match="belong together"):
        read_recording(motion, join=[torque])


def test_resampling_keeps_lines_averages_what_is_faster_and_leaves_holes():
    t = np.arange(0, 1, 0.01)
    np.testing.assert_allclose(onto(np.arange(0.005, 0.9, 0.01), t, 3 * t), 3 * np.arange(0.005, 0.9, 0.01))
    fast = np.arange(0, 1, 0.001)
    alternating = np.where(np.arange(1000) % 2, 1.0, -1.0)
    assert np.abs(onto(np.arange(0.1, 0.9, 0.1), fast, alternating)).max() < 0.05
    hole = np.r_[t[:30], t[60:]]
    assert np.isnan(onto(np.array([0.1, 0.45, 0.8, 2.0]), hole, hole)).tolist() == [False, True, False, True]
