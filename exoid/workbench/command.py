"""The command `exoid`: finds the verb, runs it, and turns whatever goes wrong into a message and a status.

Exit status: 0 done, 1 ran but the answer is negative, 2 bad input, 130 interrupted, 70 an internal
error. A verb is a module in `commands/`, of the workbench or of an app, with `GROUP`, `HELP`, `add_arguments(parser)`
and `run(args) -> int`; nothing is registered.
"""

from __future__ import annotations

import gc
import importlib
import os
import sys
import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from types import MappingProxyType, ModuleType

from exoid.ground.delivery import together
from exoid.ground.errors import ExoidError
from exoid.ground.folder import with_apps
from exoid.ground.signals import handled
from exoid.ground.suggest import did_you_mean
from exoid.ground.text import printable
from exoid.workbench import commands
from exoid.workbench.command_line.parser import Parser, UsageError
from exoid.workbench.terminal.encoding import install

DONE, NEGATIVE, BAD_INPUT, INTERNAL_ERROR, INTERRUPTED, TERMINATED = 0, 1, 2, 70, 130, 143


class Terminated(BaseException):
    """SIGTERM, or a terminal that was closed: what is under way is cleared away, as after Ctrl-C."""


WELCOME = """\
exoid names the physical effect that your model is missing, from angles and
torques of a leg exoskeleton, a test bench or a robot arm.

New here? The whole loop on shipped recordings, in less than half a minute:

    exoid demo

Then with your own recordings: tables with t, q1, q2, tau1, tau2 in s, rad, N·m
(other names and units work). Hold one of them out with --verify.

  how large is the error of the model, and where is it?
    exoid compare run1.csv run2.csv --verify run3.csv

  which effect is missing, and what looks like it?
    exoid diagnose run1.csv run2.csv --verify run3.csv

  the same to the end, with a report to read
    exoid discover run1.csv run2.csv --verify run3.csv --out report

the same in a browser, by dropping files and pointing
    exoid open

No recordings yet?
    exoid simulate --blind --out runs      makes some and seals the truth

exoid --help lists every command, exoid COMMAND --help its everyday options.
"""


GROUPS: Mapping[str, str] = MappingProxyType(
    {
        "answer": "what is the model missing?",
        "measure": "what to record, and what the recordings are",
        "build": "models, numbers, code",
        "run": "many at once",
        "look up": "what there is",
    }
)
"""What the commands are for, each in one group; a command names its own (`GROUP`)."""


SELDOM = 200_000
"""Objects made between two looks for those that refer to each other: of arrays there are none, and looking every 700
takes a fortieth of the time of `discover` on four recordings (0.07 of 2.8 s), a last look at the end a hundredth.
"""


def find_verbs() -> tuple[str, ...]:
    """Return the names of all commands: the modules of `commands/`, here and in apps, sorted."""
    return tuple(with_apps(commands))


def load_verb(verb: str) -> ModuleType:
    """Import the module of one command; raises UsageError with a suggestion when there is none."""
    verbs = with_apps(commands)
    if verb not in verbs:
        what = f"there is no command {verb!r}"
        raise UsageError(what, remedy=did_you_mean(verb, verbs) or f"known: {', '.join(verbs)}")
    return importlib.import_module(verbs[verb])


def verb_parser(verb: str) -> Parser:
    """Return the argument parser of one command."""
    module = load_verb(verb)
    parser = Parser(prog=f"exoid {verb}", description=module.HELP)
    module.add_arguments(parser)
    return parser


def overview() -> str:
    """Return the text of `exoid --help`: one line per command."""
    lines = ["usage: exoid COMMAND [options]"]
    known = {verb: load_verb(verb) for verb in find_verbs()}
    for group, about in GROUPS.items():
        lines += ["", f"{group}: {about}"]
        mine = (verb for verb, module in known.items() if group == module.GROUP)
        lines += [f"  {verb:<10}  {known[verb].HELP.strip().splitlines()[0]}" for verb in mine]
    lines += [
        "",
        "every command: --json FILE|-, --out DIR, --seed N, --quiet",
        "exoid COMMAND --help says more, --help-all everything",
        "exit status: 0 done, 1 ran but the answer is negative, 2 bad input",
        "new here? exoid demo",
    ]
    return "\n".join(lines) + "\n"


def main(argv: Sequence[str] | None = None) -> int:
    """Run `exoid` with `argv` (default: the arguments of the process) and return the exit status."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    # Before NumPy is loaded: its matrices are narrow here, and more threads would burn time and gain none.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.set_threshold(SELDOM)
    install()
    try:
        with warnings.catch_warnings():
            warnings.showwarning = _note
            with handled(_terminate, "SIGTERM", "SIGHUP"):
                status = _dispatch(arguments)
        sys.stdout.flush()
        if argv is None:  # the process ends: what it made need not be looked through
            gc.freeze()
        return status
    except ExoidError as error:
        return _complain(str(error))
    except KeyboardInterrupt:
        return _complain("interrupted; nothing was left half-written", INTERRUPTED)
    except Terminated as stop:
        return _complain("terminated; nothing was left half-written", 128 + stop.args[0])
    except BrokenPipeError:
        # The reader (head, less) has had enough. Python would complain again when it flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except MemoryError:
        return _complain("not enough memory\n  what to do: fewer or shorter recordings at a time")
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        return _complain(f"{place}{error.strerror or error}")
    except Exception:  # noqa: BLE001 - a crash must not leave with status 1, which means "the answer is negative"
        import traceback

        traceback.print_exc()
        return _complain("internal error in exoid; please report the traceback above", INTERNAL_ERROR)


def _dispatch(arguments: Sequence[str]) -> int:
    """Answer the calls without a verb, or parse the verb's arguments and run it."""
    if not arguments:
        sys.stdout.write(WELCOME)
        return DONE
    verb, rest = arguments[0], arguments[1:]
    if verb in ("-h", "--help", "help"):
        if verb == "help" and rest:
            verb_parser(rest[0]).parse(["--help"])
        else:
            sys.stdout.write(overview())
        return DONE
    if verb == "--version":
        from exoid.ground.version import __version__

        sys.stdout.write(f"exoid {__version__}\n")
        return DONE
    if verb.startswith("-"):
        raise UsageError(f"unknown option {verb!r}", remedy="the command comes first: exoid COMMAND [options]")
    parser = verb_parser(verb)
    try:
        args = parser.parse(rest)
    except SystemExit as stop:  # argparse leaves this way after --help
        return int(stop.code or 0)
    args.command_line = ["exoid", *arguments]
    from exoid.workbench.command_line.deliver import check_places
    from exoid.workbench.command_line.guard import protect_inputs

    with together() as delivery:
        protect_inputs(args, delivery)
        check_places(args)
        status: int = load_verb(verb).run(args)
    return status


def _terminate(number: int, _: object) -> None:
    raise Terminated(number)


def _complain(text: str, status: int = BAD_INPUT) -> int:
    """Write `text` to stderr after the name of the program and return `status`."""
    _tell(text)
    return status


def _note(message: Warning | str, category: type[Warning], *_: object, **__: object) -> None:
    """Show a Python warning as one line for a person; what NumPy says of single numbers tells nobody anything."""
    if issubclass(category, RuntimeWarning):
        return
    _tell(f"note: {message}")


def _tell(text: str) -> None:
    """Write a line to stderr; a full disk or a reader who has gone changes nothing about the answer."""
    with suppress(OSError):
        sys.stderr.write(f"exoid: {printable(text)}\n")
        sys.stderr.flush()


if __name__ == "__main__":
    sys.exit(main())
