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
    "counts": ({"t": T, "q": COUNTS, "tau": HIP["tau"]}, SERVO, ["--units"]),
    "a register": ({"t": T, "pos": COUNTS, "load": TORQUE}, SERVO, ["--map", "--units"]),
    "row numbers": ({"t": np.arange(T.size), **LEG}, "", ["--rate"]),
    "milliseconds": ({"t": 1000 * T, **LEG}, "", []),
    "a state of positions and rates": (
        {"t": T, "x1": HIP["q"], "x2": np.gradient(HIP["q"], T), "u": HIP["tau"]}, SERVO, ["--map"]
    ),
}  # fmt: skip


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
