"""A joint without a drive: its torque is zero for certain, and nothing of a drive is suspected there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exoid.diagnosis.evidence.fitted import fitted_model
from exoid.diagnosis.evidence.library import build_library
from exoid.diagnosis.evidence.model_error import model_error, sensor_noise
from exoid.diagnosis.evidence.remainder import remainders
from exoid.diagnosis.hypotheses.recordings import claims_of
from exoid.ground.errors import NotEnoughDataError, RecordingError
from exoid.measurement.auditing.checks.motion import check
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.filtering import driven_joints
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.model import Model
from exoid.workbench.command_line.inputs import passive_joints
from exoid.workbench.command_line.parser import UsageError
from tests.made_recordings import recording

KNEE = (False, True)


def quiet(seed: int):
    """Return a recording whose knee torque reads next to nothing, as of a drive that is commanded zero."""
    one = recording(seed)
    rng = np.random.default_rng(seed)
    noise = 0.006 * rng.normal(size=len(one)) * np.where(rng.uniform(size=len(one)) < 0.05, 8.0, 1.0)
    return replace(one, tau=np.column_stack([one.tau[:, 0], noise]))


def test_a_passive_joint_is_recognised_and_said():
    zero = [f for f in check(recording(0, undriven=KNEE)) if "passive" in f.what]
    assert zero and "knee" in zero[0].what
    (nearly,) = [f for f in check(quiet(1)) if "next to nothing" in f.what]
    assert nearly.severity == "info" and "--passive" in nearly.remedy and nearly.remedy.endswith("=knee")
    assert not [f for f in check(recording(2)) if "next to nothing" in f.what]


def test_a_declared_zero_is_a_fact_without_sensor_noise():
    declared = [quiet(k).with_passive("knee") for k in range(2)]
    prepared = prepare(Model.standard(), declared, cutoff=5.0)
    for one in prepared.train:
        assert not one.driven[1] and one.driven[0]
        assert not one.torque[1].any() and one.used[1].any()
    fitted = fitted_model(identify(Model.standard(), prepared.train, optimisers=()), prepared)
    error = model_error(fitted)  # in units of a noise that is one, not of a sensor that read zero
    assert error is None or error.times < 100.0


@pytest.mark.slow
def test_nothing_of_a_drive_is_suspected_at_a_joint_without_one():
    model = Model.standard()
    prepared = prepare(model, [quiet(k).with_passive("knee") for k in range(2)], cutoff=5.0)
    library = build_library(model, prepared.all)
    names = {c.name for c in library.candidates}
    at_drives = {c.term.effect.id for c in library.candidates if c.term.effect.drive and c.term.joint == "hip"}
    assert "drive_gain" in at_drives
    assert not names & {f"{effect}:knee" for effect in at_drives}
    assert "stribeck:knee" in names  # friction of the joint itself needs no drive
    mixed = prepare(model, [quiet(0).with_passive("knee"), recording(3)], cutoff=5.0)
    assert "drive_gain:knee" in {c.name for c in build_library(model, mixed.all).candidates}
    own = {(claim.what, claim.place) for claim in claims_of(model, driven_joints(prepared.all))}
    assert ("sensor_zero", "hip") in own and ("friction_level", "knee") in own
    assert not own & {("sensor_zero", "knee"), ("torque_gain", "knee")}  # nobody measures a torque there
    assert ("torque_gain", None) not in own  # of the only drive, the same as its own
    both = {(claim.what, claim.place) for claim in claims_of(model, driven_joints(mixed.all))}
    assert both >= {("sensor_zero", "knee"), ("torque_gain", None)}


def test_the_option_names_all_recordings_or_one():
    assert passive_joints(["knee"], ["a/x.csv", "y.csv"]) == {"a/x.csv": ["knee"], "y.csv": ["knee"]}
    assert passive_joints(["x.csv=hip"], ["a/x.csv", "y.csv"]) == {"a/x.csv": ["hip"], "y.csv": []}
    for wrong in ("ankel", "z.csv=knee"):
        with pytest.raises(UsageError):
            passive_joints([wrong], ["a/x.csv"])
    with pytest.raises(RecordingError):
        recording(0).with_passive("elbow")


def test_a_torque_that_reads_nothing_but_noise_is_that_of_no_drive():
    prepared = prepare(Model.standard(), [quiet(k) for k in range(2)], cutoff=5.0)
    assert not any(one.driven[1] for one in prepared.train) and all(one.driven[0] for one in prepared.train)
    assert sensor_noise(prepared)[1] == prepared.noise_floor.max()


def test_the_torque_of_the_model_explains_nothing_where_no_drive_acts():
    model = Model.standard()
    prepared = prepare(model, [quiet(k).with_passive("knee") for k in range(2)], cutoff=5.0)
    names = {c.name for c in build_library(model, prepared.all).candidates}
    assert "load_friction:hip" in names and "load_friction:knee" not in names
    now = fitted_model(identify(model, prepared.train, optimisers=()), prepared)
    tried = {(r.joint, r.variable) for r in remainders(now, now.evidence(seed=0, draws=20), placebos=0)}
    assert {("hip", "load"), ("hip", "ddq1"), ("knee", "ddq1")} < tried
    assert not {("knee", "load"), ("knee", "ddq2")} & tried


def test_a_driven_joint_that_is_declared_passive_is_refused():
    with pytest.raises(RecordingError, match="hip is declared passive, and its torque spans"):
        prepare(Model.standard(), [recording(0).with_passive("hip")], cutoff=5.0)


def test_a_free_swing_alone_is_refused_with_what_it_cannot_tell():
    swings = [recording(k, undriven=(True, True)) for k in range(2)]
    (found,) = [f for f in check(swings[0]) if f.severity == "refused"]
    assert "only ratios of parameters" in found.remedy
    with pytest.raises(NotEnoughDataError, match="only ratios of parameters"):
        prepare(Model.standard(), [one.with_passive("hip", "knee") for one in swings])


def test_noise_that_accelerations_carry_is_compared_with_a_sensor_that_has_noise():
    prepared = prepare(Model.standard(), [recording(k, undriven=KNEE) for k in range(2)])
    carried = [float(text.split(" %")[0]) for text in prepared.choice.reason.split("carry ")[1:]]
    assert all(share < 1e6 for share in carried)
