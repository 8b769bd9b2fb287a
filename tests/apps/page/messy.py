"""Folders as loggers leave them: the demo's recordings, or simulated ones of other machines, written in many ways.

Each function fills a folder and returns what is missing there, in words, and which button answers what only a person
can know ("" where nothing need be asked).
"""

from __future__ import annotations

import json

import numpy as np
import pytest

from exoid.workbench.command import main
from exoid.workbench.commands.demo import DATA

SOURCES = (*sorted(DATA.glob("train*.csv")), DATA / "verify.csv")
DEMO = "Load-dependent friction at the knee"
NAMES = ("q1", "q2", "tau1", "tau2")


def runs():
    """The demo's recordings {name: (N,)}."""
    return [{name: run[name] for name in run.dtype.names}
            for run in (np.genfromtxt(path, delimiter=",", names=True) for path in SOURCES)]  # fmt: skip


def table(path, columns, head="", delimiter=",", decimal="."):
    """Write columns {name: (N,)} as text, below the lines of `head`."""
    rows = [delimiter.join(f"{cell:.7g}".replace(".", decimal) for cell in row) for row in zip(*columns.values())]  # noqa: B905
    path.write_text(head + "\n".join([delimiter.join(columns), *rows, ""]), encoding="utf-8")


def sides(folder):
    for k, run in enumerate(runs()):
        columns = {"Time [s]": run["t"]}
        for side, turn in (("L", 1), ("R", -1)):  # the right leg's torques belong to no motion of it
            for joint, number in (("Hip", 1), ("Knee", 2)):
                columns[f"{side}_{joint}_Angle [deg]"] = np.degrees(run[f"q{number}"][::turn])
                columns[f"{side}_{joint}_Torque [Nm]"] = run[f"tau{number}"]
        table(folder / f"trial_{k}.csv", columns)
    return DEMO, "side-left"


def degrees(folder):
    for k, run in enumerate(runs()):
        columns = {"time": run["t"], "hip_angle": np.degrees(run["q1"]), "knee_angle": np.degrees(run["q2"])}
        table(folder / f"{k}.csv", {**columns, "hip_torque": run["tau1"], "knee_torque": run["tau2"]})
    (folder / "notes.pdf").write_bytes(b"%PDF-1.4 nothing")
    (folder / "readme.txt").write_text("no table\n", encoding="utf-8")
    return DEMO, ""


def milliseconds(folder):
    for k, run in enumerate(runs()):
        columns = {"Zeit": 1000 * run["t"] + 17_000, "Winkel Hüfte": run["q1"], "Winkel Knie": run["q2"]}
        columns |= {"Drehmoment Hüfte": run["tau1"], "Drehmoment Knie": run["tau2"]}
        table(folder / f"Messung {k}.csv", columns, delimiter=";", decimal=",")
    return DEMO, ""


def headers(folder):
    for k, run in enumerate(runs()):
        head = f"Logger 3000;;\nOperator: nobody\nRun: {k}\n# exported\n"
        columns = {"Timestamp": run["t"], "Hip.Pos": run["q1"], "Knee.Pos": run["q2"]}
        columns |= {"Hip.Trq": 1000 * run["tau1"], "Knee.Trq": 1000 * run["tau2"], "Bus voltage": 48.0 + 0 * run["t"]}
        path = folder / f"log{k}.txt"
        table(path, columns, head, delimiter="\t")
        lines = path.read_text(encoding="utf-8").split("\n")
        at = next(number for number, line in enumerate(lines) if line.startswith("Timestamp")) + 1
        path.write_text("\n".join([*lines[:at], "s\trad\trad\tmNm\tmNm\tV", *lines[at:]]), encoding="utf-8")
    return DEMO, ""


def matlab(folder):
    savemat = pytest.importorskip("scipy.io").savemat
    for k, run in enumerate(runs()):
        q, tau = (np.column_stack([run[f"{one}1"], run[f"{one}2"]]) for one in ("q", "tau"))
        log = {"t": run["t"], "q_deg": np.degrees(q), "tau_Nm": tau, "fs": 100.0, "subject": "S01"}
        savemat(folder / f"S01_{k}.mat", {"log": log})
    return DEMO, ""


def bag(folder):
    pytest.importorskip("rosbags")
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    state, header, time = (store.types[name] for name in (
        "sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time"))  # fmt: skip
    for k, run in enumerate(runs()):
        with Writer(folder / f"rosbag2_{k}", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
            line = writer.add_connection("/joint_states", state.__msgtype__, typestore=store)
            for row in range(len(run["t"])):
                stamp = 1_700_000_000_000_000_000 + row * 10_000_000
                when = time(sec=stamp // 10**9, nanosec=stamp % 10**9)
                q, tau = (np.array([run[f"{one}1"][row], run[f"{one}2"][row]]) for one in ("q", "tau"))
                message = state(header=header(stamp=when, frame_id=""), name=["hip", "knee"], position=q,
                                velocity=np.zeros(0), effort=tau)  # fmt: skip
                writer.write(line, stamp, store.serialize_cdr(message, state.__msgtype__))
    return DEMO, ""


def spreadsheet(folder):
    openpyxl = pytest.importorskip("openpyxl")
    pytest.importorskip("python_calamine")
    for k, run in enumerate(runs()):
        book = openpyxl.Workbook(write_only=True)
        book.create_sheet("about").append(["bench 2", "by nobody"])
        sheet = book.create_sheet("data")
        sheet.append(["Time", "Hip Angle", "Knee Angle", "Hip Torque", "Knee Torque"])
        sheet.append(["s", "deg", "deg", "Nm", "Nm"])
        rows = (run["t"], np.degrees(run["q1"]), np.degrees(run["q2"]), run["tau1"], run["tau2"])
        for row in zip(*rows):  # noqa: B905
            sheet.append([float(cell) for cell in row])
        book.save(folder / f"Book{k}.xlsx")
    return DEMO, ""


def forces(folder):
    for k, run in enumerate(runs()):
        push = 12.0 * np.sin(1.7 * run["t"] + k) + 6.0 * np.sin(0.6 * run["t"])  # N, on the thigh 0.25 m below the hip
        columns = {**run, "tau1": run["tau1"] - 0.25 * push, "cuff_force_hip": push}
        table(folder / f"worn_{k}.csv", columns)
    return DEMO, ""


def counted(folder):
    for k, run in enumerate(runs()):  # knee flexion positive, as in biomechanics
        table(folder / f"walk{k}.csv", {**run, "q2": -run["q2"], "tau2": -run["tau2"]})
    return DEMO, "read-as"


def one_joint(folder):
    model = 'name = "bench"\n[[joints]]\nname = "axis"\nposition = [-1.2, 1.2]\nvelocity = 2.0\nacceleration = 6.0\n'
    (folder / "bench.toml").write_text(model, encoding="utf-8")
    _simulated(folder, "load_friction:axis")
    return "Load-dependent friction at the axis", ""


def three_joints(folder):
    joints = (("hip", 0.40, (-0.3, 1.2)), ("knee", 0.38, (-1.6, 0.0)), ("ankle", None, (-0.4, 0.6)))
    text = 'name = "leg with ankle"\n'
    for name, length, position in joints:
        text += f'[[joints]]\nname = "{name}"\nposition = {list(position)}\nvelocity = 1.9\nacceleration = 5.0\n'
        text += f"length = {length}\n" if length else ""
    (folder / "z_model.toml").write_text(text, encoding="utf-8")
    _simulated(folder, "load_friction:knee")
    for k, path in enumerate(sorted(folder.glob("*.csv"))):
        rows = np.genfromtxt(path, delimiter=",", names=True)
        records = [dict(zip(rows.dtype.names, map(float, row), strict=True)) for row in rows]
        (folder / f"log_{k}.jsonl").write_text("".join(json.dumps(one) + "\n" for one in records), encoding="utf-8")
        path.unlink()
    (folder / "settings.json").write_text('{"rate": 100}', encoding="utf-8")
    return "Load-dependent friction at the knee", ""


def _simulated(folder, effect):
    model = next(folder.glob("*.toml"))
    made = folder.parent / f"made of {folder.name}"
    told = ["--effect", effect, "--runs", "4", "--duration", "20", "--seed", "3", "--out", str(made), "--quiet"]
    assert main(["simulate", str(model), *told]) == 0
    for path in sorted(made.glob("*.csv")):
        path.rename(folder / path.name)


FOLDERS = (sides, degrees, milliseconds, headers, matlab, bag, spreadsheet, forces, counted, one_joint, three_joints)
