"""A clock of too few digits: evenly spaced samples that agree with it are taken and told, others are refused."""

import numpy as np
import pytest

from exoid.ground.errors import RecordingError
from exoid.measurement import read_recording


def table(t, stamps=None):
    """A leg that moves, as (N, 5), its times as they were logged."""
    q = np.column_stack([0.5 + 0.4 * np.sin(2.1 * t), -0.6 + 0.4 * np.sin(3.3 * t + 1.0)])
    tau = np.column_stack([12 * np.sin(q[:, 0]) + np.cos(2 * t), 4 * np.sin(q.sum(axis=1))])
    return np.column_stack([t if stamps is None else stamps, q, tau])


@pytest.mark.parametrize(
    ("rate", "begin", "digit", "scale"),
    [(100.0, 1040000.0, 0.0625, 1.0), (128.0, 0.0, 0.01, 1.0), (60.0, 3.0, 0.01, 1.0), (400.0, 0.0, 10.0, 1e3)],
    ids=["a float after twelve days", "two decimals", "two decimals, no repeats", "10 ms ticks in ms"],
)
def test_evenly_spaced_samples_behind_it_are_taken(rate, begin, digit, scale):
    t = np.arange(2000) / rate
    one = read_recording(table(t, np.floor((begin + t) * scale / digit) * digit))
    steps = np.diff(one.t)
    assert np.ptp(steps) < 1e-6 and np.mean(steps) == pytest.approx(1 / rate, rel=1e-3)
    (said,) = [finding for finding in one.findings if "too few digits" in finding.what]
    assert said.severity == "warning" and "spaced evenly" in said.what and f"{rate:.3g}" in said.what


def test_what_no_evenly_spaced_samples_explain_is_refused():
    t = np.arange(2000) / 100.0
    lost = np.delete(t, slice(700, 1100))
    with pytest.raises(RecordingError, match="no evenly spaced samples agree") as refused:
        read_recording(table(lost, np.floor(lost / 0.0625) * 0.0625))
    assert "--map t=COLUMN" in str(refused.value)


def test_an_uneven_clock_is_used_as_it_was_logged():
    rng = np.random.default_rng(0)
    t = np.cumsum(0.002 + 0.0005 * rng.random(5000))
    one = read_recording(table(t, np.round(t, 6)))
    assert np.allclose(one.t, np.round(t, 6))
