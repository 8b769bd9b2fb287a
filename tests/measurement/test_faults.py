"""Every fault that recordings are known to have, put into a clean one of the bench: the audit names it, and keeps
quiet about clean ones."""

import numpy as np
import pytest

from exoid.ground.errors import RecordingError
from exoid.measurement.auditing.audit import audit
from exoid.measurement.auditing.convention import check_conventions
from exoid.measurement.auditing.degrees import read_degrees
from exoid.measurement.auditing.unusable import mask_unusable, without_rounding
from exoid.measurement.bench.leg import random_leg
from exoid.measurement.bench.simulation import simulate_runs
from exoid.measurement.reading.columns import assign
from exoid.measurement.reading.mapping import StatedMapping
from exoid.measurement.reading.raw import RawColumn, RawTable
from exoid.measurement.reading.repair import as_recording, on_one_clock
from exoid.measurement.recording import Source
from exoid.symbolic.model import Model


def bench(seed):
    leg = random_leg(np.random.default_rng(seed))
    return simulate_runs(1, Model.standard(thigh_length=leg.thigh_length), leg, seed=seed)[0].recording


@pytest.fixture(scope="module")
def clean():
    """Columns of a good recording."""
    return bench(0).columns()


def read(columns):
    """Return the recording in `columns` as a file of them would be read."""
    count = len(columns["t"])
    table = RawTable(tuple(RawColumn(k, np.array(v, dtype=float)) for k, v in columns.items()), np.arange(2, count + 2))
    assigned, source = assign(table, StatedMapping(), where="f"), Source("f", "")
    draft = read_degrees(on_one_clock(table, assigned, source, "f"), assigned)
    recording = mask_unusable(without_rounding(as_recording(draft, source, "f")))
    return recording.with_findings((*audit(recording), *check_conventions([recording])))


def put(**changes):
    """A fault that changes columns, each by a function of it."""

    def fault(columns):
        return {k: changes[k](v.copy()) if k in changes else v for k, v in columns.items()}

    return fault


def at(rows, value):
    """A function that sets `rows` of a column; a function as `value` gets the column."""

    def change(x):
        x[rows] = value(x) if callable(value) else value
        return x

    return change


def exchanged(*pairs):
    def fault(columns):
        out = dict(columns)
        for a, b in pairs:
            out[a], out[b] = columns[b], columns[a]
        return out

    return fault


def rows(keep):
    return lambda columns: {k: v[keep] for k, v in columns.items()}


def noise(size, share=1.0):
    def change(x):
        rng = np.random.default_rng(1)
        return x + size * rng.standard_normal(x.size) * (rng.random(x.size) < share)

    return change


def shaken(t):
    return t + np.random.default_rng(0).uniform(-0.0045, 0.0045, t.size)


LOST = np.r_[0:500, 560:2000, 2010:3000]
FAULTS = {
    "cells that are no numbers": (put(q1=at(slice(100, 130), np.nan)), "cells", "30 of 3000"),
    "infinity": (put(tau1=at(50, np.inf)), "cells", "infinite"),
    "repeated time": (put(t=at(slice(100, 103), lambda t: t[100])), "time", "repeats or goes back in 2"),
    "time going back": (put(t=at(100, lambda t: t[50])), "time", "repeats or goes back in 1"),
    "clock in ms": (put(t=lambda t: t * 1e3), "time", "read in ms"),
    "jitter": (put(t=shaken), "jitter", "varies by"),
    "gaps": (rows(LOST), "gaps", "2 gaps with about 70 samples"),
    "degrees": (put(q1=np.degrees, q2=np.degrees), "units", "degrees"),
    "one angle in degrees": (put(q2=np.degrees), "units", "knee angle"),
    "mN·m": (put(tau2=lambda x: 1e3 * x), "units", "mN·m"),
    "hip angle turned": (put(q1=np.negative), "convention", "the hip angle has the wrong sign"),
    "knee angle turned": (put(q2=np.negative), "convention", "the knee angle has the wrong sign"),
    "hip torque turned": (put(tau1=np.negative), "convention", "the hip torque has the wrong sign"),
    "knee torque turned": (put(tau2=np.negative), "convention", "the knee torque has the wrong sign"),
    "both torques turned": (put(tau1=np.negative, tau2=np.negative), "convention", "both torques"),
    "angles swapped": (exchanged(("q1", "q2")), "convention", "hip and knee angle are swapped"),
    "torques swapped": (exchanged(("tau1", "tau2")), "convention", "hip and knee torque are swapped"),
    "joints swapped": (exchanged(("q1", "q2"), ("tau1", "tau2")), "convention", "hip and knee are swapped"),
    "torque saturated": (put(tau1=lambda x: np.minimum(x, np.quantile(x, 0.95))), "saturated", "hip torque"),
    "torque hardly saturated": (put(tau2=lambda x: np.minimum(x, np.quantile(x, 0.98))), "saturated", "knee torque"),
    "angle saturated": (put(q2=lambda x: np.maximum(x, np.quantile(x, 0.05))), "saturated", "knee angle"),
    "torque frozen": (put(tau1=at(slice(1000, 1030), lambda x: x[1000])), "frozen", "hip torque is frozen in 30 rows"),
    "angle frozen": (put(q2=at(slice(1000, 1100), lambda x: x[1000])), "frozen", "knee angle is frozen in 100 rows"),
    "angle frozen to the end": (put(q2=at(slice(1500, None), lambda x: x[1500])), "frozen", "frozen in 1500 rows"),
    "torque is rounding": (put(tau2=lambda x: 1e-149 * x), "motion", "is read as zero"),
    "coarse angle": (put(q1=lambda x: np.round(x / 0.02) * 0.02), "quantised", "steps of 0.02 rad"),
    "coarse torque": (put(tau2=lambda x: np.round(x / 2.0) * 2.0), "quantised", "steps of 2 N·m"),
    "angle wraps": (put(q2=lambda x: (x - np.median(x)) % (2 * np.pi)), "wraps", "jumps by a full turn"),
    "spikes": (put(q1=at([500, 900, 2000], lambda x: x[[500, 900, 2000]] + 0.2)), "spikes", "3 spikes"),
    "small spikes": (put(q2=at([500, 900], lambda x: x[[500, 900]] - 0.04)), "spikes", "2 spikes"),
    "sampled too slowly": (rows(slice(None, None, 5)), "rate", "slow for"),
    "sampled far too slowly": (rows(slice(None, None, 12)), "rate", "too slow"),
    "no motion": (put(q1=lambda x: 0 * x, q2=lambda x: 0 * x - 0.3), "motion", "no motion"),
    "hip stands still": (put(q1=lambda x: noise(6e-5)(0 * x)), "motion", "hip stands still"),
    "torque missing": (put(tau2=lambda x: 0 * x), "motion", "knee torque is 0 N·m"),
    "outliers": (put(tau2=noise(60.0, 0.15)), "outliers", "knee torque"),
    "too short": (rows(slice(0, 300)), "length", "lasts only"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_is_named_with_place_and_remedy(clean, name):
    fault, check, words = FAULTS[name]
    named = [one for one in read(fault(clean)).findings if one.check == check and words in one.what]
    assert named, [str(one) for one in read(fault(clean)).findings]
    assert named[0].where and named[0].remedy and named[0].confidence
    if named[0].severity == "warning":
        assert named[0].consequence


def test_rows_without_a_measurement_are_masked_and_their_neighbours_are_not(clean):
    frozen = read(FAULTS["angle frozen"][0](clean))
    assert np.flatnonzero(~frozen.complete).tolist() == list(range(1000, 1100)) and frozen.torque_valid.all()
    capped = read(FAULTS["torque saturated"][0](clean))
    at_limit = capped.tau[:, 0] == capped.tau[:, 0].max()
    np.testing.assert_array_equal(~capped.complete, at_limit)
    assert capped.angle_valid.all() and capped.torque_valid[:, 1].all()


def test_mostly_saturated_is_left_for_a_person_to_judge(clean):
    recording = read(put(tau1=lambda x: np.minimum(x, np.quantile(x, 0.5)))(clean))
    assert recording.complete.all()
    assert [one.severity for one in recording.findings if one.check == "saturated"] == ["warning"]


def test_a_joint_that_comes_to_rest_is_not_saturated():
    t = np.arange(0.0, 30.0, 0.01)
    swing = 0.6 * np.sin(np.clip(t % 6.0, 0.0, np.pi / 2 * 2) - np.pi / 2)  # rests at its extreme between swings
    q1 = np.round((0.5 + swing) / 4.8e-5) * 4.8e-5
    rng = np.random.default_rng(0)
    tau = rng.standard_normal((2, t.size)) + 30 * np.sin(q1)
    recording = read({"t": t, "q1": q1, "q2": -0.9 + 0.5 * np.sin(t), "tau1": tau[0], "tau2": tau[1]})
    assert recording.valid.all() and not [one for one in recording.findings if one.check == "saturated"]


def test_no_number_is_still_a_refusal(clean):
    with pytest.raises(RecordingError, match="not usable numbers"):
        read(put(q1=lambda x: np.nan * x)(clean))


@pytest.mark.parametrize("seed", [*range(6), *(pytest.param(k, marks=pytest.mark.slow) for k in range(6, 20))])
def test_clean_recordings_raise_no_alarm(seed):
    recording = bench(seed)
    after = read(recording.columns())
    assert after.valid.all()
    assert {one.severity for one in after.findings} <= {"info"}, after.findings
