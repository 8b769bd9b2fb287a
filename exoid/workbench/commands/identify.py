"""`exoid identify`: the numbers of the model, with intervals and a proof that they are the best."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import TYPE_CHECKING

from exoid.workbench.command_line.deliver import deliver_results
from exoid.workbench.command_line.options import (
    add_common,
    add_limit,
    add_question,
    add_settings,
    settings_given,
)
from exoid.workbench.command_line.parser import Seldom
from exoid.workbench.terminal.progress import progress
from exoid.workbench.terminal.screen import Screen

if TYPE_CHECKING:
    from exoid.optimisation.fitting.fit import Fit
    from exoid.optimisation.fitting.neighbours import Neighbours
    from exoid.optimisation.fitting.thigh_length import ThighLength
    from exoid.symbolic.motion import Float
    from exoid.workbench.command_line.inputs import Inputs

GROUP = "build"
HELP = """find the parameters: SSE, then Huber, by NFO and IPOPT, with certificate and intervals

exoid identify run1.csv run2.csv --verify run3.csv --model leg.toml --write leg_identified.toml"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    from exoid.optimisation.fitting.settings import FitSettings

    add_question(parser)
    seldom = Seldom(parser)
    add_settings(seldom, FitSettings, "physical", "weighted", shape_search={"metavar": "HOW", "type": str})
    seldom.add_argument(
        "--per-recording", action="store_true",
        help="every parameter from every recording alone: which numbers can be trusted, and what to record",
    )  # fmt: skip
    parser.add_argument("--write", metavar="FILE", help="write the model with its identified parameters to FILE")
    add_limit(parser, "the error (of the unseen recordings, if there are any)")
    add_common(parser)


def run(args: argparse.Namespace) -> int:
    """Identify, show; 1 when the error is above --limit."""
    from exoid.workbench.command_line.inputs import check_new_model, load

    if args.write:
        check_new_model(args.write, args.model)
    given = load(args)
    fit, unseen, near, length = _identified(args, given)
    from exoid.diagnosis.report.material import Material, picture_of_fit
    from exoid.optimisation.fitting.by_recording import by_recording
    from exoid.symbolic.wording import per_joint
    from exoid.workbench.terminal.showing import show_by_recording, show_fit, show_limit

    screen, joints, unit = Screen.of(args), given.model.joint_names, given.model.torque_unit
    show_fit(screen, fit)
    if unseen is not None:
        by_huber, by_squares = (per_joint(rms, joints, unit) for rms in unseen)
        screen.say(f"error (RMS) on unseen motion: {by_huber} by Huber, {by_squares} by SSE")
    if near.cutoffs and near.agree:
        tried = " and ".join(f"{cutoff:g}" for cutoff in near.cutoffs)
        screen.say(f"cut-off {near.cutoff:g} Hz; at {tried} Hz every parameter stays within its interval")
    alone = by_recording(fit)
    if args.per_recording:
        show_by_recording(screen, alone)
    if args.write:
        from exoid.symbolic.model_file import write_model

        write_model(given.model, args.write, fit)
        screen.say(f"model: {args.write}")
    over = show_limit(screen, args.limit, fit.rms if unseen is None else unseen[0], unit)
    checked = {} if unseen is None else dict(zip(("verify_rms", "sse_verify_rms"), unseen, strict=True))
    beyond = "" if unseen is None else f"; on motion the fit has not seen, {per_joint(unseen[0], joints, unit)}"
    payload = {"schema": "exoid.fit/1", **fit.to_json(), **checked, "neighbouring_cutoffs": near.to_json()}
    payload["by_recording"] = alone.to_json()
    payload["thigh_length"] = None if length is None else length.to_json()
    deliver_results(args, screen, payload, lambda: Material(
        title="Identified parameters",
        answer=f"The error left on the fitted motion is {per_joint(fit.rms, joints, unit)} (RMS){beyond}.",
        recordings=given.recordings, verify=given.verify, model=given.model, fit=fit,
        by_recording=alone,
        pictures=(picture_of_fit(fit),), seconds=fit.seconds,
    ))  # fmt: skip
    return 1 if over else 0


def _identified(
    args: argparse.Namespace, given: Inputs
) -> tuple[Fit, tuple[Float, Float] | None, Neighbours, ThighLength | None]:
    """Return the fit with all that is to be said of it, its errors on unseen motion, what neighbouring cut-offs give,
    and the thigh length that the torques ask for.
    """
    with progress("identifying", quiet=args.quiet) as report:
        from exoid.optimisation.fitting.identify import identify
        from exoid.optimisation.fitting.settings import FitSettings
        from exoid.optimisation.preparation.prepare import prepare

        prepared = prepare(given.model, given.recordings, given.verify, **given.filter)
        steps = iter(range(1, 100))
        fit = identify(
            given.model, prepared.train, **settings_given(args, FitSettings),
            progress=lambda text: report(min(0.95, next(steps) / 9), text),
        )  # fmt: skip
        from exoid.diagnosis.cautions import cautions
        from exoid.diagnosis.comparison import verification
        from exoid.diagnosis.evidence.fitted import fitted_model
        from exoid.optimisation.fitting.neighbours import neighbours
        from exoid.optimisation.fitting.thigh_length import wanted_thigh_length
        from exoid.workbench.terminal.showing import of_the_set

        unseen = verification(fit, prepared)
        report(0.97, "neighbouring cut-offs")
        near = neighbours(fit, given.model, prepared, given.recordings)
        length = wanted_thigh_length(fit, prepared)
        found = (*cautions(fitted_model(fit, prepared)), *(() if length is None else (length.finding(),)))
        together = (*prepared.misread, *of_the_set((*prepared.findings, *found)))
        fit = replace(fit, plausibility=(*together, *fit.plausibility, *near.findings()))
    return fit, unseen, near, length
