"""What no motion can distinguish is found, and nothing else is claimed."""

import pytest

from exoid.ground.errors import EffectError
from exoid.symbolic import Coefficient, Effect, Model
from exoid.symbolic import identifiability as structure
from exoid.symbolic.identifiability import never_separable, structural_look_alikes
from exoid.symbolic.term import Term

N_M = Coefficient("N·m")


@pytest.fixture(scope="module")
def found():
    return structural_look_alikes(Model.standard())


def test_rotor_inertia_of_the_hip_hides_in_the_base_parameters(found):
    (one,) = [entry for entry in found if "rotor_inertia:hip.c" in entry.names]
    assert one.absorbed
    assert one.relation == "rotor_inertia:hip.c = Phi1 - Phi4"


def test_pairs_of_the_catalogue(found):
    pairs = {frozenset(entry.names) for entry in found if not entry.absorbed}
    assert frozenset(("drive_gain:hip", "drive_gain:knee")) in pairs
    # A knee zero that is off turns the shank about the knee: so does a centre of mass off its axis.
    assert frozenset(("encoder_offset_knee", "com_offset_shank")) in pairs
    assert frozenset(("torque_offset:hip", "joint_spring:hip")) in pairs
    assert not any("backlash:hip" in names for names in pairs)
    assert not any({"viscous_cubic:hip", "viscous_quadratic:hip"} <= names for names in pairs), "near, not exact"


def test_what_imitates_a_term_is_remembered_and_a_damaged_file_is_made_anew(tmp_path, monkeypatch, found):
    monkeypatch.setenv("EXOID_CACHE", str(tmp_path))
    asked = []
    monkeypatch.setattr(structure, "structural_look_alikes", lambda model: asked.append(model) or found)
    model = Model.standard().with_effect("drive_gain", "hip")
    names = ["drive_gain:hip", "torque_offset:hip", "joint_spring:hip", "rotor_inertia:hip", "stribeck:knee"]
    wanted = {
        "drive_gain:hip": ("drive_gain:knee",),
        "torque_offset:hip": ("joint_spring:hip", "torque_drift:hip"),  # a spring may be an offset, not the reverse
        "joint_spring:hip": (),
        "rotor_inertia:hip": ("Phi1", "Phi4"),
        "stribeck:knee": (),
    }
    assert never_separable(names, model) == wanted == never_separable(names, model)
    assert len(asked) == 1
    (file,) = tmp_path.glob("look_alikes-*.json")
    file.write_text(file.read_text().replace("drive_gain", "drive_pain"))
    assert never_separable(names, model) == wanted
    assert len(asked) == 2
    with pytest.raises(EffectError, match="no effect is called stribek"):
        never_separable(["stribek"], model)


def test_an_extra_gravity_term_is_phi_4():
    extra = Effect("extra", "", "c * sin(theta1)", coefficients={"c": N_M})
    (one,) = structural_look_alikes(Model.standard(), [Term(extra, "hip")])
    assert one.absorbed
    assert set(one.names) == {"extra:hip.c", "Phi4"}


def test_dependent_numbers_within_a_model():
    twice = Effect("twice", "", "c * dtheta * 2", coefficients={"c": Coefficient("N·m·s/rad")})
    (one,) = structural_look_alikes(Model.standard().with_effect(twice, "knee"), [])
    assert one.relation == "twice:knee.c = 2 viscous:knee"
