"""`exoid watch`: follow a machine while it runs, and say when something changed."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from exoid.ground.errors import ExoidError
from exoid.ground.signals import handled
from exoid.workbench.command_line.options import add_columns, add_common, between, positive_number, whole_number
from exoid.workbench.command_line.parser import Seldom
from exoid.workbench.terminal.screen import warn

if TYPE_CHECKING:
    from exoid.apps.watch.io.keeping import Kept
    from exoid.apps.watch.io.prometheus import Scraped
    from exoid.apps.watch.io.report import Report
    from exoid.apps.watch.watcher import Watcher

GROUP = "measure"
HELP = """follow a machine while it runs: numbers with intervals, and what changed, named

exoid watch leg.toml run.csv                a recording, or a file that is still being written
exoid watch leg.toml --follow log.csv       until Ctrl-C; log rotation is noticed
my_logger | exoid watch leg.toml -          CSV or one JSON object per line on standard input
exoid watch standard log.csv --json -       one JSON object per event
exoid watch leg.toml ros2:/joint_states --state leg.state --on-event ./tell"""

STANDARD = "standard"



def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("model", metavar="MODEL", help=f"model file (TOML), or {STANDARD} for the standard leg")
    parser.add_argument("source", metavar="SOURCE", help="a recording, a file that grows, - (a pipe) or ros2:TOPIC")
    parser.add_argument("--follow", action="store_true", help="wait for further lines of the file until Ctrl-C")
    group = parser.add_argument_group("reading the samples")
    add_columns(group)
    group.add_argument("--cutoff", metavar="HZ", type=positive_number, default=None, help="cut-off of the filters (4)")
    group = parser.add_argument_group("watching")
    group.add_argument(
        "--learn", metavar="S", type=positive_number, default=120.0, help="first seconds, which say what is usual (120)"
    )
    group.add_argument(
        "--false-alarms", metavar="N", type=positive_number, default=1.0,
        help="false alarms accepted in 24 h of operation (1)",
    )  # fmt: skip
    group.add_argument(
        "--estimates", metavar="BLOCKS", type=whole_number, default=0,
        help="report the model's parameters every so many blocks of 5 s (0: only at the end)",
    )  # fmt: skip
    group.add_argument(
        "--state", metavar="FILE", help="keep what is learnt in FILE, and go on with what is there: no new learning"
    )
    fleet = Seldom(parser.add_argument_group("in a fleet"))
    fleet.add_argument("--device", metavar="NAME", help="name of the device in every event (that of this machine)")
    fleet.add_argument(
        "--heartbeat", metavar="S", type=between(0.0, 86400.0), default=60.0,
        help="say every S s that the watch is alive, while samples come live (60; 0: never)",
    )  # fmt: skip
    fleet.add_argument("--on-event", metavar="COMMAND", help="run COMMAND for each event, JSON on its input")
    fleet.add_argument("--mqtt", metavar="URL", help="publish events to a broker: mqtt://user@host:1883/prefix")
    fleet.add_argument(
        "--prometheus", metavar="PORT", type=between(0, 65535, number=whole_number), default=None,
        help="serve numbers and counts on this port of 127.0.0.1",
    )  # fmt: skip
    add_common(parser)


def run(args: argparse.Namespace) -> int:
    """Watch until the source ends; 1 when something changed."""
    from exoid.apps.watch.front import CUTOFF
    from exoid.apps.watch.settings import Settings
    from exoid.apps.watch.watcher import Watcher
    from exoid.workbench.command_line.inputs import load_model
    from exoid.workbench.command_line.parser import UsageError

    given = None if args.model == STANDARD and not Path(STANDARD).exists() else args.model
    model = load_model(given)
    block = Settings().block
    if args.learn < 4 * block:
        raise UsageError(f"--learn {args.learn:g} is too short", remedy=f"give at least {4 * block:g} s")
    settings = Settings(
        cutoff=args.cutoff or CUTOFF, learn=round(args.learn / block), alarms_per_day=args.false_alarms,
        estimates=args.estimates, seed=args.seed, most_learn=3 * round(args.learn / block),
    )  # fmt: skip
    kept = _kept(args)
    watcher = Watcher(model, settings, model.custom, restored=None if kept is None else kept.read())
    report, scraped = _told(args, watcher)
    if given is not None:
        from exoid.symbolic.model_file import read_numbers

        if read_numbers(given) is not None:
            report.note(f"the numbers in {given} are not used: the first {args.learn:g} s say what is usual")
    try:
        try:
            _follow(args, watcher, report, scraped, kept)
        except ExoidError:
            if watcher.blocks:  # what was seen is summed up, whatever ends it
                report.all(watcher.finish())
            raise
        report.all(watcher.finish())
    finally:
        if kept is not None:
            kept.keep(watcher, last=True)
            kept.release()
        report.close()
    if args.out:
        report.write()
    if not watcher.looked:
        warn("nothing was looked for: what is usual takes two minutes of motion (--learn S for less)")
        return 2
    return 1 if report.alarms else 0


def _kept(args: argparse.Namespace) -> Kept | None:
    """Return the file that keeps what is learnt; None where nothing does."""
    from exoid.apps.watch.io.keeping import Kept
    from exoid.ground.output import check_target

    if args.state is None:
        return None
    check_target(args.state, lambda content: content[:2] == b"PK")
    return Kept(args.state)


def _told(args: argparse.Namespace, watcher: Watcher) -> tuple[Report, Scraped | None]:
    """Return the report that tells events, with every destination that was asked for, and the page that is scraped."""
    from exoid.apps.watch.io.report import Report, device_of

    report, scraped = Report(args, watcher, device_of(args.device)), None
    if args.on_event is not None:
        from exoid.apps.watch.io.hook import Hook

        report.others.append(Hook(args.on_event))
    if args.mqtt is not None:
        from exoid.apps.watch.io.mqtt import Broker

        report.others.append(Broker(args.mqtt, report.device))
    if args.prometheus is not None:
        from exoid.apps.watch.io.prometheus import Scraped

        scraped = Scraped(args.prometheus, report.device)
        report.others.append(scraped)
        report.note(f"Prometheus: http://{scraped.host}:{scraped.port}/metrics")
    return report, scraped


def _follow(
    args: argparse.Namespace, watcher: Watcher, report: Report, scraped: Scraped | None, kept: Kept | None
) -> None:
    """Take samples until there are no more, or a signal ends it."""
    from exoid.apps.watch.io.sources import is_live, live_samples

    live, stopped = is_live(args), list[int]()

    def stop(number: int, _: object) -> None:
        if stopped:  # the second one ends it at once
            raise KeyboardInterrupt
        stopped.append(number)

    with handled(stop, "SIGINT", "SIGTERM", "SIGHUP"):
        for samples, notes in live_samples(args, watcher):
            for note in notes:
                before = samples[: note.before, 0]
                report.line(note, float(before[-1]) if before.size else watcher.last)
            report.all(watcher.push(samples))
            if live:
                report.beat(len(samples))
            if scraped is not None:
                scraped.look(watcher, len(samples))
            if kept is not None:
                kept.keep(watcher)
            if stopped:
                report.note("interrupted")
                break
