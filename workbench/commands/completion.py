"""`exoid completion SHELL`: the script that lets a shell complete commands, options and effects."""

from __future__ import annotations

import argparse
import sys

from workbench.command_line.completion import SHELLS, Verb, option_places
from workbench.command_line.options import add_common

HELP = """print the completion script for bash, zsh or fish

bash, in ~/.bashrc:                 source <(exoid completion bash)
zsh, in ~/.zshrc after compinit:    source <(exoid completion zsh)
fish:                               exoid completion fish > ~/.config/fish/completions/exoid.fish"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("shell", choices=sorted(SHELLS), help="the shell it is for")
    add_common(parser, out="write the script into DIR as well")


def run(args: argparse.Namespace) -> int:
    """Write the script to standard output (and to --out)."""
    from workbench.command_line.deliver import check_places
    from workbench.command_line.files import make_folder, write_json, write_text

    check_places(args)
    text = script(args.shell)
    if args.json:
        write_json(args.json, {"schema": "exoid.completion/1", "shell": args.shell, "script": text})
    if args.out:
        write_text(make_folder(args.out) / f"exoid.{args.shell}", text)
    if not args.quiet and args.json != "-":
        sys.stdout.write(text)
    return 0


def script(shell: str) -> str:
    """Return the completion script of `shell` for every command there is."""
    from symbolic.catalogue import catalogue
    from workbench.command import find_verbs, load_verb, verb_parser

    verbs = [
        Verb(name, load_verb(name).HELP.splitlines()[0], option_places(verb_parser(name))) for name in find_verbs()
    ]
    return SHELLS[shell](verbs, sorted(catalogue()))
