"""Folders as people have them, on the page and on the command line: the same recordings, the same error, or the same
question.
"""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest

from exoid.apps.page.commands import open as command
from exoid.apps.page.work import _next
from exoid.apps.page.workspace import Workspace
from exoid.ground.errors import ExoidError
from exoid.workbench.command import main
from exoid.workbench.commands.demo import DATA

RUNS = [np.genfromtxt(path, delimiter=",", names=True)[:800] for path in sorted(DATA.glob("train*.csv"))[:2]]
SHORT = ("t", "q1", "q2", "tau1", "tau2")


def table(path, columns):
    rows = [",".join(f"{cell:.7g}" for cell in row) for row in zip(*columns.values(), strict=True)]
    path.write_text("\n".join([",".join(columns), *rows, ""]), encoding="utf-8")


def each(folder, made, suffix=".csv"):
    for k, run in enumerate(RUNS):
        table(folder / f"run_{k}{suffix}", made({name: run[name] for name in SHORT}))


def sidecars(folder):
    each(folder, lambda run: run)
    table(folder / "calibration.csv", {name: 0.1 + 0.0 * RUNS[0]["t"] for name in SHORT} | {"t": RUNS[0]["t"]})
    for k in range(5):
        (folder / f"video_{k}.json").write_text('{"fps": 30, "camera": "left"}', encoding="utf-8")


def documents(folder):
    each(folder, lambda run: run | {"q1 [Grad]": np.degrees(run.pop("q1")), "q2 [Grad]": np.degrees(run.pop("q2"))})
    (folder / "notes.pdf").write_bytes(b"%PDF-1.4 nothing")
    (folder / "readme.txt").write_text("Nothing, but for 3 words, and a few more.\n" * 40, encoding="utf-8")


def one_value_a_row(folder):
    for k, run in enumerate(RUNS):
        lines = [f"{t:.4f},{name},{run[name][n]:.7g}" for n, t in enumerate(run["t"]) for name in SHORT[1:]]
        (folder / f"log_{k}.csv").write_text("\n".join(["Zeit,Kanal,Wert", *lines, ""]), encoding="utf-8")


def registers(folder):
    each(folder, lambda run: run | {"tau1": np.round(50 * run["tau1"]) % 65536 * 0.02})


def arrays(folder):
    for k, run in enumerate(RUNS):
        q, tau = (np.column_stack([run[f"{one}1"], run[f"{one}2"]]) for one in ("q", "tau"))
        np.savez(folder / f"{k}.npz", times=run["t"], q=q, tau=tau)
    np.savez(folder / "camera.npz", intrinsics=np.eye(3))


def lists(folder):
    pa, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    for k, run in enumerate(RUNS):
        pairs = {"observation.state": ("q1", "q2"), "observation.effort": ("tau1", "tau2"), "action": ("q2", "q1")}
        cells = {name: [[run[a][n], run[b][n]] for n in range(len(run))] for name, (a, b) in pairs.items()}
        parquet.write_table(pa.table({"timestamp": run["t"], **cells}), folder / f"episode_{k}.parquet")
    (folder / "info.json").write_text('{"robot_type": "leg"}', encoding="utf-8")


def no_clock(folder):
    each(folder, lambda run: {name: values for name, values in run.items() if name != "t"})


def both_legs(folder):
    sides = {"left": 1.0, "right": 0.9}
    names = (("q1", "hip_angle"), ("q2", "knee_angle"), ("tau1", "hip_torque"), ("tau2", "knee_torque"))
    each(folder, lambda run: {"t": run["t"]} | {f"{s}_{n}": k * run[q] for s, k in sides.items() for q, n in names})


def seven_joints(folder):
    seven = [(q, k) for q in ("q", "tau") for k in range(7)]
    each(folder, lambda run: {"t": run["t"]} | {f"{q}_{k}": run[f"{q}1"] + 0.1 * k for q, k in seven})


def set_points(folder):
    each(folder, lambda run: {name if name == "t" else f"{name}_desired": values for name, values in run.items()})


def counts(folder):
    each(folder, lambda run: run | {"q1": np.round(2000 * run["q1"]), "q2": np.round(2000 * run["q2"])})


def nothing(folder):
    (folder / "notes.txt").write_text("nothing here\n", encoding="utf-8")


FOLDERS = (
    sidecars, documents, one_value_a_row, registers, arrays, lists, no_clock, both_legs, seven_joints, set_points,
    counts, nothing,
)  # fmt: skip


def on_the_page(folder):
    """What the page has of a folder: the errors of its comparison, and what it says where it cannot read it."""
    told = {"map": [], "units": [], "leg": None, "convention": [], "join": [], "payload": [], "passive": []}
    told |= {"verify": [], "model": None, "wearer": None, "condition": "", "clock_rate": 0.0}
    args = SimpleNamespace(recordings=[str(folder)], **told)
    space = Workspace(folder.parent / "maps", 0)
    try:
        said = []
        try:
            command._open(space, args)
            while space.stale or not all(one.read for one in space.given):
                _next(space)()
        except ExoidError as error:
            said = [str(error)]
        said += [str(one.error) for one in space.given if one.error is not None]
        return (None if space.session is None or said else space.opened().compare().rms), said
    finally:
        space.close()


@pytest.mark.slow
@pytest.mark.parametrize("fill", FOLDERS, ids=lambda fill: fill.__name__)
def test_a_folder_has_the_same_answer_on_the_page_and_on_the_command_line(fill, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("EXOID_CACHE", str(tmp_path / "cache"))
    folder = tmp_path / fill.__name__
    folder.mkdir()
    fill(folder)
    status = main(["compare", str(folder), "--json", str(tmp_path / "out.json"), "--quiet"])
    error = capsys.readouterr().err
    rms, said = on_the_page(folder)
    if status == 2:
        asked, *told = (" ".join(text.replace(f"{folder}/", "").split()) for text in (error[len("exoid: ") :], *said))
        assert rms is None and asked in told
    else:
        assert status == 0 and not said
        assert rms == pytest.approx(json.loads((tmp_path / "out.json").read_text("utf-8"))["rms"], rel=1e-9)
