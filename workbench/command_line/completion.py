"""Shell completion scripts for bash, zsh and fish, written from the parsers: completing runs no Python at all."""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from symbolic.quantity import JOINTS

PLACES: Mapping[str, str] = MappingProxyType(
    {"FILE": "file", "REC": "file", "MODEL": "file", "SEAL": "file", "DIR": "folder"}
    | {"ID": "effect", "EFFECT": "effect"}
)
"""First word of a metavar -> what may stand there; anything else is a value that cannot be guessed."""


@dataclass(frozen=True)
class Place:
    """An option (`names`) or a positional (no names): what it `takes` ("", "file", "folder", "effect", "value", or
    "words" of which one of `words` is chosen), and a line of help.
    """

    names: tuple[str, ...]
    takes: str
    words: tuple[str, ...] = ()
    help: str = ""


@dataclass(frozen=True)
class Verb:
    """A command with everything that may follow it."""

    name: str
    help: str
    places: tuple[Place, ...]

    @property
    def options(self) -> tuple[str, ...]:
        """Every option string."""
        return tuple(name for place in self.places for name in place.names)

    @property
    def positional(self) -> str:
        """What its first positional takes, "" without one."""
        return next((p.takes for p in self.places if not p.names), "")

    def words_of(self, takes: str, effects: Sequence[str]) -> tuple[str, ...]:
        """Return the words of its positional, or of the catalogue."""
        if takes == "words":
            return next(p.words for p in self.places if not p.names)
        return tuple(effects) if takes == "effect" else ()


def option_places(parser: argparse.ArgumentParser) -> tuple[Place, ...]:
    """Return the options and positionals of `parser`."""
    found = []
    for action in parser._actions:
        first = re.split(r"\W", str(action.metavar or ""))[0]
        if action.choices is not None:
            takes, words = "words", tuple(str(choice) for choice in action.choices)
        else:
            takes, words = "" if action.nargs == 0 else PLACES.get(first, "value"), ()
        found.append(Place(tuple(action.option_strings), takes, words, _line(action.help)))
    return tuple(found)


def _line(text: str | None) -> str:
    """Return a help text as one line that no shell can misread."""
    return re.sub(r"[^\w ,.;:()/|·-]+", " ", (text or "").replace("%%", "%")).strip()


def bash(verbs: Sequence[Verb], effects: Sequence[str]) -> str:
    """Return the script for bash."""
    cases, takers = [], {"folder": "compopt -o dirnames", "value": "", "effect": 'words="$effects"'}
    for verb in verbs:
        rules = []
        for place in (p for p in verb.places if p.names and p.takes not in ("", "file")):
            act = f'words="{" ".join(place.words)}"' if place.takes == "words" else takers[place.takes]
            rules.append(f"        {'|'.join(place.names)}) {act + '; ' if act else ''}given=1 ;;")
        first = " ".join(verb.words_of(verb.positional, effects))
        inner = "\n".join(['      case "$before" in', *rules, "      esac\n"]) if rules else ""
        cases.append(f'    {verb.name})\n      options="{" ".join(verb.options)}"; first="{first}"\n{inner}      ;;')
    return _BASH.format(
        verbs=" ".join(v.name for v in verbs), effects=" ".join(effects), joints=" ".join(JOINTS),
        cases="\n".join(cases),
    )  # fmt: skip


def zsh(verbs: Sequence[Verb], effects: Sequence[str]) -> str:
    """Return the script for zsh."""
    cases = []
    for verb in verbs:
        rules = []
        for place in (p for p in verb.places if p.names and p.takes not in ("", "file")):
            act = {
                "folder": "_files -/", "value": ":", "effect": "compadd -S '' -a effects",
                "words": f"compadd -- {' '.join(place.words)}",
            }[place.takes]  # fmt: skip
            rules.append(f"        {'|'.join(place.names)}) {act}; return ;;")
        first = " ".join(verb.words_of(verb.positional, effects))
        inner = "\n".join(['      case "$before" in', *rules, "      esac\n"]) if rules else ""
        cases.append(f"    {verb.name})\n      options=({' '.join(verb.options)}); first=({first})\n{inner}      ;;")
    lines = "\n".join(f"      '{v.name}:{_line(v.help).replace(':', ' ')}'" for v in verbs)
    return _ZSH.format(verbs=lines, effects=" ".join(effects), cases="\n".join(cases))


def fish(verbs: Sequence[Verb], effects: Sequence[str]) -> str:
    """Return the script for fish."""
    lines = ["# exoid: fish completion; exoid completion fish > ~/.config/fish/completions/exoid.fish"]
    for verb in verbs:
        lines.append(f"complete -c exoid -n __fish_use_subcommand -f -a {verb.name} -d '{_line(verb.help)}'")
    for verb in verbs:
        seen = f"complete -c exoid -n '__fish_seen_subcommand_from {verb.name}'"
        words = verb.words_of(verb.positional, effects)
        if words:
            lines.append(f"{seen} -a '{' '.join(words)}'")
        for place in (p for p in verb.places if p.names):
            flags = " ".join(f"-l {n[2:]}" if n.startswith("--") else f"-s {n[1:]}" for n in place.names)
            given = {"": "", "value": " -x", "file": " -r -F", "folder": " -x -a '(__fish_complete_directories)'"}
            choice = " ".join(effects if place.takes == "effect" else place.words)
            values = given.get(place.takes, f" -x -a '{choice}'")
            lines.append(f"{seen} {flags}{values} -d '{place.help}'")
    return "\n".join(lines) + "\n"


SHELLS = MappingProxyType({"bash": bash, "zsh": zsh, "fish": fish})
"""Shell -> function that writes its script."""

_BASH = """\
# exoid: bash completion; add to ~/.bashrc:  source <(exoid completion bash)
_exoid() {{
  local current="${{COMP_WORDS[COMP_CWORD]}}" before="${{COMP_WORDS[COMP_CWORD-1]}}" verb="${{COMP_WORDS[1]}}"
  local effects="{effects}" options="" first="" words="" given=""
  COMPREPLY=()
  if [[ $COMP_CWORD -eq 1 ]]; then
    COMPREPLY=($(compgen -W "{verbs} --help --version" -- "$current")); return
  fi
  if [[ $current == : || $before == : ]]; then  # bash splits stribeck:knee at the colon
    COMPREPLY=($(compgen -W "{joints}" -- "${{current#:}}")); return
  fi
  case "$verb" in
{cases}
  esac
  if [[ -n $given ]]; then
    COMPREPLY=($(compgen -W "$words" -- "$current"))
  elif [[ $current == -* ]]; then
    COMPREPLY=($(compgen -W "$options" -- "$current"))
  elif [[ $COMP_CWORD -eq 2 && -n $first ]]; then
    COMPREPLY=($(compgen -W "$first" -- "$current"))
  fi
}}
complete -o default -o bashdefault -F _exoid exoid
"""

_ZSH = """\
#compdef exoid
# exoid: zsh completion; add to ~/.zshrc after compinit:  source <(exoid completion zsh)
_exoid() {{
  local verb=${{words[2]}} before=${{words[CURRENT-1]}}
  local -a verbs options first effects
  effects=({effects})
  if (( CURRENT == 2 )); then
    verbs=(
{verbs}
    )
    _describe command verbs; return
  fi
  case "$verb" in
{cases}
  esac
  if [[ $PREFIX == -* ]]; then
    compadd -a options
  elif (( CURRENT == 3 && $#first )); then
    compadd -S '' -a first
  else
    _files
  fi
}}
compdef _exoid exoid
"""
