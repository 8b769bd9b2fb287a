"""URDF files: the planar machine in them, and why there is none."""

import numpy as np
import pytest

import exoid
from exoid.symbolic import Model, read_model
from exoid.symbolic.model import robot_machine
from exoid.symbolic.planar_machine import NotPlanarError, moving_with, planar_machine
from exoid.symbolic.robot_file import RobotFileError, parse_robot, read_robot
from exoid.workbench.command import main

LEG = """<?xml version="1.0"?>
<robot name="walker">
  <link name="pelvis"/>
  <link name="thigh"><inertial><origin xyz="0 0.05 -0.2"/><mass value="4"/></inertial></link>
  <link name="shank"><inertial><origin xyz="0 0 -0.2"/><mass value="3"/></inertial></link>
  <link name="foot"><inertial><origin xyz="0.06 0 -0.05"/><mass value="1"/></inertial></link>
  <link name="cover"/>
  <joint name="hip-yaw" type="revolute"><parent link="base"/><child link="pelvis"/><axis xyz="0 0 1"/></joint>
  <joint name="hip" type="revolute"><parent link="pelvis"/><child link="thigh"/><origin xyz="0 0.1 0"/>
    <axis xyz="0 -1 0"/><limit lower="-0.3" upper="1.2" velocity="1.9" effort="80"/></joint>
  <joint name="knee" type="revolute"><parent link="thigh"/><child link="shank"/>
    <origin xyz="0 0.02 -0.42" rpy="0 0 1.5707963267948966"/><axis xyz="-1 0 0"/></joint>
  <joint name="plate" type="fixed"><parent link="shank"/><child link="cover"/></joint>
  <joint name="ankle" type="continuous"><parent link="cover"/><child link="foot"/>
    <origin xyz="0 0 -0.4" rpy="0 0 -1.5707963267948966"/><axis xyz="0 -1 0"/></joint>
</robot>
"""


def robot(folder, text=LEG):
    path = folder / "robot.urdf"
    path.write_text(text, encoding="utf-8")
    return read_robot(path)


def test_a_leg_with_ankle(tmp_path, monkeypatch, capsys):
    robot(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert main(["model", "--from-urdf", "robot.urdf", "--joints", "hip,knee,ankle", "--json", "-"]) == 0
    model = read_model("walker.toml")
    assert model.joint_names == ("hip", "knee", "ankle") and model.gravity == 9.81
    assert [joint.length for joint in model.joints] == [0.42, pytest.approx(0.4), None]
    assert model.limits["hip"].angle == (-0.3, 1.2) and model.limits["hip"].velocity == 1.9
    assert [term.name for term in model.terms] == ["com_offset:ankle"], "the foot points forwards"
    assert '"in_the_file"' in capsys.readouterr().out


def test_one_sliding_drive_without_gravity(tmp_path):
    found = planar_machine(robot(tmp_path, '<robot name="emps"><joint name="drive-1" type="prismatic">'
                                 '<parent link="a"/><child link="b"/><axis xyz="1 0 0"/></joint></robot>'))  # fmt: skip
    (joint,) = found.model.joints
    assert (joint.name, joint.kind) == ("drive_1", "prismatic")
    assert found.notes == ("joint 'drive-1' is called drive_1 in the model",)


@pytest.mark.parametrize("kind", ["floating", "planar", "revolute"])
def test_a_joint_that_carries_the_machine_and_is_not_in_it_is_told(tmp_path, kind):
    root = f'<joint name="root" type="{kind}"><parent link="world"/><child link="base"/></joint>'
    fixed = '<joint name="rod" type="fixed"><parent link="world"/><child link="base"/></joint>'
    found, stands = (
        planar_machine(robot(tmp_path, LEG.replace("</robot>", text + "</robot>").replace("hip-yaw", "yaw")), ["hip"])
        for text in (root, fixed)
    )
    told, yaw = found.notes[-1], stands.notes[-1]
    assert told.startswith(f"joint 'root' ({kind}) carries the machine") and "[base] motion" in told
    assert yaw.startswith("joint 'yaw' (revolute)") and not any("rod" in note for note in stands.notes)


def test_a_flat_plane_has_no_gravity(tmp_path):
    text = LEG.replace('<origin xyz="0 0.1 0"/>', '<origin xyz="0 0.1 0" rpy="1.5707963267948966 0 0"/>')
    assert planar_machine(robot(tmp_path, text), ["hip", "knee", "ankle"]).model.gravity == 0.0


@pytest.mark.parametrize(
    ("old", "new", "joints", "message"),
    [
        ("", "", "hip-yaw,hip", "not parallel"),
        ("", "", "", "not parallel"),
        ("", "", "hip,kne", "did you mean knee"),
        ("", "", "hip,plate", "'plate' is fixed"),
        ("", "", "knee,hip", "named after it"),
        ("", "", "hip,hip", "named twice"),
        ('<axis xyz="-1 0 0"/>', '<axis xyz="1 0 0"/>', "hip,knee", "opposite signs"),
        ('xyz="0 0.02 -0.42"', 'xyz="0.2 0.02 -0.42"', "hip,knee", "away from straight down"),
        ('xyz="0 0.1 0"/>', 'xyz="0 0.1 0" rpy="0.5 0 0"/>', "hip,knee", "neither upright nor flat"),
        ('xyz="0 0 -0.4"', 'xyz="0 0 a"', "hip", "is not 3 numbers"),
        ('<mass value="3"/>', '<mass value="-3"/>', "hip,knee", "'shank' has a negative mass, -3 kg"),
        ("<robot", "<model", "hip", "not valid XML"),
        (
            '</joint>\n  <joint name="plate"',
            '<mimic joint="hip"/></joint>\n  <joint name="plate"',
            "hip,knee",
            "'knee' does not move by itself: it mimics 'hip'",
        ),
    ],
)
def test_what_is_no_planar_machine_is_refused_in_words(tmp_path, old, new, joints, message):
    with pytest.raises(RobotFileError, match=message):
        planar_machine(robot(tmp_path, LEG.replace(old, new, 1)), [name for name in joints.split(",") if name])


def test_a_file_of_macros_is_to_be_expanded_first(tmp_path):
    text = '<robot xmlns:xacro="http://ros.org/xacro" name="x"><xacro:leg side="left"/></robot>'
    with pytest.raises(RobotFileError) as refused:
        planar_machine(robot(tmp_path, text))
    assert "expand it first: xacro" in refused.value.remedy


def test_a_zero_that_is_elsewhere_makes_a_spatial_machine(tmp_path):
    text = LEG.replace('<axis xyz="0 -1 0"/><limit', '<axis xyz="0 -1 0"/><limit', 1)
    text = text.replace('xyz="0 0.02 -0.42" rpy', f'xyz="{0.42 * np.sin(0.3)} 0.02 {-0.42 * np.cos(0.3)}" rpy')
    with pytest.raises(NotPlanarError, match=r"0\.3 rad away from straight down"):
        planar_machine(robot(tmp_path, text), ["hip", "knee"])
    found = robot_machine(robot(tmp_path, text), ["hip", "knee"])
    assert found.model.spatial and "away from straight down" in found.notes[0]


def test_what_is_planar_stays_so(tmp_path):
    found = robot_machine(robot(tmp_path), ["hip", "knee", "ankle"])
    assert found.model.joints == planar_machine(robot(tmp_path), ["hip", "knee", "ankle"]).model.joints
    assert not found.model.spatial


def test_any_tree_in_space_is_a_machine_without_editing_the_file(tmp_path):
    """All that move, in an order of ours; a joint left out and fixed ones become a part of the way."""
    text = LEG.replace('<axis xyz="-1 0 0"/>', '<axis xyz="2 0 0"/>')
    swapped = text.replace('<robot name="walker">', '<robot name="walker"><joint name="toe" type="prismatic">'
                           '<parent link="foot"/><child link="tip"/><origin rpy="1.5708 0 0"/>'
                           '<axis xyz="0 0 1"/></joint>')  # fmt: skip
    found = robot_machine(robot(tmp_path, swapped))
    assert found.names == ("hip-yaw", "hip", "knee", "ankle", "toe")
    hip, knee, ankle, toe = found.model.joints[1:]
    assert (knee.axis, knee.origin.rpy[2]) == ((1.0, 0.0, 0.0), np.pi / 2)
    assert (toe.kind, toe.origin.rpy, ankle.origin.xyz) == ("prismatic", (np.pi / 2, 0.0, 0.0), (0.0, 0.0, -0.4))
    assert hip.origin.xyz == (0.0, 0.1, 0.0) and found.model.limits["hip"].angle == (-0.3, 1.2)
    assert any("right ones" in note for note in found.notes) and any("called hip_yaw" in note for note in found.notes)
    oblique = robot_machine(robot(tmp_path, LEG.replace('<axis xyz="-1 0 0"/>', '<axis xyz="0.3 0.1 1"/>')))
    assert not any("right ones" in note for note in oblique.notes), "a length that is not 1 is no angle"
    without = robot_machine(robot(tmp_path, swapped), ["hip-yaw", "knee"]).model
    assert without.joints[1].origin.xyz == (0.0, 0.12, -0.42), "the hip stands still at zero"


def test_a_machine_has_twelve_joints_at_most(tmp_path):
    joints = "".join(f'<joint name="a{k}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/></joint>'
                     for k in range(13))  # fmt: skip
    with pytest.raises(RobotFileError, match="13 joints move") as refused:
        robot_machine(robot(tmp_path, f'<robot name="long">{joints}</robot>'))
    assert "--joints" in refused.value.remedy


def test_a_mimic_joint_is_refused_in_space_too(tmp_path):
    text = LEG.replace('</joint>\n  <joint name="plate"', '<mimic joint="hip"/></joint>\n  <joint name="plate"')
    with pytest.raises(RobotFileError, match="mimics 'hip'"):
        robot_machine(robot(tmp_path, text))


def test_every_link_moves_with_the_last_joint_above_it(tmp_path):
    cable = "".join(
        f'<link name="c{k}"/><joint name="f{k}" type="fixed"><parent link="{f"c{k + 1}" if k < 999 else "foot"}"/>'
        f'<child link="c{k}"/></joint>'
        for k in range(1000)
    )
    walker = robot(tmp_path, LEG.replace("</robot>", cable + "</robot>"))
    thigh, shank, foot = moving_with(walker, [walker.joints[name] for name in ("hip", "knee", "ankle")])
    assert (thigh, {*shank}) == (["thigh"], {"shank", "cover"})
    assert {*foot} == {"foot", *(f"c{k}" for k in range(1000))}


def test_entities_are_not_expanded(tmp_path):
    bomb = '<?xml version="1.0"?><!DOCTYPE robot [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><robot name="&b;"/>'
    for encoding in ("utf-8", "utf-16"):
        path = tmp_path / f"{encoding}.urdf"
        path.write_text(bomb, encoding=encoding)
        with pytest.raises(RobotFileError, match="entities are not expanded"):
            read_robot(path)
    with pytest.raises(RobotFileError, match="deep"):
        robot(tmp_path, "<robot>" * 100)
    with pytest.raises(RobotFileError, match="go round"):
        robot(tmp_path, '<robot><joint name="a"><parent link="x"/><child link="y"/></joint>'
              '<joint name="b"><parent link="y"/><child link="x"/></joint></robot>')  # fmt: skip


@pytest.mark.parametrize("encoding", ["klingon", "shift_jis", "base64", "rot13", "utf-7", "punycode", "undefined"])
def test_an_encoding_that_is_not_read_is_refused_in_words(encoding):
    with pytest.raises(RobotFileError, match=r"encoding|XML"):
        parse_robot(f'<?xml version="1.0" encoding="{encoding}"?><robot name="b\xe4"/>'.encode("latin-1"))


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "latin-1"])
def test_other_encodings_are_read(encoding):
    said = "" if encoding != "latin-1" else ' encoding="latin-1"'
    assert parse_robot(f'<?xml version="1.0"{said}?><robot name="b\xe4r"/>'.encode(encoding)).name == "b\xe4r"


@pytest.mark.parametrize(("kind", "once", "again"), [("joint", "hip-yaw", "hip"), ("link", "pelvis", "thigh")])
def test_two_of_one_name_are_refused(kind, once, again):
    with pytest.raises(RobotFileError, match=f"two {kind}s are called '{again}'"):
        parse_robot(LEG.replace(f'<{kind} name="{once}"', f'<{kind} name="{again}"').encode())


@pytest.mark.parametrize("number", ["1e308", "inf", "nan", "1e400"])
def test_numbers_that_no_machine_has_are_refused(number):
    with pytest.raises(RobotFileError, match="is not 3 numbers"):
        parse_robot(LEG.replace('xyz="0 0 -0.4"', f'xyz="0 0 {number}"').encode())


def test_a_urdf_is_a_model_wherever_one_is_asked_for(tmp_path, capsys):
    path = tmp_path / "arm.urdf"
    text = LEG.replace("hip-yaw\" type=\"revolute", "hip-yaw\" type=\"fixed").replace("continuous", "fixed")
    path.write_text(text.replace("knee\" type=\"revolute", "knee\" type=\"fixed"), encoding="utf-8")
    models = [read_model(path), Model.load(path), Model.from_urdf(path), exoid.read_model(str(path))]
    assert {one.joint_names for one in models} == {("hip",)}
    assert Model.from_urdf(path, joints=["hip"], gravity=0.0).gravity == 0.0
    out = tmp_path / "runs"
    assert main(["simulate", str(path), "--duration", "3", "--out", str(out), "--quiet"]) == 0
    assert main(["compare", str(out), "--model", str(path), "--quiet"]) == 0
    path.write_text("no robot", encoding="utf-8")
    assert main(["compare", str(out), "--model", str(path)]) == 2
    assert "not valid XML" in capsys.readouterr().err
