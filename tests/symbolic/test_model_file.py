"""Model files: what a person writes is read, what is written is read back, what is wrong is refused with its place."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exoid.ground.errors import EffectError, ExoidError, ModelFileError
from exoid.symbolic import Model
from exoid.symbolic.codegen.fingerprint import model_key
from exoid.symbolic.model import read_model
from exoid.symbolic.model_file import read_numbers, write_model
from exoid.symbolic.quantity import Estimate

TEXT = """name = "my leg"
[geometry]
thigh_length = 0.42            # m
gravity = 9.81
[limits.hip]
angle = [-0.13, 1.26]
velocity = 1.92
[[effects]]
id = "gravity_tilt"
[[effects]]
id = "magnet_brake"
joint = "knee"
[[custom_effects]]
id = "magnet_brake"
joint = "knee"
torque = "c * dtheta2 * exp(-((theta2 + 0.9)/w)**2)"
coefficients = { c = { unit = "N·m·s/rad", min = 0 } }
shape = { w = { unit = "rad", min = 0.02, max = 0.6 } }
explains = "eddy-current brake near mid-flexion"
"""


@pytest.fixture
def write(tmp_path):
    def make(text):
        path = tmp_path / "leg.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return make


def test_reading(write):
    model = read_model(write(TEXT))
    assert [term.name for term in model.terms] == ["gravity_tilt", "magnet_brake:knee"]
    assert model.parameters[-1].name == "magnet_brake:knee.c" and model.parameters[-1].min == 0.0
    assert model.limits["hip"].acceleration == 5.16 and model.thigh_length == 0.42
    (custom,) = model.custom
    assert custom.custom and custom.joints == ("knee",)


def test_custom_effects_join_the_catalogue_without_being_terms(write):
    text = TEXT.replace('[[effects]]\nid = "magnet_brake"\njoint = "knee"\n', "")
    model = read_model(write(text))
    assert [term.name for term in model.terms] == ["gravity_tilt"]
    assert model.with_effect("magnet_brake:knee").terms[-1].effect.id == "magnet_brake"


def test_round_trip(write, tmp_path):
    model = read_model(write(TEXT))
    again = read_model(write_model(model, tmp_path / "again.toml"))
    assert model_key(again) == model_key(model)
    assert again.custom[0] == model.custom[0]


def test_an_empty_file_is_the_standard_leg(write):
    assert read_model(write("")).parameters == Model.standard().parameters


class FakeFit:
    estimates = (Estimate("Phi1", 25.1, "kg·m²", 24.0, 26.0), Estimate("gravity_tilt.tilt", 0.02, "rad", 0.01, 0.03))
    delta = (138.46, 92.89)


def test_identified_numbers(tmp_path):
    model = Model.standard().with_effect("gravity_tilt")
    path = write_model(model, tmp_path / "fit.toml", FakeFit())
    numbers = read_numbers(path)
    assert numbers.linear == {"Phi1": 25.1} and numbers.shape == {"gravity_tilt.tilt": 0.02}
    assert numbers.delta == (138.46, 92.89)
    assert model_key(read_model(path)) == model_key(model)
    assert read_numbers(write_model(model, path)) is None


def test_a_failed_write_leaves_what_was_there(tmp_path):
    from exoid.symbolic import Coefficient, Effect

    path = write_model(Model.standard(), tmp_path / "leg.toml")
    before = path.read_bytes()
    own = Effect("own", "", derive=lambda m, s: (s["c"], 0), joints=("both",), coefficients={"c": Coefficient("N·m")},
                 custom=True)  # fmt: skip
    with pytest.raises(ModelFileError, match="needs Python"):
        write_model(Model.standard().with_effect(own), path)
    assert path.read_bytes() == before and list(tmp_path.iterdir()) == [path]


WRONG = [
    ("thigh_length = 0.42", "thigh_lenght = 0.42", 3, "did you mean 'thigh_length'"),
    ("thigh_length = 0.42", "thigh_length = '0.42'", 3, "without quotes"),
    ("thigh_length = 0.42", "thigh_length = true", 3, "not a number"),
    ("thigh_length = 0.42", "thigh_length = nan", 3, "not finite"),
    ("thigh_length = 0.42", "thigh_length = 420", 3, "out of range"),
    ("gravity = 9.81", "gravity = 1" + "0" * 400, 4, "not finite"),
    ("angle = [-0.13, 1.26]", "angle = [1.26, -0.13]", 6, "is empty"),
    ("angle = [-0.13, 1.26]", "angle = [1.26]", 6, "2 numbers"),
    ("[limits.hip]", "[limits.ankle]", 5, "unknown key 'ankle'"),
    ('id = "gravity_tilt"', 'id = "gravty_tilt"', 9, "did you mean gravity_tilt"),
    ('id = "gravity_tilt"', 'id = "gravity_tilt"\njoint = "hip"', 10, "both joints at once"),
    ('id = "gravity_tilt"', 'id = "stribeck"', 9, "stribeck:hip or stribeck:knee"),
    ("theta2 + 0.9", "theta2 + zz", 16, "unknown name 'zz'"),
    ("c * dtheta2", "c * c * dtheta2", 16, "not linear"),
    ("c * dtheta2", "c * dtheta2 + theta2", 16, "no coefficient in front"),
    ("c * dtheta2", "dtheta2", 16, "does not appear"),
    ("min = 0.02", "min = 2", 18, "not below max"),
    ('unit = "rad", ', "", 18, "unit is missing"),
    ('id = "magnet_brake"\njoint = "knee"\ntorque', 'id = "stribeck"\njoint = "knee"\ntorque', 14, "of the catalogue"),
    (
        'id = "magnet_brake"\njoint = "knee"\ntorque',
        'id = "import os"\njoint = "knee"\ntorque',
        14,
        "not a usable name",
    ),
    ("explains", "derive", 19, "needs Python"),
    ("explains", "explain", 19, "did you mean 'explains'"),
    ("[[custom_effects]]", "[custom_effects]", 13, "double brackets"),
    ('name = "my leg"', 'name = ["my leg"', 2, "not valid TOML"),
]


@pytest.mark.parametrize(("old", "new", "line", "message"), WRONG)
def test_refusals_name_file_line_and_remedy(write, old, new, line, message):
    assert old in TEXT
    path = write(TEXT.replace(old, new, 1))
    with pytest.raises(ExoidError) as caught:
        read_model(path)
    text = str(caught.value)
    assert message in text and str(path) in text and "what to do" in text
    assert re.search(rf"line {line}\b", text), text


def test_files_that_are_not_models(tmp_path):
    with pytest.raises(ModelFileError, match="cannot be read"):
        read_model(tmp_path / "absent.toml")
    binary = tmp_path / "binary.toml"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ModelFileError, match="UTF-8"):
        read_model(binary)
    binary.write_bytes(b"#" * 1_100_000)
    with pytest.raises(ModelFileError, match="too large"):
        read_model(binary)
    binary.write_text("a = " + "[" * 5000)
    with pytest.raises(ModelFileError, match="TOML"):
        read_model(binary)


@settings(max_examples=150, deadline=None)
@given(st.integers(0, len(TEXT)), st.integers(0, 12), st.text(max_size=6))
def test_edited_at_random_it_is_read_or_refused(tmp_path_factory, at, cut, inserted):
    path = tmp_path_factory.getbasetemp() / "edited.toml"
    path.write_text(TEXT[:at] + inserted + TEXT[at + cut :], encoding="utf-8", errors="replace")
    try:
        read_model(path)
    except ExoidError as error:
        assert str(path) in str(error)


def test_models_refuse_what_they_cannot_hold():
    model = Model.standard().with_effect("stribeck:knee")
    with pytest.raises(EffectError, match="twice"):
        model.with_effect("stribeck", "knee")
    with pytest.raises(EffectError, match="its terms are: stribeck:knee"):
        model.without("stribeck:hip")
    with pytest.raises(EffectError, match="needs a joint"):
        model.with_effect("stribeck")
    with pytest.raises(EffectError, match=r"absorbed|no place"):
        model.with_effect("rotor_inertia", "hip")
    assert model_key(model.without("stribeck:knee")) == model_key(Model.standard())


def test_hip_and_knee_may_lie_in_a_plane_without_gravity(write):
    text = 'name = "flat"\ngravity = 0\n[[joints]]\nname = "hip"\nlength = 0.40\n[[joints]]\nname = "knee"\n'
    model = read_model(write(text))
    assert model.gravity == 0.0 and model.joint_names == ("hip", "knee") and model.chain
    assert len(model.inertial) == 3
    assert read_model(write_model(model, write("").with_name("again.toml"))).chain == model.chain
