"""Columns of forces from outside: what they are called, what they mean, and what is wrong with them."""

import numpy as np
import pytest
from tables import leg

from exoid.ground.errors import RecordingError
from exoid.measurement.auditing.audit import find_checks
from exoid.measurement.auditing.unusable import mask_unusable
from exoid.measurement.forces import force_signals, pushed_model, unused_forces, usual_forces
from exoid.measurement.reading.names import recognise
from exoid.measurement.reading.read import read_recording
from exoid.measurement.recording import Recording, to_csv
from exoid.symbolic.force import TORQUE, VERTICAL, WORLD, Force
from exoid.symbolic.joints import LEG, Joint
from exoid.symbolic.model import Model

CHECKS = find_checks()


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("f1", "f1"),
        ("thigh_cuff_force", "f1"),
        ("LoadCell_shank", "f2"),
        ("calf strap force", "f2"),
        ("grf_x", "grf_x"),
        ("GRF_z", "grf_z"),
        ("FP1_Fz", "grf_z"),
        ("forceplate.Fx", "grf_x"),
        ("Fz", "grf_z"),
        ("vertical_grf", "grf_z"),
        ("ground_force_r_vy", "grf_z"),
        ("ground_force_r_vx", "grf_x"),
        ("contact", "contact"),
        ("foot_switch", "contact"),
        ("right heel contact", "contact"),
        ("insole_force_N", "contact"),
        ("stance", "contact"),
        ("interaction_torque_knee", "interaction_torque_knee"),
        ("hip_interaction_torque", "interaction_torque_hip"),
        ("human torque knee", "interaction_torque_knee"),
    ],
)
def test_usual_names_of_forces_are_recognised(written, meant):
    found = recognise(written)
    assert found is not None and found.name == meant


@pytest.mark.parametrize("written", ["ground_force_r_vz", "ground_force_px", "FP1_My", "switch", "cuff", "thigh_mass"])
def test_names_that_say_something_else_are_not(written):
    found = recognise(written)
    assert found is None or not found.name.startswith(("f", "grf", "contact", "inter"))


def test_the_usual_columns_mean_the_usual_thing():
    names = ("f1", "f2", "grf_x", "grf_z", "interaction_torque_knee")
    assert usual_forces(names, LEG) == (
        Force("thigh cuff", "hip", ("f1",)),
        Force("shank cuff", "knee", ("f2",)),
        Force("ground", "knee", ("grf_x", "grf_z"), frame=WORLD),
        Force("interaction at knee", "knee", ("interaction_torque_knee",), frame=TORQUE),
    )
    assert usual_forces(("grf_z",), LEG)[0].frame == VERTICAL
    assert usual_forces(("f1",), (Joint("rail", "prismatic"),)) == ()


def recording(name="run", **forces):
    table = leg(1500, 100.0)
    q, tau = (np.column_stack([table[f"{key}1"], table[f"{key}2"]]) for key in ("q", "tau"))
    return Recording(name, table["t"], q, tau, forces=forces)


def wave(size=10.0, offset=0.0, count=1500):
    return offset + size * np.sin(np.linspace(0.0, 40.0, count))


def test_only_what_every_recording_has_and_what_lives_is_used_and_the_rest_is_told():
    both = [recording(f1=wave(), f2=np.full(1500, 3.0)), recording("other", f1=wave(), grf_z=wave())]
    model = pushed_model(Model.standard(), both)
    assert model.channels == ("f1",)
    said = " ".join(str(finding) for finding in unused_forces(model, both))
    assert "column f2" in said and "column grf_z" in said and "other has none" in said
    same = [recording(f1=wave(), f2=np.full(1500, 3.0))]
    assert "it never changes" in str(unused_forces(pushed_model(Model.standard(), same), same)[0])


def test_a_model_that_says_its_forces_keeps_them_and_needs_their_columns():
    own = Model.standard().with_forces(Force("foot", "knee", ("grf_z",), 0.43, VERTICAL, delay=0.02))
    assert pushed_model(own, [recording(f1=wave())]) is own
    assert "no force of the model has it" in str(unused_forces(own, [recording(f1=wave(), grf_z=wave())])[0])
    with pytest.raises(RecordingError, match="no grf_z"):
        force_signals(own, recording(f1=wave()))
    late = np.roll(wave(), 2)
    assert force_signals(own, recording(grf_z=late))[100:200, 0] == pytest.approx(wave()[100:200])


def test_forces_are_written_and_read_again(tmp_path):
    one = recording(f1=wave(), grf_z=wave(300.0, 300.0), interaction_torque_knee=wave(2.0))
    (tmp_path / "run.csv").write_bytes(to_csv(one))
    again = read_recording(tmp_path / "run.csv")
    assert set(again.forces) == set(one.forces)
    assert all(again.forces[name] == pytest.approx(one.forces[name]) for name in one.forces)


def test_two_plates_that_differ_are_not_used_but_told_and_can_be_mapped(tmp_path):
    columns = to_csv(recording()).decode().splitlines()
    plates = zip(columns[1:], wave(), wave(20.0), strict=True)
    text = [columns[0] + ",FP1_Fz,FP2_Fz", *(f"{row},{a!r},{b!r}" for row, a, b in plates)]
    (tmp_path / "run.csv").write_text("\n".join(text).replace("np.float64(", "").replace(")", ""))
    found = read_recording(tmp_path / "run.csv")
    assert not found.forces and any("can each be grf_z" in f.what for f in found.findings)
    mapped = read_recording(tmp_path / "run.csv", {"grf_z": "FP2_Fz"}, {"grf_z": "-N"})
    assert mapped.forces["grf_z"] == pytest.approx(-wave(20.0))


@pytest.mark.parametrize("check", ["frozen", "saturated"])
def test_a_force_that_freezes_or_runs_into_its_end_of_scale_is_told(check):
    noisy = wave() + 0.3 * np.random.default_rng(0).standard_normal(1500)
    bad = np.where((np.arange(1500) > 400) & (np.arange(1500) < 480), noisy[400], noisy)
    values = bad if check == "frozen" else np.clip(noisy, -6.0, 6.0)
    assert not [f for f in CHECKS[check](recording(f1=noisy)) if "force" in f.what]
    assert [f for f in CHECKS[check](recording(f1=values)) if "force in f1" in f.what]


def test_where_a_force_was_at_its_end_of_scale_no_torque_is_used():
    noisy = wave() + 0.3 * np.random.default_rng(0).standard_normal(1500)
    level = float(np.quantile(noisy, 0.95))
    masked = mask_unusable(recording(f1=np.minimum(noisy, level)))
    assert not masked.torque_valid[noisy > level].any() and masked.torque_valid[noisy < level].all()
    assert any("force in f1" in found.what and found.repaired for found in masked.findings)


def plate(offset=0.0, swing=0.4):
    phase = (np.arange(1500) / 120.0) % 1.0
    noise = np.random.default_rng(1).standard_normal(1500)
    return offset + noise + 600.0 * np.sin(np.pi * np.clip(phase / (1.0 - swing), 0.0, 1.0))


@pytest.mark.parametrize(
    ("values", "told"),
    [
        (plate(), False), (plate(12.0), False), (plate(30.0), True), (plate(-60.0), True), (plate(60.0, 0.02), False),
        (-plate(), False), (-plate(30.0), True),
    ],
)
def test_a_plate_that_was_not_tared_is_told(values, told):
    assert bool(CHECKS["tared"](recording(grf_z=values))) is told
