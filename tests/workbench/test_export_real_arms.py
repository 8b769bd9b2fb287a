"""What a fit says of two real arms goes out as files whose re-simulation in MuJoCo leaves what the fit leaves."""

from __future__ import annotations

import re

import numpy as np
import pytest

from exoid.measurement.reading.read import read_recording
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.model import read_model
from exoid.symbolic.model_file import read_numbers
from exoid.workbench.command import main
from exoid.workbench.export.mjcf import HARD

LEFT = 1.1
"""Times what the fit leaves that a re-simulation leaves at most."""
ARMS = {
    "ur10": ("exciting.csv", ()),
    "tx40": ("run.csv", tuple(f"rotor_inertia:joint_{k}" for k in (3, 4, 5, 6))),
}


def without_meshes(text: str) -> str:
    """A URDF without the shapes of its links, whose files are not there."""
    return re.sub(r"<(visual|collision)[ >].*?</\1>", "", text, flags=re.S)


def inverse(text, motion, joints, armature):
    """Torques (N, J) that MuJoCo asks of a motion's drives, friction and all.

    A URDF says neither rotor inertia nor how hard dry friction is: `armature` and MJCF's hardness are set beside it.
    """
    mujoco = pytest.importorskip("mujoco")
    machine = mujoco.MjModel.from_xml_string(text)
    machine.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT | mujoco.mjtDisableBit.mjDSBL_CONTACT
    places = [int(machine.joint(name).dofadr[0]) for name in joints]
    for place, size in zip(places, armature, strict=True):
        machine.dof_armature[place] = machine.dof_armature[place] or size
    machine.dof_solimp[:, :3] = [float(part) for part in HARD.split()]
    state, found = mujoco.MjData(machine), np.empty_like(motion.q)
    for k in range(len(found)):
        state.qpos[places], state.qvel[places], state.qacc[places] = motion.q[k], motion.dq[k], motion.ddq[k]
        mujoco.mj_inverse(machine, state)
        found[k] = state.qfrc_inverse[places]
    return found


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_a_recording_simulated_again_leaves_what_the_fit_leaves(shared_data, tmp_path, name):
    pytest.importorskip("mujoco")
    own, (file, effects) = shared_data / f"arm_{name}" / f"{name}.urdf", ARMS[name]
    model, recording = read_model(own), shared_data / f"arm_{name}" / file
    for effect in effects:
        model = model.with_effect(effect)
    given, fitted = model.save(tmp_path / "arm.toml"), tmp_path / "possible.toml"
    asked = ["identify", str(recording), "--model", str(given), "--physical", "--write", str(fitted), "--quiet"]
    assert main(asked) == 0
    assert main(["export", str(fitted), "--as", "mjcf", "--into", str(own), "--out", str(tmp_path), "--quiet"]) == 0

    numbers = read_numbers(fitted).linear
    prepared = prepare(model, [read_recording(recording, joints=model.joints)]).train[0]

    def left(torque):
        error = np.where(prepared.used, prepared.torque - prepared.smooth(torque), 0.0)
        return np.sqrt(np.sum(error**2, axis=1) / prepared.used.sum(axis=1))

    fit = left(model.torque(prepared.motion, np.array([numbers[p.name] for p in model.parameters])))
    rotors = [numbers.get(f"rotor_inertia:{joint}.c", 0.0) for joint in model.joint_names]
    for path, armature in ((tmp_path / "exoid_leg.xml", np.zeros(6)), (tmp_path / f"{name}_identified.urdf", rotors)):
        text = without_meshes(path.read_text(encoding="utf-8"))
        again = left(inverse(text, prepared.motion, model.joint_names, armature))
        assert np.all(again <= LEFT * fit), f"{path.name}: {again / fit}"
