"""`exoid demo`: the whole loop on shipped recordings with a hidden effect, with a report."""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from exoid.ground.output import check_folder, default_folder
from exoid.workbench.command_line.options import add_common
from exoid.workbench.terminal.screen import Screen

if TYPE_CHECKING:
    from exoid.diagnosis.results import Diagnosis
    from exoid.measurement.bench.control import Tracking
    from exoid.measurement.bench.seal import Truth
    from exoid.optimisation.fitting.fit import Fit
    from exoid.symbolic.model import Model

GROUP = "answer"
HELP = """the whole loop on shipped recordings with a hidden effect, and a report to read"""

DATA = Path(__file__).parent.parent / "demo_data"
DEFAULT_FOLDER = "exoid-demo"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_common(parser, out=f"write the report into DIR (default: {DEFAULT_FOLDER})")


def run(args: argparse.Namespace) -> int:
    """Compare, diagnose, add until it is enough, open the seal, write the report."""
    began = time.perf_counter()
    args.out = args.out or default_folder(DEFAULT_FOLDER)
    check_folder(args.out)
    screen = Screen.of(args)
    screen.say("Four recordings of a leg with something hidden in it; the standard model knows nothing of it.")

    from exoid.diagnosis.discovery import discover
    from exoid.diagnosis.report.material import Material, pictures_of
    from exoid.measurement.bench.seal import open_seal
    from exoid.workbench.command_line.asking import answer, material_of
    from exoid.workbench.command_line.deliver import deliver_results
    from exoid.workbench.command_line.inputs import Inputs, load_model, read
    from exoid.workbench.command_line.said import say_findings
    from exoid.workbench.terminal.showing import show_comparison, show_diagnosis, show_steps, truth_sentence

    recordings = [one for path in sorted(DATA.glob("train*.csv")) for one in read(str(path))]
    verify = [one for path in sorted(DATA.glob("verify*.csv")) for one in read(str(path))]
    say_findings([*recordings, *verify], args)
    given = Inputs(load_model(None), tuple(recordings), tuple(verify))
    found, comparison = answer(args, discover, given)
    show_comparison(screen, comparison)
    show_diagnosis(screen, found)
    show_steps(screen, found)
    hidden = open_seal(DATA / "truth.seal").truth
    truth = f"The truth, from the seal: {truth_sentence(hidden)}"
    screen.say(truth)
    control = _control(given.model, comparison.fit, found, hidden, args.seed)
    screen.say(control.sentence)
    payload = {**found.to_json(), "control": control.to_json(), "seconds": time.perf_counter() - began}

    def material() -> Material:
        made = material_of("exoid demo", given, found, comparison, truth)
        return replace(made, pictures=(*made.pictures, *pictures_of(control)))

    deliver_results(args, screen, payload, material)
    screen.say("next: your own recordings with exoid diagnose run1.csv run2.csv --verify run3.csv")
    return 0


def _control(model: Model, before: Fit, found: Diagnosis, truth: Truth, seed: int) -> Tracking:
    """Let the leg of the demo follow a motion, fed forward by the model before and after."""
    from exoid.measurement.bench.control import track
    from exoid.measurement.bench.hidden import Hidden

    models = {"the base model": (model, before.linear, before.shape)}
    if found.accepted:
        models["what was found"] = (found.model, found.fit.linear, found.fit.shape)
    return track(models, effects=[Hidden(one.id, one.joint, one.values) for one in truth.effects], seed=seed)
