"""Header styles of public exoskeleton, biomechanics and robotics projects: read as meant, or a question."""

import numpy as np
import pytest
from tables import leg

from exoid.ground.errors import RecordingError
from exoid.measurement.reading.read import read_recording, read_recordings

LEG = leg()
COLUMNS = ("t", "q1", "q2", "tau1", "tau2")
ONE_LEG = {
    "plain names": "time,hip_angle,knee_angle,hip_torque,knee_torque",
    "OpenSim, one leg": "time,hip_flexion_r,knee_angle_r,hip_flexion_r_moment,knee_angle_r_moment",
    "gait data set in MATLAB tables": "Header,hip_flexion_r,knee_angle_r,hip_flexion_r_moment,knee_angle_r_moment",
    "hip exoskeleton, filtered": "time,hip_angle_r,knee_angle_r,hip_flexion_r_moment,knee_angle_r_moment",
    "locomotion standard": "time_s,hip_flexion_angle_ipsi_rad,knee_flexion_angle_ipsi_rad,hip_flexion_moment_ipsi_Nm,"
    "knee_flexion_moment_ipsi_Nm",
    "locomotion standard, early": "time,hip_angle_s_r,knee_angle_s_r,hip_torque_s_r,knee_torque_s_r",
    "rostopic echo -p": "%time,field.position0,field.position1,field.effort0,field.effort1",
    "PlotJuggler": "__time,/joint_states/hip_joint/position,/joint_states/knee_joint/position,"
    "/joint_states/hip_joint/effort,/joint_states/knee_joint/effort",
    "rqt arrays": "time,/joint_states/position[0],/joint_states/position[1],/joint_states/effort[0],"
    "/joint_states/effort[1]",
    "joint groups": "timestamp,joint1/position,joint2/position,joint1/torque,joint2/torque",
    "Simulink": "simout.time,simout.hip.angle,simout.knee.angle,simout.hip.torque,simout.knee.torque",
    "dSPACE": "time,Model Root/Leg/Hip Angle/Out1,Model Root/Leg/Knee Angle/Out1,Model Root/Leg/Hip Torque/Out1,"
    "Model Root/Leg/Knee Torque/Out1",
    "TwinCAT": "Name,MAIN.HipAxis.NcToPlc.ActPos,MAIN.KneeAxis.NcToPlc.ActPos,MAIN.HipAxis.NcToPlc.ActTorque,"
    "MAIN.KneeAxis.NcToPlc.ActTorque",
    "LabVIEW": "X_Value,Hip Angle (rad),Knee Angle (rad),Hip Torque (Nm),Knee Torque (Nm)",
    "prosthesis": "t,osl.hip.output_position,osl.knee.output_position,osl.hip.joint_torque,osl.knee.joint_torque",
    "MuJoCo": "time,qpos_hip,qpos_knee,qfrc_actuator_hip,qfrc_actuator_knee",
    "PyBullet": "time,jointPosition0,jointPosition1,appliedJointMotorTorque0,appliedJointMotorTorque1",
    "Pinocchio": "t,q[0],q[1],tau[0],tau[1]",
    "ODrive with torque": "time,axis0.encoder.pos_estimate,axis1.encoder.pos_estimate,axis0.motor.torque_estimate,"
    "axis1.motor.torque_estimate",
    "EtherCAT node names": "Time,Node1.Position actual value,Node2.Position actual value,Node1.Torque actual value,"
    "Node2.Torque actual value",
    "camel case": "timeStamp,RHipAngle,RKneeAngle,RHipTorque,RKneeTorque",
    "German": "Zeit,Hüfte Winkel,Knie Winkel,Hüfte Drehmoment,Knie Drehmoment",
    "a leg as a group": "t,left_leg.hip.angle,left_leg.knee.angle,left_leg.hip.torque,left_leg.knee.torque",
}
TWO_LEGS = {
    "words in front": "{side}_hip_position,{side}_knee_position,{side}_hip_torque,{side}_knee_torque",
    "camel case": "{S}HipAngle,{S}KneeAngle,{S}HipMoment,{S}KneeMoment",
    "OpenSim": "hip_flexion_{s},knee_angle_{s},hip_flexion_{s}_moment,knee_angle_{s}_moment",
    "symbols": "q_hip_{s},q_knee_{s},tau_hip_{s},tau_knee_{s}",
    "groups": "/{side}_leg/hip/position,/{side}_leg/knee/position,/{side}_leg/hip/effort,/{side}_leg/knee/effort",
}


def written(path, header, columns):
    cells = np.column_stack(columns)
    path.write_text(header + "\n" + "\n".join(",".join(f"{x:.9g}" for x in row) for row in cells) + "\n")
    return path


@pytest.mark.parametrize("style", ONE_LEG)
def test_one_leg_is_read_as_meant(style, tmp_path):
    path = written(tmp_path / "run.csv", ONE_LEG[style], [LEG[name] for name in COLUMNS])
    recording = read_recording(path)
    np.testing.assert_allclose(recording.t, LEG["t"], atol=1e-8)
    np.testing.assert_allclose(recording.q, np.column_stack([LEG["q1"], LEG["q2"]]), atol=1e-8)
    np.testing.assert_allclose(recording.tau, np.column_stack([LEG["tau1"], LEG["tau2"]]), atol=1e-7)


@pytest.mark.parametrize("style", TWO_LEGS)
def test_two_legs_are_a_question(style, tmp_path):
    names = {side: TWO_LEGS[style].format(side=side, s=side[0], S=side[0].upper()) for side in ("left", "right")}
    right = [LEG[name] for name in COLUMNS[1:]]
    left = [2 * column for column in right]
    path = written(tmp_path / "run.csv", f"time,{names['left']},{names['right']}", [LEG["t"], *left, *right])
    with pytest.raises(RecordingError, match="more than one leg") as asked:
        read_recording(path)
    assert "--leg left or --leg right or --leg both" in asked.value.remedy
    for side, factor in (("left", 2.0), ("right", 1.0)):
        np.testing.assert_allclose(read_recording(path, leg=side).q[:, 0], factor * LEG["q1"], atol=1e-7)
    both = read_recordings([path], leg="both")
    assert [one.name for one in both] == ["run (left)", "run (right)"]
    np.testing.assert_allclose(both[0].tau, 2 * both[1].tau, atol=1e-6)


def test_the_other_leg_is_never_taken_instead(tmp_path):
    path = written(tmp_path / "run.csv", ONE_LEG["OpenSim, one leg"], [LEG[name] for name in COLUMNS])
    with pytest.raises(RecordingError, match="no columns of the left leg"):
        read_recording(path, leg="left")


def test_the_only_leg_with_torques_is_read(tmp_path):
    header = "time,left_hip_angle,left_knee_angle,right_hip_angle,right_knee_angle,right_hip_torque,right_knee_torque"
    columns = [LEG["t"], *(LEG[n] * 2 for n in ("q1", "q2")), *(LEG[n] for n in COLUMNS[1:])]
    recording = read_recording(written(tmp_path / "run.csv", header, columns))
    np.testing.assert_allclose(recording.q[:, 0], LEG["q1"], atol=1e-8)


@pytest.mark.parametrize(
    ("header", "what"),
    [
        ("t,hip_angle,knee_angle,right_hip_angle,right_knee_angle,right_hip_torque,right_knee_torque", "can be q1"),
        ("t,hip_angle_raw,hip_angle_filt,knee_angle,hip_torque,knee_torque,x1", "can be q1"),
        ("t,thigh_angle,shank_angle,hip_torque,knee_torque,a,b", "no column for q1, q2"),
    ],
)
def test_doubt_is_a_question(header, what, tmp_path):
    columns = [LEG["t"], *(LEG[n] + k for k, n in enumerate(("q1", "q2", "q1", "q2", "tau1", "tau2")))]
    columns = columns[: len(header.split(","))]
    path = written(tmp_path / "run.csv", header, columns)
    with pytest.raises(RecordingError, match=what):
        read_recording(path)


@pytest.mark.parametrize(
    ("name", "scale"),
    [("timestamp", 1.0), ("epoch", 1e3), ("timestamp", 1e6), ("field.header.stamp", 1e9), ("time_ms", None)],
)
def test_epochs_in_any_unit(name, scale, tmp_path):
    stamps = (1_700_000_000 * int(scale) + np.round(LEG["t"] * scale)) if scale else LEG["t"] * 1e3
    if scale == 1.0:
        stamps = 1_700_000_000 + LEG["t"]
    cells = [[f"{x:.3f}" if scale in (1.0, None) else str(int(x)) for x in stamps]]
    cells += [[f"{x:.9g}" for x in LEG[n]] for n in COLUMNS[1:]]
    path = tmp_path / "run.csv"
    rows = "\n".join(",".join(row) for row in zip(*cells, strict=True))
    path.write_text(f"{name},q1,q2,tau1,tau2\n{rows}\n")
    recording = read_recording(path)
    np.testing.assert_allclose(recording.t - recording.t[0], LEG["t"], atol=1e-6)


def test_two_columns_of_one_clock_are_no_question(tmp_path):
    header = "time,timestamp,q1,q2,tau1,tau2"
    columns = [LEG["t"], 1e3 * LEG["t"] + 5e4, *(LEG[n] for n in COLUMNS[1:])]
    np.testing.assert_allclose(read_recording(written(tmp_path / "a.csv", header, columns)).t, LEG["t"], atol=1e-8)
    columns[1] = LEG["t"] ** 1.1
    with pytest.raises(RecordingError, match="can be t"):
        read_recording(written(tmp_path / "b.csv", header, columns))


def test_currents_ask_for_their_constant(tmp_path):
    header = "t,q1,q2,hip_current [mA],knee_iq"
    columns = [LEG["t"], LEG["q1"], LEG["q2"], LEG["tau1"] / 0.5 * 1e3, LEG["tau2"] / 0.738]
    path = written(tmp_path / "run.csv", header, columns)
    with pytest.raises(RecordingError, match="but currents") as asked:
        read_recording(path)
    assert "--units tau1=Nm/A*0.1*50,tau2=" in asked.value.remedy
    recording = read_recording(path, units={"tau1": "Nm/A*0.05*10", "tau2": "Nm/A*0.123*6"})
    np.testing.assert_allclose(recording.tau[:, 0], LEG["tau1"], rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(recording.tau[:, 1], LEG["tau2"], rtol=1e-6, atol=1e-6)


def test_torque_per_body_mass_asks_for_the_mass(tmp_path):
    header = "t,q1,q2,hip_moment_Nm_kg,knee_moment [Nm/kg]"
    columns = [LEG["t"], LEG["q1"], LEG["q2"], LEG["tau1"] / 70, LEG["tau2"] / 70]
    path = written(tmp_path / "run.csv", header, columns)
    with pytest.raises(RecordingError, match="further number") as asked:
        read_recording(path)
    assert "body mass" in asked.value.remedy
    recording = read_recording(path, units={"tau": "Nm/kg*70"})
    np.testing.assert_allclose(recording.tau[:, 1], LEG["tau2"], rtol=1e-6, atol=1e-6)


Q_DEG = [np.degrees(LEG["q1"]), np.degrees(LEG["q2"])]
SIDE = [np.zeros_like(LEG["t"])] * 2
FRAME = np.arange(1.0, len(LEG["t"]) + 1)
MOTION_CAPTURE = {
    "Vicon, model outputs": (
        "Model Outputs\n100\n,,P01:RHipAngles,,,P01:RKneeAngles,,,P01:RHipMoment,,,P01:RKneeMoment,,\n"
        "Frame,Sub Frame,X,Y,Z,X,Y,Z,X,Y,Z,X,Y,Z\n,,deg,deg,deg,deg,deg,deg,N.mm,N.mm,N.mm,N.mm,N.mm,N.mm",
        [FRAME, SIDE[0], Q_DEG[0], *SIDE, Q_DEG[1], *SIDE, 1e3 * LEG["tau1"], *SIDE, 1e3 * LEG["tau2"], *SIDE],
    ),
    "Vicon, devices": (
        "Devices\n100\n,,Hip - Encoder,Knee - Encoder,Hip - Torque,Knee - Torque\n"
        "Frame,Sub Frame,Angle,Angle,Torque,Torque\n,,deg,deg,Nm,Nm",
        [1 + (FRAME - 1) // 10, (FRAME - 1) % 10, *Q_DEG, LEG["tau1"], LEG["tau2"]],
    ),
    "joints above quantities": (
        "Joint,Hip,,Knee,\nTime,Angle,Torque,Angle,Torque\ns,deg,Nm,deg,Nm",
        [LEG["t"], Q_DEG[0], LEG["tau1"], Q_DEG[1], LEG["tau2"]],
    ),
    "quantities above joints": (
        "Time,Angle,Angle,Torque,Torque\n,Hip,Knee,Hip,Knee\n[s],[deg],[deg],[Nm],[Nm]",
        [LEG["t"], *Q_DEG, LEG["tau1"], LEG["tau2"]],
    ),
    "units beside the lower names": (
        "Time,Hip,Hip,Knee,Knee\n[s],Angle [deg],Torque [Nm],Angle [deg],Torque [Nm]",
        [LEG["t"], Q_DEG[0], LEG["tau1"], Q_DEG[1], LEG["tau2"]],
    ),
    "Qualisys, frames without time": (
        "NO_OF_FRAMES,1500\nFREQUENCY,100\nDATA_INCLUDED,3D\n"
        "Frame,Hip Angle [deg],Knee Angle [deg],Hip Moment [Nm],Knee Moment [Nm]",
        [FRAME, *Q_DEG, LEG["tau1"], LEG["tau2"]],
    ),
}


@pytest.mark.parametrize("name", MOTION_CAPTURE)
def test_names_in_two_rows_and_frames_for_time(name, tmp_path):
    header, columns = MOTION_CAPTURE[name]
    recording = read_recording(written(tmp_path / "run.csv", header, columns))
    np.testing.assert_allclose(recording.q, np.column_stack([LEG["q1"], LEG["q2"]]), atol=1e-7)
    np.testing.assert_allclose(recording.tau, np.column_stack([LEG["tau1"], LEG["tau2"]]), rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(recording.t - recording.t[0], LEG["t"], atol=1e-6)


def test_frames_without_a_rate_are_no_time(tmp_path):
    path = written(tmp_path / "run.csv", "Frame,q1,q2,tau1,tau2", [FRAME, *(LEG[n] for n in COLUMNS[1:])])
    with pytest.raises(RecordingError, match="no time column"):
        read_recording(path)


def test_three_joints_counted_from_0_are_three_joints(tmp_path):
    columns = [LEG["t"], *(LEG[n] + k for k, n in enumerate(("q1", "q2", "q1", "tau1", "tau2", "tau1")))]
    found = read_recording(written(tmp_path / "run.csv", "t,q0,q1,q2,tau0,tau1,tau2", columns))
    assert len(found.joints) == 3 and found.q[:, 2] == pytest.approx(LEG["q1"] + 2, abs=1e-5)
