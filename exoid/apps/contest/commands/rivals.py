"""`exoid rivals`: NFO, PSO, GA, DE and CMA-ES against the proven optimum or the best motion known, with statistics."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from exoid.ground.output import make_folder
from exoid.workbench.command_line.deliver import deliver_results
from exoid.workbench.command_line.options import add_common, add_model, add_recordings, add_settings, settings_given
from exoid.workbench.command_line.parser import UsageError
from exoid.workbench.terminal.progress import progress
from exoid.workbench.terminal.screen import Screen

if TYPE_CHECKING:
    from exoid.optimisation.contest.standings import Rivals
    from exoid.workbench.command_line.inputs import Inputs

GROUP = "run"
HELP = """compare NFO, PSO, GA, DE and CMA-ES with the certified optimum, or the best motion known

exoid rivals --out contest                       the paper's leg on the virtual bench, 51 seeds
exoid rivals run1.csv run2.csv --model leg.toml --out contest
exoid rivals --problem excitation --criterion worst --seeds 11     motions, rescaled and with a penalty
with --out, what was stopped goes on where it was: give the same command again"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    from exoid.optimisation.contest.settings import ContestSettings

    add_recordings(parser, verify=False, required=False, rows=False, everyday=False)
    add_model(parser)
    group = parser.add_argument_group("the comparison")
    add_settings(group, ContestSettings, "problem", "criterion", "seeds", "individuals", "generations", "whitened")
    group.add_argument("--only", metavar="NAME", nargs="+", action="extend", default=[], help="only these optimisers")
    add_settings(group, ContestSettings, "jobs")
    add_common(parser, out="write report, figures, IOHprofiler logs and every single run into DIR")


def run(args: argparse.Namespace) -> int:
    """Compare and show."""
    given = _given(args)
    with progress("optimising", quiet=args.quiet) as report:
        from exoid.optimisation.contest.rivals import entrants, rivals
        from exoid.optimisation.contest.settings import ContestSettings

        competing = _chosen(entrants(args.whitened or bool(args.only), args.problem), args)
        found = rivals(
            _subject(given, args), **settings_given(args, ContestSettings), competing=competing, progress=report,
            folder=make_folder(Path(args.out) / "runs") if args.out else None,
        )  # fmt: skip
    screen = Screen.of(args)
    _show(screen, found)
    if args.out:
        found.write_logs(Path(args.out) / "ioh")
        screen.say(f"IOHprofiler logs: {Path(args.out) / 'ioh'}")
    from exoid.diagnosis.report.material import Material, pictures_of

    payload = {"schema": "exoid.rivals/1", **found.to_json()}
    deliver_results(args, screen, payload, lambda: Material(
        title=f"Optimisers against the {found.contest.goal}", answer=_sentence(found),
        recordings=() if given is None else given.recordings, pictures=pictures_of(found), seconds=found.seconds,
    ))  # fmt: skip
    return 0


def _given(args: argparse.Namespace) -> Inputs | None:
    """Return the recordings with their model; None for the paper's leg."""
    if args.recordings and args.problem == "excitation":
        raise UsageError("motions compete on a model alone", remedy="leave out the recordings, or --problem")
    if args.recordings:
        from exoid.workbench.command_line.inputs import load

        return load(args)
    for option in ("model", "map", "units", "leg", "cutoff"):
        if getattr(args, option) and not (option == "model" and args.problem == "excitation"):
            remedy = "name recordings, or leave it out: the paper's leg on the virtual bench is then the problem"
            raise UsageError(f"--{option} is about recordings, and there are none", remedy=remedy)
    return None


def _subject(given: Inputs | None, args: argparse.Namespace) -> Any:
    """Return the fit whose problem is competed on, or the model whose motions; None for the paper's leg."""
    if given is None:
        from exoid.workbench.command_line.inputs import load_model

        return load_model(args.model) if args.problem == "excitation" else None
    from exoid.optimisation.fitting.identify import identify
    from exoid.optimisation.preparation.prepare import prepare

    prepared = prepare(given.model, given.recordings, cutoff=given.cutoff)
    return identify(given.model, prepared.train, optimisers=(), seed=args.seed)


def _chosen(known: Any, args: argparse.Namespace) -> Any:
    """Return those of --only; all without it."""
    if not args.only:
        return known
    from exoid.ground.suggest import did_you_mean

    for name in args.only:
        if name not in known:
            remedy = did_you_mean(name, list(known)) or f"there are {', '.join(known)}"
            raise UsageError(f"there is no optimiser called {name!r}", where="--only", remedy=remedy)
    return {name: search for name, search in known.items() if name in args.only}


def _show(screen: Screen, found: Rivals) -> None:
    """Show who came how near, how fast."""
    from exoid.workbench.terminal.showing import number

    screen.say(f"{found.contest.name}: {found.contest.standard}")
    if found.resumed:
        screen.say(f"{found.resumed} runs were there already", "faint")
    target = found.contest.targets[-1]
    rows = [
        (
            name, _gap(middle), f"{hits}/{runs}",
            "-" if ert == float("inf") else f"{ert:.0f} [{e_low:.0f}, {e_high:.0f}]", number(p, 1),
        )
        for name, middle, _, _, hits, runs, ert, e_low, e_high, _, p in found.rows()
    ]  # fmt: skip
    screen.table(
        f"{len(found.seeds)} seeds, {found.contest.individuals} × {found.contest.generations} evaluations",
        ("optimiser", "gap", f"to {target:g}", "evaluations", "p"), rows,
    )  # fmt: skip
    screen.say(f"gap: median distance above the {found.contest.goal}, relative", "faint")
    screen.say(f"evaluations: expected to come within {target:g}, 95 % bootstrap", "faint")
    screen.say(f"p: is the gap that of {found.reference}? Wilcoxon, Holm", "faint")


def _gap(value: float) -> str:
    """Return a gap; differences within rounding are not shown."""
    from exoid.optimisation.contest.standings import ROUNDING

    return f"<{ROUNDING:.0e}" if value < ROUNDING else f"{value:.0e}"


def _sentence(found: Rivals) -> str:
    best = found.rows()[0]
    goal, target = found.contest.goal, found.contest.targets[-1]
    near = f"{best[4]} of {best[5]} runs come within {target:g} of the {goal}"
    if best[6] == float("inf"):
        return f"No run came within {target:g} of the {goal}; nearest is {best[0]}, {best[1]:.1e} above it."
    return f"Fastest is {best[0]}: {near}, after {best[6]:.0f} evaluations on average."
