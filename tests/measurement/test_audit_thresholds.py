"""Thresholds of the simple checks lie where they are said to: nothing is found on one side, something on the other."""

from __future__ import annotations

import numpy as np
import pytest
from tables import leg

from exoid.measurement.auditing.audit import find_checks
from exoid.measurement.auditing.checks.frozen import frozen_stretches
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import Joint

CHECKS = find_checks()


def recording(count=1500, rate=100.0, **changes):
    """The usual leg, with some of t, q, tau, dq, valid replaced."""
    table = leg(count, rate)
    usual = {
        "t": table["t"],
        "q": np.column_stack([table["q1"], table["q2"]]),
        "tau": np.column_stack([table["tau1"], table["tau2"]]),
    }
    return Recording("run", **(usual | changes))


def severity(check, **changes):
    """The worst severity that one check finds, "" where it finds nothing."""
    found = [finding.severity for finding in CHECKS[check](recording(**changes))]
    return next((name for name in ("refused", "warning", "info") if name in found), "")


@pytest.mark.parametrize(("rate", "said"), [(41.0, ""), (39.0, "warning"), (10.5, "warning"), (9.5, "refused")])
def test_slow_sampling_gives_no_accelerations(rate, said):
    assert severity("rate", count=400, rate=rate) == said


@pytest.mark.parametrize(
    ("count", "rate", "said"),
    [(520, 100.0, ""), (490, 100.0, "warning"), (110, 100.0, "warning"), (90, 100.0, "refused"),
     (49, 25.0, "refused"), (51, 25.0, "warning")],
)  # fmt: skip
def test_short_recordings_carry_little(count, rate, said):
    assert severity("length", count=count, rate=rate) == said


@pytest.mark.parametrize(("share", "said"), [(0.82, ""), (0.78, "warning")])
def test_much_that_is_masked_is_said(share, said):
    assert severity("length", valid=np.arange(1500) < 1500 * share) == said


@pytest.mark.parametrize(("spread", "said"), [(0.04, ""), (0.07, "info"), (0.28, "info"), (0.36, "warning")])
def test_an_uneven_clock_is_noted_and_warned_of(spread, said):
    steps = 0.01 * (1.0 + spread / 0.9 * np.random.default_rng(0).uniform(-1.0, 1.0, 1500))
    assert severity("jitter", t=np.cumsum(steps)) == said


@pytest.mark.parametrize(
    ("steps", "holes", "said"),
    [(2.0, 1, ""), (3.0, 1, "info"), (8.0, 1, "info"), (12.0, 1, "warning"), (3.0, 5, "info"), (3.0, 12, "warning")],
)
def test_gaps_are_warned_of_where_a_joint_can_have_moved_in_them(steps, holes, said):
    step = np.full(1500, 0.01)
    step[np.linspace(100, 1400, holes).astype(int)] *= steps
    assert severity("gaps", t=np.cumsum(step)) == said


@pytest.mark.parametrize(("factor", "said"), [(1.0, ""), (8.0, ""), (13.0, "warning"), (0.35, ""), (0.25, "warning")])
def test_angles_of_another_unit_are_warned_of(factor, said):
    assert severity("units", q=factor * np.column_stack([leg()["q1"] - 0.6, leg()["q2"]])) == said


@pytest.mark.parametrize(("size", "said"), [(900.0, ""), (1100.0, "warning"), (0.12, ""), (0.08, "warning")])
def test_torques_of_another_unit_are_warned_of(size, said):
    swing = np.where(np.arange(1500) % 2, 1.0, -1.0)
    assert severity("units", tau=size * np.column_stack([swing, swing])) == said


@pytest.mark.parametrize(("levels", "said"), [(600, ""), (400, "info"), (70, "info"), (50, "warning")])
def test_a_coarse_channel_is_noted_and_warned_of(levels, said):
    q = np.column_stack([leg()["q1"], leg()["q2"]])
    smooth = np.random.default_rng(0).normal(size=(1500, 2))
    assert severity("quantised", q=np.round(q * levels) / levels, tau=smooth) == said


@pytest.mark.parametrize(("factor", "said"), [(1.0, ""), (1.15, ""), (0.85, ""), (1.25, "warning"), (0.75, "warning")])
def test_a_logged_velocity_may_be_filtered_but_not_another(factor, said):
    q = np.column_stack([leg()["q1"], leg()["q2"]])
    assert severity("velocity", dq=factor * np.gradient(q, 0.01, axis=0)) == said


@pytest.mark.parametrize(("size", "said"), [(0.2, ""), (0.12, "warning"), (0.015, "warning"), (0.008, "refused")])
def test_a_leg_that_hardly_moves_is_said_or_refused(size, said):
    t = leg()["t"]
    q = size / 2 * np.column_stack([np.sin(2.0 * t), np.sin(3.1 * t)])
    assert severity("motion", q=q) == said


@pytest.mark.parametrize(
    ("every", "size", "said"),
    [(33, 2.0, ""), (33, 8.0, "info"), (100, 8.0, ""), (10, 30.0, "info"), (6, 30.0, "warning")],
)
def test_torques_far_off_their_neighbours_are_counted(every, size, said):
    tau = np.random.default_rng(0).uniform(-1.0, 1.0, (1500, 2))
    tau[::every, 0] += size
    assert severity("outliers", tau=tau) == said


@pytest.mark.parametrize(("part", "said"), [(0.3, "info"), (0.4, "warning")])
def test_torque_that_comes_in_bursts_is_warned_of(part, said):
    """A tenth of the samples carries this part of a torque that is the same on average."""
    tau = torques()
    bursts = np.where(np.arange(1500) % 10 == 0, 10.0, 0.0)[:, None]
    assert severity("outliers", tau=tau * (1.0 - part + part * bursts)) == said


@pytest.mark.parametrize(
    ("rate", "rows", "said"), [(50.0, 8, ""), (50.0, 14, "warning"), (200.0, 15, ""), (200.0, 30, "warning")]
)
def test_a_channel_that_stays_while_the_leg_moves_is_frozen(rate, rows, said):
    table = leg(1500, rate)
    q = np.column_stack([table["q1"], table["q2"]])
    at = int(np.argmax(np.abs(np.diff(q[200:900, 0])))) + 200
    q[at : at + rows, 0] = q[at, 0]
    assert severity("frozen", rate=rate, q=q) == said


@pytest.mark.parametrize(("speed", "said"), [(0.03, ""), (1.0, "warning")])
def test_no_joint_stops_dead(speed, said):
    """The recording ends with an angle that stays: reached slowly, as a joint that comes to rest, or in full motion."""
    table = leg(1500)
    q = np.column_stack([table["q1"], table["q2"]])
    step = np.abs(np.diff(q[:, 0]))
    at = 700 + int(np.argmin(np.abs(step[700:1400] - speed * step[700:1400].max())))
    q[at:, 0] = q[at, 0]
    assert severity("frozen", q=q) == said


def test_an_angle_that_stops_dead_and_starts_so_is_masked_where_it_did_not_jump():
    """A bus that hung for a period of the motion: it goes on where it was."""
    t = np.arange(1500) / 100.0
    q = np.column_stack([0.5 + 0.4 * np.sin(np.pi * t), -0.8 + 0.3 * np.cos(np.pi * t)])
    q[500:700, 0] = q[500, 0]
    ((channel, rows, _, certain),) = frozen_stretches(recording(q=q))
    assert channel.name == "q1" and rows.tolist() == list(range(500, 700)) and certain


def test_a_machine_that_goes_from_dwell_to_dwell_is_not_frozen():
    """Ramps of constant speed that begin and end within a sample, each followed by a second of rest."""
    t = np.arange(1500) / 100.0
    ramp = 0.1 * (np.floor(t / 2.0) + np.clip(t % 2.0, 0.0, 1.0))
    assert severity("frozen", q=np.column_stack([ramp, -0.9 + 0.5 * ramp])) == ""


def torques():
    return np.column_stack([leg()["tau1"], leg()["tau2"]])


@pytest.mark.parametrize(("size", "said"), [(3e-8, "no"), (3e-10, "yes"), (1e-149, "yes"), (5e-324, "yes")])
def test_torques_that_are_rounding_carry_nothing(size, said):
    """In whatever unit: no drive exerts so little, and no sensor feels it."""
    tau = size * torques() / np.ptp(torques(), axis=0)
    assert severity("motion", tau=tau) == {"no": "", "yes": "refused"}[said]
    alone = np.column_stack([torques()[:, 0], tau[:, 1]])
    assert severity("motion", tau=alone) == {"no": "info", "yes": "warning"}[said]


@pytest.mark.parametrize(("share", "said"), [(0.07, "info"), (0.1, "")])
def test_a_torque_that_reads_next_to_nothing_is_noted(share, said):
    low, high = np.percentile(torques(), [10, 90], axis=0)
    assert severity("motion", tau=torques() / (high - low) * [1.0, share]) == said


@pytest.mark.parametrize(("rows", "said"), [(45, ""), (67, "warning")])
def test_a_channel_that_stays_at_its_end_is_at_its_end_of_scale(rows, said):
    tau = np.round(np.random.default_rng(0).uniform(-10.0, 10.0, (1500, 2)), 1)
    tau[200 : 200 + rows, 0] = tau[:, 0].max()
    assert severity("saturated", tau=tau) == said


@pytest.mark.parametrize(("last", "said"), [(0.02, ""), (0.035, "warning")])
def test_an_angle_that_slows_down_before_it_stays_came_to_rest(last, said):
    swing = np.concatenate([0.01 * np.arange(90), np.full(40, 0.89 + 0.01 * last), np.linspace(0.88, 0.01, 20)])
    q = np.column_stack([np.tile(swing, 10), leg()["q2"]])
    assert severity("saturated", q=q) == said


@pytest.mark.parametrize(("far", "said"), [(19.0, ""), (21.0, "warning")])
def test_a_slide_that_goes_very_far_is_warned_of(far, said):
    t = leg()["t"]
    slide = Recording("run", t, far * np.sin(t)[:, None], np.sin(3 * t)[:, None], joints=(Joint("stage", "prismatic"),))
    assert [finding.severity for finding in CHECKS["units"](slide)] == [said] * bool(said)
