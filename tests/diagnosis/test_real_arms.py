"""Three arms that exist: what a fit and the search make of them, held against a plain base-parameter fit."""

from __future__ import annotations

import re
import shlex
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from exoid.measurement.reading.read import read_recording
from exoid.optimisation.fitting.assemble import assemble
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import Prepared, prepare
from exoid.symbolic.model import read_model
from exoid.workbench.command import main

ARMS = {"ur10": "exciting.csv", "tx40": "run.csv", "kr300": ""}
HUBER = 1.03
"""Times the unseen error of plain squares that Huber's loss leaves with the same columns, at most: the geometric mean
over joints and recordings held out, 1.02 on UR10 and KR300, 1.00 on TX40. In single ones it is 0.82 to 1.17: what is
left is the model's, comes in stretches, and either loss follows some of them. With δ twice as large it is 0.98 to 1.02.
"""
ONCE = 1.09
"""The same of any joint, where the last of several recordings is held out, or the second quarter of a single one."""
SAME = 1.001
"""The same of the fit by least squares that goes before it."""
WEIGHTED = 1.0
"""The same mean where joints are weighted by what is left of each: 0.99 on UR10, 0.76 on TX40, 0.84 on KR300."""


def arm(shared_data: Path, folder: Path, name: str, ends: tuple[int, ...] = (0, 1, 2, 3, 4)):
    """Model and recordings: where there is a single one, what lies between the `ends` (in quarters of it)."""
    where = shared_data / f"arm_{name}"
    model = read_model(where / f"{name}.urdf")
    if not ARMS[name]:
        return model, [read_recording(where / f"run_{k}.csv", joints=model.joints) for k in "ABC"]
    head, *rows = (where / ARMS[name]).read_text().splitlines()
    runs, fourth = [], len(rows) // 4
    for first, last in pairwise(ends):
        path = folder / f"quarter_{first}.csv"
        path.write_text("\n".join([head, *rows[first * fourth : last * fourth if last < 4 else None]]))
        runs.append(read_recording(path, joints=model.joints))
    return model, runs


def plain_squares(model, prepared: Prepared):
    """Unseen RMS (J,) of base parameters with dry and viscous friction, by least squares on the same samples."""
    fitted, unseen = assemble(model, prepared.train), assemble(model, prepared.verify)
    numbers = np.linalg.lstsq(fitted.matrix, fitted.vector, rcond=1e-10)[0]
    return unseen.rms(numbers)


def beside_plain_squares(model, runs, held):
    """Unseen errors (J,) by least squares, by Huber's loss and by that with weighted joints, in those of plain squares,
    of one recording held out.
    """
    prepared = prepare(model, [run for run in runs if run is not held], [held])
    fit, weighted = (identify(model, prepared.train, optimisers=(), weighted=asked) for asked in (False, True))
    unseen, plain = assemble(model, prepared.verify), plain_squares(model, prepared)
    return tuple(unseen.rms(numbers) / plain for numbers in (fit.sse.linear, fit.linear, weighted.linear))


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_the_same_model_predicts_as_well_as_plain_squares(shared_data, tmp_path, name):
    model, runs = arm(shared_data, tmp_path, name, (0, 1, 2, 4))
    squares, huber, _ = beside_plain_squares(model, runs, runs[1 if ARMS[name] else 2])
    assert np.all(squares <= SAME) and np.all(huber <= ONCE)


@pytest.mark.slow
@pytest.mark.parametrize("name", ARMS)
def test_over_all_recordings_held_out_it_predicts_nearly_as_well(shared_data, tmp_path, name):
    model, runs = arm(shared_data, tmp_path, name)
    squares, *means = np.swapaxes([beside_plain_squares(model, runs, held) for held in runs], 0, 1)
    huber, weighted = np.exp(np.mean(np.log(means), axis=(1, 2)))
    assert np.all(squares <= SAME) and huber <= HUBER and weighted <= WEIGHTED


@pytest.mark.slow
def test_the_arm_of_the_documentation_is_told_what_is_written_there(shared_data, monkeypatch, capsys):
    page = (Path(__file__).resolve().parents[2] / "docs" / "machines.md").read_text("utf-8")
    shown = page.partition("### A real arm")[2].partition("## ")[0]
    command = re.search(r"^\$ exoid (.*)$", shown, re.M)[1]
    monkeypatch.chdir(shared_data / "arm_tx40")
    assert main(shlex.split(command)) == 0
    said = " ".join(capsys.readouterr().out.split())
    found = re.findall(r"\| ([\d.]+ ± [\d.]+) ", shown)
    assert len(found) == 4 and [one for one in found if one not in said] == []
    assert "joint_6 keeps 4.6 times the noise" in said and "Rotor inertia at joint_3 from Time delay" in said
    assert "Inertia across both joints at joint_5 from Time delay" in said
