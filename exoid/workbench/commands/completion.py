"""`exoid completion SHELL`: the script that lets a shell complete commands, options and effects; `shtab` writes it."""

from __future__ import annotations

import argparse
import re
import shlex
import sys
from typing import Any

from exoid.ground.extras import needing
from exoid.workbench.command_line.options import add_common

GROUP = "look up"
HELP = """print the completion script for bash, zsh or fish

bash, in ~/.bashrc:                 source <(exoid completion bash)
zsh, in ~/.zshrc after compinit:    source <(exoid completion zsh)
fish:                               exoid completion fish > ~/.config/fish/completions/exoid.fish"""

EFFECTS = "_exoid_effects"
"""Function of bash and zsh that offers the catalogue; a joint may follow what it offers."""

PREAMBLE = {
    "bash": EFFECTS + """() {{ compgen -W '{effects}' -- "$1"; }}""",
    "zsh": EFFECTS + "() {{ compadd -S '' -- {effects}; }}",
}
SHELLS = (*PREAMBLE, "fish")

JOINTS_IN_BASH = """
_exoid() {{  # bash splits stribeck:knee at the colon
  local current="${{COMP_WORDS[COMP_CWORD]}}"
  if [[ $current == : || ${{COMP_WORDS[COMP_CWORD-1]}} == : ]]; then
    COMPREPLY=($(compgen -W "{joints}" -- "${{current#:}}"))
  else
    _shtab_exoid
  fi
}}
complete -o bashdefault -o default -F _exoid exoid
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("shell", choices=sorted(SHELLS), help="the shell it is for")
    add_common(parser, out="write the script into DIR as well")


def run(args: argparse.Namespace) -> int:
    """Write the script to standard output (and to --out)."""
    from exoid.ground.output import make_folder, write_text
    from exoid.workbench.command_line.files import write_json

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
    with needing("completion", "scripts of completion", "shtab"):
        import shtab
    from exoid.symbolic.effect_catalogue import catalogue
    from exoid.symbolic.quantity import JOINTS
    from exoid.workbench.command import find_verbs, load_verb
    from exoid.workbench.command_line.parser import Parser

    words = {"effects": " ".join(sorted(catalogue())), "joints": " ".join(JOINTS)}
    effect = {"bash": EFFECTS, "zsh": EFFECTS, "fish": words["effects"]}
    takes: dict[str, Any] = dict.fromkeys(("FILE", "REC", "MODEL", "SEAL"), shtab.FILE)
    takes |= {"DIR": shtab.DIRECTORY, "ID": effect, "EFFECT": effect}
    whole = Parser(prog="exoid")
    verbs = whole.add_subparsers()
    for name in find_verbs():
        line = load_verb(name).HELP.splitlines()[0]
        parser = verbs.add_parser(name, help=line, description=line)
        load_verb(name).add_arguments(parser)
        for action in parser._actions:
            first = re.split(r"\W", str(action.metavar or ""))[0]  # of EFFECT[:joint], MODEL|REC
            if first in takes:
                action.complete = takes[first]  # type: ignore[attr-defined]
    text = shtab.complete(whole, shell, preamble=PREAMBLE.get(shell, "").format(**words)) + "\n"
    if shell == "zsh":  # which shtab's script registers itself with in `eval` only, not in `source <(...)`
        return f"eval {shlex.quote(text)}\n"
    return text + (JOINTS_IN_BASH.format(**words) if shell == "bash" else "")
