"""The frame of the command line: speed, suggestions, statuses, output targets."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from exoid.workbench.command import BAD_INPUT, GROUPS, find_verbs, load_verb, main, verb_parser
from exoid.workbench.commands.demo import DATA

HEAVY = ("sympy", "casadi", "scipy", "matplotlib", "pandas", "rich", "jinja2", "h5py")
ROOT = Path(__file__).parents[2]


def in_a_process(code: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8"}
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment, check=False)


@pytest.mark.parametrize("arguments", [[], ["--help"], ["discover", "-h"], ["discovr"]])
def test_help_does_not_even_load_numpy(arguments):
    code = (
        f"import sys; from exoid.workbench.command import main; main({arguments!r}); "
        "print('numpy', 'numpy' in sys.modules)"
    )
    assert "numpy False" in in_a_process(code).stdout


@pytest.mark.parametrize(
    "arguments", [[], ["--help"], ["effects", "--json", os.devnull, "--quiet"], ["discover", "-h"]]
)
def test_help_and_catalogue_load_nothing_heavy(arguments):
    code = (
        f"import sys; from exoid.workbench.command import main; status = main({arguments!r})\n"
        f"print('LOADED', [m for m in {HEAVY!r} if m in sys.modules], 'STATUS', status)"
    )
    out = in_a_process(code)
    assert "LOADED [] STATUS 0" in out.stdout, out.stdout + out.stderr


def test_alone_it_tells_a_newcomer_what_to_do_first(capsys):
    assert main([]) == 0
    assert "exoid demo" in capsys.readouterr().out


def test_overview_names_every_verb(capsys):
    assert main(["--help"]) == 0
    text = capsys.readouterr().out
    assert all(text.count(f"\n  {verb} ") == 1 for verb in find_verbs())
    assert {load_verb(verb).GROUP for verb in find_verbs()} <= set(GROUPS)


@pytest.mark.parametrize("verb", find_verbs())
def test_every_verb_keeps_the_contract(verb, capsys):
    module = load_verb(verb)
    assert module.HELP.strip()
    options = {name for action in verb_parser(verb)._actions for name in action.option_strings}
    assert {"--json", "--out", "--seed", "--quiet"} <= options
    assert main([verb, "--help"]) == 0
    assert f"exoid {verb}" in capsys.readouterr().out


@pytest.mark.parametrize("verb", find_verbs())
def test_help_fits_a_screen_and_all_of_it_can_be_asked_for(verb, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    options = [action.option_strings[-1] for action in verb_parser(verb)._actions if action.option_strings]
    assert main([verb, "--help"]) == 0
    short = capsys.readouterr().out
    assert len(short.splitlines()) <= 40
    assert main([verb, "nowhere.csv", "--help-all"]) == 0
    whole = capsys.readouterr().out
    assert all(option in short for option in options if option != "--help")  # at least by name
    assert all(f"  {option}" in whole or f", {option}" in whole for option in options)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["diagnos"], "did you mean 'diagnose'"),
        (["zzz"], "known: add, "),
        (["--verbose"], "unknown option"),
        (["effects", "stribek"], "did you mean stribeck"),
        (["effects", "--jsn", "-"], "did you mean '--json'"),
        (["effects", "--seed", "x"], "'x' is not a whole number"),
        (["effects", "--seed", "-1"], "not between 0 and"),
        (["effects", "--json", "/nowhere/x.json"], "/nowhere/x.json: cannot be written"),
        (["effects", "--json", "."], "this is a folder"),
        (["effects", "--out", os.devnull], "cannot be written"),
        (["compare"], "required: REC"),
        (["compare", "--verify", "a.csv"], "before --verify"),
        (["compare", "nowhere.csv"], "nowhere.csv: there is no such file"),
        (["compare", "a.csv", "--cutoff", "0"], "0 is not above zero"),
        (["compare", "a.csv", "--cutoff", "nan"], "not a finite number"),
        (["compare", "a.csv", "--limit", "1,2,3"], "has 3 numbers"),
        (["compare", "a.csv", "--map", "q1"], "is not NAME=VALUE"),
        (["compare", "a.csv", "--map", "q1=x", "--map", "q1=y"], "q1 is given as 'x' and as 'y'"),
        (["compare", "a.csv", "--map", "q1=x,q1=y"], "given twice"),
        (["compare", "a.csv", "./a.csv"], "named twice"),
        (["compare", "a.csv", "--verify", "a.csv"], "both fitted and in --verify"),
        (["add", "stribeck:kne", "a.csv"], "did you mean 'knee'"),
        (["add", "stribeck:", "a.csv"], "does not name an effect"),
        (["add", "stribek:knee", "a.csv"], "did you mean stribeck"),
        (["simulate", "--runs", "0"], "not between 1 and 100"),
        (["simulate", "--effect", "stribek:knee"], "did you mean stribeck"),
        (["simulate", "--effect", "stribeck:knee=big"], "big"),
        (["reveal", "nowhere.seal"], "cannot be read"),
    ],
)
def test_bad_input_is_told_and_ends_with_2(arguments, said, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == BAD_INPUT
    captured = capsys.readouterr()
    assert said in captured.err
    assert "Traceback" not in captured.err
    assert captured.out == ""


def test_bad_input_leaves_nothing_behind(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    main(["simulate", "--effect", "stribek:knee"])
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("error", "status", "said"),
    [
        (KeyboardInterrupt(), 130, "interrupted"),
        (MemoryError(), 2, "not enough memory"),
        (OSError(28, "No space left on device", "x.json"), 2, "x.json: No space left on device"),
        (ZeroDivisionError("oops"), 70, "internal error"),
    ],
)
def test_what_goes_wrong_has_its_own_status(error, status, said, monkeypatch, capsys):
    def fail(args):
        raise error

    monkeypatch.setattr(load_verb("effects"), "run", fail)
    assert main(["effects"]) == status
    assert said in capsys.readouterr().err


def test_a_reader_that_leaves_early_hears_nothing_more():
    command = f"{sys.executable} -m exoid.workbench.command effects | head -1"
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "utf-8"}
    out = subprocess.run(command, shell=True, capture_output=True, text=True, env=environment, check=False)
    assert out.stderr == ""


def test_json_on_standard_output_is_alone_there(capsys):
    assert main(["effects", "stribeck", "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["schema"] == "exoid.effects/1"
    assert found["effects"][0]["shape"]["v_s"]["unit"] == "rad/s"


def test_effects_can_be_written_to_a_folder(tmp_path, capsys):
    assert main(["effects", "--out", str(tmp_path / "catalogue"), "--quiet"]) == 0
    assert capsys.readouterr().out == ""
    assert (tmp_path / "catalogue" / "stribeck.txt").read_text("utf-8").startswith("stribeck")
    assert json.loads((tmp_path / "catalogue" / "effects.json").read_text("utf-8"))["effects"]


def test_options_may_stand_between_recordings():
    args = verb_parser("compare").parse(["a.csv", "--seed", "3", "b.csv", "--verify", "c.csv", "--map", "q1=x\\,y"])
    assert (args.recordings, args.verify, args.seed, args.map) == (["a.csv", "b.csv"], ["c.csv"], 3, [{"q1": "x,y"}])


def without_greek(*arguments, **environment):
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "ascii", **environment}
    command = [sys.executable, "-m", "exoid.workbench.command", *arguments]
    out = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert (out.returncode, out.stderr) == (0, "")
    assert out.stdout.isascii()
    return out.stdout


def test_a_terminal_without_greek_gets_words():
    text = without_greek("effects", "stribeck")
    assert "c*sgn(theta')*exp(-(theta' / v_s)^2)" in text
    assert "c: N*m" in text


def test_tables_are_straight_without_greek():
    lines = without_greek("effects", COLUMNS="120").splitlines()[:-1]
    assert {len(line) for line in lines} == {len(lines[0])}
    assert len(lines[0]) <= 120
    assert "?" not in "".join(lines)


def test_json_says_the_same_without_greek(capsys):
    assert main(["effects", "stribeck", "--json", "-"]) == 0
    assert json.loads(without_greek("effects", "stribeck", "--json", "-")) == json.loads(capsys.readouterr().out)


def test_everything_a_pipe_gets_fits_80_columns():
    for arguments in ([], ["effects"], ["effects", "stribeck"]):
        assert max(len(line) for line in without_greek(*arguments, COLUMNS="").splitlines()) <= 80


def test_a_file_of_a_folder_that_verify_names_is_held_out(tmp_path, capsys):
    for file in DATA.glob("*.csv"):
        shutil.copy(file, tmp_path)
    assert main(["compare", str(tmp_path), "--verify", str(tmp_path / "verify.csv"), "--json", "-", "--quiet"]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["verify_rms"] is not None
    assert main(["compare", str(tmp_path), "--verify", str(tmp_path), "--quiet"]) == BAD_INPUT
    assert "both fitted" in capsys.readouterr().err
