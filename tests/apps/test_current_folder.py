"""Nothing in the current folder is run or obeyed: recordings of somebody else lie there, and perhaps more."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from exoid.ground.import_path import HOME, environment_of_workers, workers_import_alike
from exoid.measurement.reading.read import read_recording
from tests.waiting import HUNG

ROOT = Path(__file__).parents[2]
DEMO = ROOT / "exoid" / "workbench" / "demo_data"
LATE = {"numpy", "scipy", "socket", "concurrent", "h5py"}
OTHERS = {"numpy", "scipy", "casadi", "joblib", "distributed", "submitit", "sympy", "pandas", "h5py", "python_calamine"}
PLANTED = 'open(__file__ + ".ran", "w").close()\nraise SystemExit("planted code was run")\n'
ENGINES = {
    "alone": "from exoid.ground.engines.processes import alone; engine = alone()",
    "processes": "from exoid.ground.engines.processes import processes; engine = processes(2)",
    "dask": "from exoid.apps.campaign.engines.dask import dask; engine = dask('local', 1)",
    "slurm": "from exoid.apps.campaign.engines.slurm import slurm; engine = slurm('local', Path(sys.argv[1]), 1)",
}
ASK = """
import math, os, sys
from pathlib import Path
if __name__ == "__main__":
    {engine}
    try:
        assert engine.executor.submit(math.fsum, [1, 2]).result() == 3
    finally:
        engine.close(True)
    assert "PYTHONSAFEPATH" not in os.environ
"""


@pytest.fixture
def hostile(tmp_path):
    """A folder with recordings, and with a file for every module that anything could import by name."""
    folder = tmp_path / "theirs"
    folder.mkdir()
    for name in (*sys.stdlib_module_names, *OTHERS):
        (folder / f"{name}.py").write_text(PLANTED)
    for k in (1, 2):
        shutil.copy(DEMO / f"train_{k}.csv", folder / f"run_{k}.csv")
    (folder / "plan.toml").write_text('verb = "compare"\nfiles = "run_{run}.csv"\ngroup = []\nverify = 1\n')
    return folder


def started(words, folder, **environment):
    """Run Python with these words there; what was planted must not have run."""
    done = subprocess.run(
        [sys.executable, *map(str, words)], cwd=folder, capture_output=True, text=True, timeout=HUNG, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg", **environment},
    )  # fmt: skip
    assert sorted(path.name for path in folder.rglob("*.ran")) == [], done.stderr
    return done


def exoid(words, folder, **environment):
    """Run a script that lies elsewhere, as the command `exoid` does."""
    script = folder.parent / "exoid-script"
    script.write_text("import sys\nfrom exoid.__main__ import main\nsys.exit(main())\n")
    return started([script, *words], folder, **environment)


CAMPAIGN = ("campaign", "plan.toml", "--out", "fleet", "--jobs", "2", "--quiet")
CONTEST = ("--only", "nfo", "--seeds", "2", "--generations", "3", "--individuals", "6", "--jobs", "2", "--quiet")


@pytest.mark.slow
@pytest.mark.parametrize("words", [CAMPAIGN, ("rivals", "run_1.csv", *CONTEST)], ids=lambda words: words[0])
def test_workers_of_a_command(words, hostile):
    done = exoid(words, hostile, OMP_NUM_THREADS="1")
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    "engine", ["alone", "processes", *(pytest.param(name, marks=pytest.mark.slow) for name in ("dask", "slurm"))]
)
def test_workers_of_every_engine(engine, hostile):
    if engine in ("dask", "slurm"):
        pytest.importorskip({"dask": "distributed", "slurm": "submitit"}[engine])
    script = hostile.parent / "ask.py"
    script.write_text(ASK.format(engine=ENGINES[engine]))
    done = started([script, hostile.parent / "tasks"], hostile)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("suffix", ["xlsx", "mat"])
def test_readers_with_a_process_or_library_of_their_own(suffix, hostile):
    recording = read_recording(DEMO / "train_1.csv")
    columns = {"t": recording.t, **{f"q{k + 1}": recording.q[:, k] for k in (0, 1)},
               **{f"tau{k + 1}": recording.tau[:, k] for k in (0, 1)}}  # fmt: skip
    if suffix == "mat":
        from scipy.io import savemat

        savemat(hostile / "run.mat", columns)
    else:
        book = pytest.importorskip("openpyxl").Workbook()
        for row in (tuple(columns), *zip(*(map(float, column) for column in columns.values()), strict=True)):
            book.active.append(row)
        book.save(hostile / "run.xlsx")
    assert exoid(("compare", f"run.{suffix}", "--quiet"), hostile).returncode == 0


@pytest.mark.slow
def test_python_with_m(hostile, tmp_path):
    (tmp_path / "probe.py").write_text("import sys\nprint(*{name.partition('.')[0] for name in sys.modules})\n")
    probe = [sys.executable, "-m", "probe"]
    before_us = subprocess.run(probe, cwd=tmp_path, capture_output=True, text=True, check=True).stdout.split()
    for name in before_us:  # what `python -m` itself imports from the current folder, before any line of exoid
        (hostile / f"{name}.py").unlink(missing_ok=True)
    done = started(["-m", "exoid", *CAMPAIGN], hostile)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("entries", ["{}:", ":{}", ".:{}", "{}:./"])
def test_an_entry_that_means_the_current_folder_is_left_out(entries, hostile):
    for path in hostile.glob("*.py"):
        if path.stem not in LATE:  # Python reads the others through PYTHONPATH before any line of exoid
            path.unlink()
    done = exoid(CAMPAIGN, hostile, PYTHONPATH=entries.format(ROOT))
    assert done.returncode == 0, done.stderr


def test_a_checkout_is_started_from_its_own_folder():
    done = subprocess.run(
        [sys.executable, "-m", "exoid", "--version"], cwd=ROOT, capture_output=True, text=True, check=False,
        env={name: value for name, value in os.environ.items() if name != "PYTHONPATH"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


def test_workers_import_what_this_process_does_and_its_environment_comes_back(monkeypatch):
    monkeypatch.setattr(sys, "path", ["", "/a", "/b"])
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
    monkeypatch.setenv("PYTHONPATH", "/mine")
    assert environment_of_workers() == {"PYTHONSAFEPATH": "1", "PYTHONPATH": os.pathsep.join(["/a", "/b", HOME])}
    with workers_import_alike():
        assert os.environ["PYTHONSAFEPATH"] == "1"
    assert "PYTHONSAFEPATH" not in os.environ and os.environ["PYTHONPATH"] == "/mine"


@pytest.mark.slow
def test_ipopt_takes_no_options_from_the_current_folder(hostile):
    (hostile / "ipopt.opt").write_text("max_iter 0\noutput_file leaked.txt\nfile_print_level 5\n")
    done = exoid(("identify", "run_1.csv", "run_2.csv"), hostile)
    assert done.returncode == 0 and not (hostile / "leaked.txt").exists(), done.stderr
