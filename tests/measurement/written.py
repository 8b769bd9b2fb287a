"""A leg {name: (N,)} written in formats of other worlds, which need packages of their own: tests skip without them."""

import warnings

import numpy as np
import pandas as pd
import pytest


def mot(path, leg):
    rows = "\n".join(f"{t:.4f}\t{np.degrees(a):.9g}\t{np.degrees(b):.9g}\t{u:.9g}\t{v:.9g}" for t, a, b, u, v in zip(
        *leg.values(), strict=True))  # fmt: skip
    path.write_text(
        "Coordinates\nversion=1\nnRows=many\nnColumns=5\ninDegrees=yes\n\nUnits are S.I. units\nendheader\n"
        "time\thip_flexion_r\tknee_angle_r\thip_flexion_r_moment\tknee_angle_r_moment\n" + rows
    )


def xlsx(path, leg):
    openpyxl = pytest.importorskip("openpyxl")
    pytest.importorskip("python_calamine")
    book = openpyxl.Workbook()
    book.active.append(["exported from the bench", None, None, None, None])
    book.active.append(["Time", "Hip Angle", "Knee Angle", "Hip Torque", "Knee Torque"])
    book.active.append(["s", "rad", "rad", "Nm", "Nm"])
    for row in zip(*leg.values(), strict=True):
        book.active.append([float(cell) for cell in row])
    book.create_sheet("notes").append(["nothing"])
    book.save(path)


def tdms(path, leg):
    nptdms = pytest.importorskip("nptdms")
    channels = [
        nptdms.ChannelObject("leg", name, leg[name], properties={"wf_increment": 0.01, "unit_string": unit})
        for name, unit in (("q1", "rad"), ("q2", "rad"), ("tau1", "Nm"), ("tau2", "Nm"))
    ]
    with nptdms.TdmsWriter(str(path)) as writer:
        writer.write_segment(channels)


def bag(path, leg, two_topics=False):
    pytest.importorskip("rosbags")
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    old = path.suffix == ".bag"
    q, tau = np.column_stack([leg["q1"], leg["q2"]]), np.column_stack([leg["tau1"], leg["tau2"]])
    store = get_typestore(Stores.ROS1_NOETIC if old else Stores.ROS2_HUMBLE)
    state, header, time = (store.types[t] for t in ("sensor_msgs/msg/JointState", "std_msgs/msg/Header",
                                                    "builtin_interfaces/msg/Time"))  # fmt: skip
    kind = StoragePlugin.MCAP if path.suffix == ".mcap" else StoragePlugin.SQLITE3
    with Writer1(path) if old else Writer2(path, version=9, storage_plugin=kind) as writer:
        topics = ("/joint_states", "/torques") if two_topics else ("/joint_states",)
        lines = [writer.add_connection(topic, state.__msgtype__, typestore=store) for topic in topics]
        for k in range(len(leg["t"])):
            stamp = 1_700_000_000_000_000_000 + k * 10_000_000
            more = {"seq": k} if old else {}
            head = header(stamp=time(sec=stamp // 10**9, nanosec=stamp % 10**9), frame_id="", **more)
            for i, line in enumerate(lines):
                with_q, with_tau = i == 0, i == len(lines) - 1
                message = state(header=head, name=["hip_joint", "knee_joint"],
                                position=q[k] if with_q else np.zeros(0), velocity=np.zeros(0),
                                effort=tau[k] if with_tau else np.zeros(0))  # fmt: skip
                raw = (store.serialize_ros1 if old else store.serialize_cdr)(message, state.__msgtype__)
                writer.write(line, stamp + 3_000_000, raw)


def timetable(path, leg):
    matio = pytest.importorskip("matio")
    stamps = pd.to_timedelta(leg["t"], unit="s")
    frame = pd.DataFrame({name: leg[name] for name in ("q1", "q2", "tau1", "tau2")}, index=stamps)
    frame.index.name = "Time"
    with warnings.catch_warnings(action="ignore"):
        matio.save_to_mat(str(path), {"run": frame}, version="v7" if path.stem == "v7" else "v7.3")


def timeseries(path, leg):
    matio = pytest.importorskip("matio")
    from matio.utils.matclass import MatlabOpaque

    content = {}
    for name in ("q1", "q2", "tau1", "tau2"):
        properties = {"Data_": leg[name][:, None], "Time_": leg["t"][:, None], "Name": name}
        content[name] = MatlabOpaque(properties=properties, classname="timeseries")
    matio.save_to_mat(str(path), content, version="v7.3")


FORMATS = {"a.mot": mot, "a.sto": mot, "a.xlsx": xlsx, "a.tdms": tdms, "a.bag": bag, "bag": bag, "bag.mcap": bag,
           "v7.mat": timetable, "v73.mat": timetable, "series.mat": timeseries}  # fmt: skip
