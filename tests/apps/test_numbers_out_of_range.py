"""Every numeric option with what is no number, or with one that no leg, sensor or person ever had."""

import argparse
import json

import pytest

from exoid.measurement.bench.simulation import Bench, BenchError
from exoid.measurement.trajectories.trajectory import TrajectoryError, paper_trajectory
from exoid.optimisation.excitation.criteria import Noise
from exoid.workbench.command import find_verbs, main, verb_parser
from exoid.workbench.command_line.options import between, whole_number
from tests.waiting import until

WILD = ("nan", "inf", "-inf", "-1", "1e400", "1e999999", "", " ", "abc", "0x10", "1_000_000_000_000_000", "٣e9", "--")
NUMERIC = ("HZ", "S", "N", "K", "SHARE", "VALUE", "B", "NM", "W", "RMS")


def numeric_options():
    for verb in find_verbs():
        for action in verb_parser(verb)._actions:
            if action.option_strings and action.metavar in NUMERIC:
                yield verb, action.option_strings[0]


@pytest.mark.parametrize("verb, option", list(numeric_options()))
def test_what_is_no_number_is_refused(verb, option, tmp_path, capsys):
    positional = {"identify": ["x"], "compare": ["x"], "diagnose": ["x"], "discover": ["x"], "export": ["x"]}
    for text in ("nan", "inf", "1e400", "", "abc", "0x10"):
        assert main([verb, *positional.get(verb, []), option, text, "--out", str(tmp_path / "out")]) == 2, text
    assert "Traceback" not in capsys.readouterr().err and not (tmp_path / "out").exists()


@pytest.mark.slow
@pytest.mark.parametrize("words", [
    ["simulate", "--duration", "1e300"], ["simulate", "--rate", "1e300"], ["simulate", "--duration", "1e9"],
    ["design", "--period", "1e-9"], ["design", "--period", "1e300"], ["design", "--noise", "1e-300"],
    ["design", "--check", "paper", "--duration", "1e300"], ["design", "--harmonics", "4000000000"],
    ["rivals", "--individuals", "4000000000"], ["rivals", "--generations", "4000000000"],
    ["rivals", "--jobs", "4000000000"], ["rivals", "--seeds", "4000000000"],
])  # fmt: skip
def test_what_no_leg_ever_had_is_refused_at_once(words, tmp_path, capsys):
    assert main([*words, "--out", str(tmp_path / "out")]) == 2
    assert "Traceback" not in capsys.readouterr().err and not (tmp_path / "out").exists()


def test_a_motion_that_hardly_moves_is_judged(capsys):
    for period in ("0.01", "1e5"):
        assert main(["design", "--check", "paper", "--period", period, "--quiet"]) in (0, 1)
    assert "Traceback" not in capsys.readouterr().err


def test_a_cut_off_that_leaves_nothing(tmp_path, capsys):
    assert main(["simulate", "--runs", "1", "--duration", "12", "--out", str(tmp_path), "--quiet"]) == 0
    for cutoff in ("1e-300", "1e-9", "0.05", "1e300", "0"):
        assert main(["compare", str(tmp_path / "run_0.csv"), "--cutoff", cutoff]) == 2
    assert "Traceback" not in capsys.readouterr().err


def test_the_same_from_python():
    for wrong in ({"duration": 1e300}, {"rate": 1e300}, {"duration": float("nan")}, {"duration": 1e5, "rate": 1e4}):
        with pytest.raises(BenchError):
            Bench(**wrong)
    for period in (0.0, 1e-9, 1e300, float("nan"), float("inf")):
        with pytest.raises(TrajectoryError):
            paper_trajectory(period)
    for sd in (0.0, -1.0, float("nan"), float("inf"), 1e-300, (1.0, 0.0)):
        with pytest.raises(TrajectoryError):
            Noise.white(sd)


LEG = "[geometry]\nthigh_length = {}\ngravity = {}\n"
CHAIN = 'gravity = {}\n[[joints]]\nname = "a"\nlength = {}\n[[joints]]\nname = "b"\n'
ARM = """gravity = [0.0, 0.0, -{}]
[[joints]]
name = "a"
axis = [0, 0, 1]
origin = {{ xyz = [{}, 0, 0] }}
"""


@pytest.mark.parametrize("text, usual", [(LEG, (0.4, 9.81)), (CHAIN, (9.81, 0.4)), (ARM, (9.81, 0.1))])
@pytest.mark.parametrize("wild", ["1e-300", "1e-30", "1e-9", "1e30", "1e300", "-1e300"])
def test_a_machine_that_nobody_built_is_refused_with_its_line(text, usual, wild, tmp_path, capsys):
    """Squares of its lengths are nothing beside the other numbers, or have no place in arithmetic."""
    for place in range(2):
        values = [wild if k == place else value for k, value in enumerate(usual)]
        tiny = text is ARM and place == 1 and float(wild) == abs(float(wild)) < 1.0  # as good as zero, which may be
        (tmp_path / "model.toml").write_text(text.format(*values).replace("--", "-"))
        status = main(["effects", "--model", str(tmp_path / "model.toml"), "--quiet"])
        said = capsys.readouterr().err
        assert status == (0 if tiny else 2) and "Traceback" not in said, values
        assert tiny or "model.toml" in said, said


def test_a_range_says_itself():
    assert between(0.1, 2.0, "s")("2") == 2.0 and between(0, 3, number=whole_number)("3") == 3
    for read, text in (
        (between(0.1, 2.0, "s"), "3"),
        (between(0, 3, number=whole_number), "4"),
        *((between(0.0, 1.0), text) for text in WILD),
    ):
        with pytest.raises(argparse.ArgumentTypeError):
            read(text)


@pytest.mark.parametrize("name, change", {
    "empty": lambda text: "", "cut": lambda text: text[:200], "list": lambda text: "[]", "number": lambda text: "1",
    "deep": lambda text: "[" * 100_000, "no run": lambda text: json.dumps({**json.loads(text), "run": None}),
    "run is a list": lambda text: json.dumps({**json.loads(text), "run": []}),
    "texts": lambda text: text.replace('"evaluations": ', '"evaluations": "x", "y": '),
    "empty arrays": lambda text: json.dumps(edit(text, gaps=[], found_at=[])),
    "better": lambda text: json.dumps(edit(text, gaps=[0.0], found_at=[1.0])),
    "better with its hash": lambda text: json.dumps(sealed(edit(text, gaps=[1e-14], found_at=[5.0]))),
    "other point": lambda text: json.dumps(sealed(edit(text, x=[1.0] * 8))),
    "not finite": lambda text: json.dumps(sealed(edit(text, x=[float("nan")] * 8))),
    "binary": lambda text: "\x00\udcff" * 50,
}.items(), ids=lambda value: value if isinstance(value, str) else "")  # fmt: skip
def test_a_run_that_was_damaged_or_altered_is_run_again(name, change, tmp_path, kept):
    text, contest, search, path = kept
    from exoid.optimisation.contest.store import RunStore

    path.write_text(text)
    assert RunStore(path.parent, contest).read("de", search, 0) is not None
    path.write_bytes(change(text).encode("utf-8", "surrogateescape"))
    store = RunStore(path.parent, contest)
    assert store.read("de", search, 0) is None and store.damaged == 1


def edit(text, **changes):
    content = json.loads(text)
    return {**content, "run": {**content["run"], **changes}}


def sealed(content):
    from exoid.optimisation.contest.store import _hash

    return {**content, "sha256": _hash(content)}


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """The file of one short run."""
    from exoid.optimisation.contest.problem import paper_contest, race
    from exoid.optimisation.contest.rivals import entrants
    from exoid.optimisation.contest.store import RunStore

    folder = tmp_path_factory.mktemp("runs")
    contest, search = paper_contest(0, 8, 4), entrants()["de"]
    RunStore(folder, contest).write(race(contest, "de", search, 0), search)
    (path,) = folder.iterdir()
    return path.read_text(), contest, search, path


def test_a_pipe_in_the_place_of_a_run(kept):
    import os

    from exoid.optimisation.contest.store import RunStore

    text, contest, search, path = kept
    path.unlink()
    os.mkfifo(path)
    store = RunStore(path.parent, contest)
    assert store.read("de", search, 0) is None and store.damaged == 1
    path.unlink()
    path.write_text(text)


@pytest.mark.slow
def test_a_worker_ends_with_the_process_it_works_for(tmp_path):
    """Killed outright, without a chance to say goodbye."""
    import os
    import signal
    import subprocess
    import sys
    from contextlib import suppress
    from pathlib import Path

    code = (
        "import os, subprocess, sys, time\n"
        'child = "import os, time; from exoid.ground.engines.processes import end_with; end_with(os.getppid()); '
        'print(os.getpid(), flush=True); time.sleep(3600)"\n'
        "subprocess.Popen([sys.executable, '-c', child])\n"
        "time.sleep(3600)\n"
    )
    master = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, cwd=Path(__file__).parents[2]
    )
    with master.stdout as said:
        worker = int(said.readline())
    master.send_signal(signal.SIGKILL)
    master.wait()

    def gone():
        try:
            os.kill(worker, 0)
        except ProcessLookupError:
            return True
        stat = Path(f"/proc/{worker}/stat")
        return stat.exists() and stat.read_text().split()[2] == "Z"

    try:
        until(gone, lambda: "the worker is still there")
    finally:
        with suppress(ProcessLookupError):
            os.kill(worker, signal.SIGKILL)
