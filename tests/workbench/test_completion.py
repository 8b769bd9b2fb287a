"""Completion: written from the parsers, understood by the shells that are here."""

from __future__ import annotations

import shutil
import subprocess

import pytest

from exoid.workbench.command import find_verbs, main
from exoid.workbench.commands.completion import SHELLS, script

ASK = """{script}
COMP_WORDS=({words}); COMP_CWORD={place}; compopt() {{ :; }}; _exoid; printf '%s\\n' "${{COMPREPLY[@]}}"
"""


def complete(*words: str) -> list[str]:
    text = ASK.format(script=script("bash"), words=" ".join(f"'{w}'" for w in words), place=len(words) - 1)
    out = subprocess.run(["bash", "--norc", "-c", text], capture_output=True, text=True, check=True)
    assert out.stderr == ""
    return out.stdout.split()


@pytest.mark.parametrize("shell", sorted(SHELLS))
def test_every_verb_and_option_is_offered(shell):
    text = script(shell)
    assert all(verb in text for verb in find_verbs())
    assert "stribeck" in text
    assert "verify" in text


@pytest.mark.parametrize("shell", sorted(SHELLS))
def test_the_shell_itself_accepts_it(shell, tmp_path):
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not on this machine")
    path = tmp_path / "script"
    path.write_text(script(shell), "utf-8")
    out = subprocess.run([shell, "-n", str(path)], capture_output=True, text=True, check=False)
    assert (out.returncode, out.stderr) == (0, "")


@pytest.mark.parametrize(
    ("words", "offered"),
    [
        (("exoid", "disc"), ["discover"]),
        (("exoid", "add", "stri"), ["stribeck"]),
        (("exoid", "add", "stribeck", ":"), ["hip", "knee"]),
        (("exoid", "add", "stribeck", ":", "k"), ["knee"]),
        (("exoid", "compare", "a.csv", "--ver"), ["--verify", "--verbose"]),
        (("exoid", "simulate", "--effect", "backl"), ["backlash"]),
        (("exoid", "simulate", "--seed", ""), []),
        (("exoid", "completion", "z"), ["zsh"]),
        (("exoid", "compare", "run"), []),  # files: left to the shell
    ],
)
def test_bash_offers(words, offered):
    if shutil.which("bash") is None:
        pytest.skip("bash is not on this machine")
    assert complete(*words) == offered


def test_the_command_prints_and_writes_it(tmp_path, capsys):
    assert main(["completion", "bash", "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().out == script("bash") == (tmp_path / "exoid.bash").read_text("utf-8")


def test_a_shell_that_is_not_known(capsys):
    assert main(["completion", "csh"]) == 2
    assert "invalid choice" in capsys.readouterr().err
