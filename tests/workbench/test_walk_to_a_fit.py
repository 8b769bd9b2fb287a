"""From files as people have them to a fit: the remedy that is printed is typed, gets further each time, and two are
enough.
"""

from __future__ import annotations

import numpy as np
import pytest

from tests.typed_remedies import walk

T = np.arange(1500) * 0.01
CASES = {
    "01-openexo-trial": ("trial_0.csv trial_1.csv trial_2.csv --verify trial_3.csv", "ankle.toml"),
    "02-cart-pendulum": ("run_0.csv run_1.csv run_2.csv --verify run_3.csv", "cart.toml"),
    "05-servo-registers": ("twos_log_0.csv twos_log_1.csv --verify twos_log_3.csv", "servo.toml"),
    "05-servo-registers/": ("sign_log_0.csv sign_log_1.csv --verify sign_log_3.csv", "servo.toml"),
    "09-wrong-effort-map": ("run_0.csv run_1.csv --verify run_3.csv", None),
    "10-unknown-payload": ("run_0.csv run_1.csv run_3.csv --verify run_2.csv", None),
    "12-constant-speed": ("v_0.05.csv v_0.1.csv v_0.8.csv --verify v_0.4.csv", "j.toml"),
    "16-offset-per-session": ("run_0.csv run_1.csv --verify run_3.csv", None),
    "18-long-table": ("log_0.csv log_1.csv --verify log_2.csv", "one.toml"),
    "20-encoder-counts": ("run_0.csv run_1.csv run_2.csv --verify run_3.csv", None),
    "21-clock-rate": ("run_0.csv run_1.csv --verify run_3.csv", None),
    "22-payload-midway": ("run_0.csv run_1.csv --verify run_3.csv", None),
    "23-float-clock": ("run_0.csv run_1.csv --verify run_3.csv", None),
    "24-smooth-angles": ("run_0.csv run_1.csv --verify run_3.csv", None),
    "25-one-waveform": ("run_0.csv run_1.csv run_2.csv --verify run_4.csv", "j.toml"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_cases_of_others_lead_to_a_fit(name, shared_data, capsys):
    folder = shared_data.parent / "cases" / name.rstrip("/")
    if not folder.is_dir():
        pytest.skip(f"no {folder}")
    words, model = CASES[name]
    files = [word if word.startswith("--") else str(folder / "runs.zip" / word) for word in words.split()]
    walk(capsys, "compare", *files, *(["--model", str(folder / model)] if model else []))


LEG = {
    "q1": 0.5 * np.sin(2 * T) + 0.2 * np.sin(3.7 * T), "q2": -0.8 + 0.4 * np.sin(2.6 * T) + 0.2 * np.cos(4.1 * T),
}  # fmt: skip
LEG |= {"tau1": 12 * np.sin(LEG["q1"]) + 1.5 * np.cos(2 * T), "tau2": 4 * np.sin(LEG["q1"] + LEG["q2"])}
COUNTS = np.round(2048 + 652 * LEG["q1"])
LOAD = np.round(60 * LEG["tau1"])
HIP, KNEE = ({"q": LEG[f"q{k}"], "tau": LEG[f"tau{k}"]} for k in (1, 2))
SERVO = '[[joints]]\nname = "servo"\n'
TORQUE = np.where(LOAD < 0, LOAD + 65536, LOAD)
MADE = {
    "no clock": (LEG, "", ["--rate"]),
    "both legs": (
        {"t": T} | {
            f"{side}_{joint}_{what}": values
            for side in ("left", "right")
            for joint, one in (("hip", HIP), ("knee", KNEE))
            for what, values in (("angle", one["q"]), ("torque", one["tau"]))
        },
        "", ["--leg"],
    ),
    "currents": (
        {"t": T, "q_0": HIP["q"], "q_1": KNEE["q"], "current_0": HIP["tau"], "current_1": KNEE["tau"]},
        "", ["--units"],
    ),
    "amperes as torque": (
        {"t": T, "hip angle": HIP["q"], "knee angle": KNEE["q"], "hip torque [A]": HIP["tau"],
         "knee torque [A]": KNEE["tau"]},
        "", ["--units"],
    ),
    "per cent": (
        {"t": T, "q1": HIP["q"], "q2": KNEE["q"], "tau1": HIP["tau"], "tau2 [%]": KNEE["tau"]}, "", ["--units"]
    ),
    "a unit that nobody knows": (
        {"t": T, "q1 [furlong]": HIP["q"], "q2": KNEE["q"], "tau1": HIP["tau"], "tau2": KNEE["tau"]}, "", ["--units"]
    ),
    "two angles": (
        {"t": T, "theta1": HIP["q"], "phi1": HIP["q"] + 0.01 * np.sin(9 * T), "q2": KNEE["q"], "tau1": HIP["tau"],
         "tau2": KNEE["tau"]},
        "", ["--map"],
    ),
    "states": (
        {"timestamp": T, "state_0": HIP["q"], "state_1": KNEE["q"], "motor_load_0": HIP["tau"],
         "motor_load_1": KNEE["tau"]},
        "", ["--map"],
    ),
    "blanks in names": (
        {"t": T, "Hip encoder value (new)": HIP["q"], "Knee encoder value (new)": KNEE["q"],
         "Hip strain gauge": HIP["tau"], "Knee strain gauge": KNEE["tau"]},
        "", ["--map", "--units"],
    ),
    "a letter and a joint in another language": (
        {"Zeit [s]": T, "q_Hüfte [rad]": HIP["q"], "q_Knie [rad]": KNEE["q"], "M_Hüfte [Nm]": HIP["tau"],
         "M_Knie [Nm]": KNEE["tau"]},
        "", ["--map"],
    ),
    "counts": ({"t": T, "q": COUNTS, "tau": HIP["tau"]}, SERVO, ["--units"]),
    "a register of 8 bits": (
        {"t": T, "pos": HIP["q"], "tau": np.round(4 * HIP["tau"]) % 256}, SERVO, ["--units"]
    ),
    "a register of 16 bits behind a factor": (
        {"t": T, "q": HIP["q"], "tau [Nm]": 0.01 * (np.round(100 * HIP["tau"]) % 65536)}, SERVO, []
    ),
    "angles in a register": (
        {"t": T, "q1": np.round(2000 * HIP["q"]) % 65536, "q2": np.round(2000 * KNEE["q"]) % 65536,
         "tau1": HIP["tau"], "tau2": KNEE["tau"]},
        "", ["--units"],
    ),
    "counts of a drive and its current": (
        {"t": T, "Present_Position": COUNTS, "Present_Current": TORQUE}, SERVO, ["--units"]
    ),
    "whole degrees": (
        {"t": T, "q1": np.round(np.degrees(HIP["q"])), "q2": np.round(np.degrees(KNEE["q"])), "tau1": HIP["tau"],
         "tau2": KNEE["tau"]},
        "", ["--units"],
    ),
    "grados": (
        {"tiempo": T, "cadera [grados]": np.degrees(HIP["q"]), "rodilla [grados]": np.degrees(KNEE["q"]),
         "cadera [Nm]": HIP["tau"], "rodilla [Nm]": KNEE["tau"]},
        "", [],
    ),
    "a unit of another language": (
        {"t": T, "q1 [stopnie]": np.degrees(HIP["q"]), "q2": KNEE["q"], "tau1": HIP["tau"], "tau2": KNEE["tau"]},
        "", ["--units"],
    ),
    "joints of a robot": (
        {"t": T, "panda_joint0_pos": HIP["q"], "panda_joint1_pos": KNEE["q"], "panda_joint0_effort": HIP["tau"],
         "panda_joint1_effort": KNEE["tau"]},
        '[[joints]]\nname = "j0"\nlength = 0.3\n[[joints]]\nname = "j1"\n', ["--map"],
    ),
    "a register": ({"t": T, "pos": COUNTS, "load": TORQUE}, SERVO, ["--map", "--units"]),
    "row numbers": ({"t": np.arange(T.size), **LEG}, "", ["--rate"]),
    "milliseconds": ({"t": 1000 * T, **LEG}, "", []),
    "a state of positions and rates": (
        {"t": T, "x1": HIP["q"], "x2": np.gradient(HIP["q"], T), "u": HIP["tau"]}, SERVO, ["--map"]
    ),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", MADE)
def test_files_as_people_make_them_lead_to_a_fit(name, tmp_path, capsys):
    columns, model, options = MADE[name]
    there = {key: values for key, values in columns.items() if values is not None}
    lines = [",".join(f"{x:.7g}" for x in row) for row in zip(*there.values(), strict=True)]
    (tmp_path / "run.csv").write_text("\n".join([",".join(there), *lines, ""]), encoding="utf-8")
    (tmp_path / "m.toml").write_text(model, encoding="utf-8")
    words = ["--model", tmp_path / "m.toml"] if model else []
    typed, _ = walk(capsys, "compare", tmp_path / "run.csv", *words)
    assert [word for word in typed if word.startswith("--")] == options


def rows_of(head, keys, mark=","):
    """Text with one value a row."""
    there = {key: values for key, values in keys.items()}
    lines = [f"{t:.4f}{mark}{key}{mark}{values[k]:.7g}" for k, t in enumerate(T) for key, values in there.items()]
    return "\n".join([head, *lines, ""])


def as_long_table(folder):
    (folder / "m.toml").write_text(SERVO, encoding="utf-8")
    (folder / "log.csv").write_text(rows_of("Zeit;Kanal;Wert", {"Winkel": HIP["q"], "Drehmoment": HIP["tau"]}, ";"))
    return ["log.csv", "--model", "m.toml"], []


def as_long_table_of_other_names(folder):
    (folder / "log.csv").write_text(rows_of("t,topic,measurement", {f"/exo/{n}/state": v for n, v in LEG.items()}))
    return ["log.csv"], []


def as_lists(folder):
    pa, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    cells = {"observation.state": ("q1", "q2"), "observation.effort": ("tau1", "tau2"), "action": ("q2", "q1")}
    lists = {name: np.column_stack([LEG[one] for one in pair]).tolist() for name, pair in cells.items()}
    parquet.write_table(pa.table({"timestamp": T, **lists}), folder / "episode.parquet")
    return ["episode.parquet"], ["--map"]


def as_lists_of_state_alone(folder):
    """Angles and torques in one list, as some robots have them."""
    pa, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    state = np.column_stack([LEG["q1"], LEG["q2"]]).tolist()
    load = np.column_stack([LEG["tau1"], LEG["tau2"]]).tolist()
    table = {"timestamp": T, "observation.state": state, "observation.load": load, "action": state}
    parquet.write_table(pa.table(table), folder / "episode.parquet")
    return ["episode.parquet"], ["--map"]


def as_arrays(folder):
    q, tau = (np.column_stack([LEG[f"{one}1"], LEG[f"{one}2"]]) for one in ("q", "tau"))
    np.savez(folder / "run.npz", times=T, q=q, tau=tau)
    return ["run.npz"], []


def as_arrays_without_a_clock(folder):
    q, tau = (np.column_stack([LEG[f"{one}1"], LEG[f"{one}2"]]) for one in ("q", "tau"))
    np.savez(folder / "run.npz", positions=q, efforts=tau)
    return ["run.npz"], ["--rate"]


def of_a_robot(folder):
    inertial = '<inertial><mass value="1"/><origin xyz="0 0 -0.15"/>'
    inertial += '<inertia ixx="0.01" iyy="0.01" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>'
    links = "".join(f'<link name="{name}">{inertial}</link>' for name in ("base", "upper", "lower"))
    joints = "".join(
        f'<joint name="{name}" type="revolute"><parent link="{above}"/><child link="{below}"/><origin xyz="0 0 {z}"/>'
        '<axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="5" effort="50"/></joint>'
        for name, above, below, z in (("shoulder", "base", "upper", 0), ("elbow", "upper", "lower", -0.3))
    )
    (folder / "arm.urdf").write_text(f'<robot name="arm">{links}{joints}</robot>', encoding="utf-8")
    names = {"q1": "shoulder_pos", "q2": "elbow_pos", "tau1": "shoulder_effort", "tau2": "elbow_effort"}
    np.savez(folder / "run.npz", times=T, **{names[key]: values for key, values in LEG.items()})
    return ["run.npz", "--model", "arm.urdf"], []


@pytest.mark.slow
@pytest.mark.parametrize(
    "fill",
    [as_long_table, as_long_table_of_other_names, as_lists, as_lists_of_state_alone, as_arrays,
     as_arrays_without_a_clock, of_a_robot],
    ids=lambda fill: fill.__name__,
)  # fmt: skip
def test_other_shapes_and_models_lead_to_a_fit(fill, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words, options = fill(tmp_path)
    typed, _ = walk(capsys, "compare", *words)
    assert [word for word in typed if word.startswith("--")] == options
