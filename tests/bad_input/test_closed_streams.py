"""Standard streams that are closed, full or read by nobody change nothing about the answer but that nobody hears it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from exoid.workbench.commands.demo import DATA
from tests.waiting import HUNG

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.skipif(os.name != "posix", reason="redirections of a shell")
RUNS = f"{DATA}/train_1.csv {DATA}/train_2.csv"


def exoid(words, redirected, folder):
    line = f"{sys.executable} -m exoid {words} {redirected}"
    return subprocess.run(
        ["/bin/sh", "-c", line], cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True,
        text=True, timeout=HUNG, check=False,
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("redirected", [">&-", "2>&-", ">&- 2>&- <&-", "2>/dev/full"])
@pytest.mark.parametrize(
    ("words", "status"), [("", 0), ("--help", 0), ("effects", 0), ("compare --help", 0), ("compare nowhere.csv", 2)]
)
def test_closed_and_full_streams_leave_the_status_as_it_is(words, status, redirected, tmp_path):
    done = exoid(words, redirected, tmp_path)
    assert done.returncode == status and "Traceback" not in done.stderr + done.stdout
    assert not list(tmp_path.iterdir())


def test_an_answer_that_nobody_could_read_is_refused_before_the_work(tmp_path):
    done = exoid(f"compare {RUNS} --json -", ">&-", tmp_path)
    assert done.returncode == 2 and "standard output is closed" in done.stderr


@pytest.mark.slow
def test_what_is_written_is_whole_where_its_file_could_take_the_number_of_a_closed_stream(tmp_path):
    done = exoid(f"compare {RUNS} --json answer.json", ">&- 2>&- <&-", tmp_path)
    assert done.returncode == 0
    assert exoid(f"compare {RUNS} --json other.json", "", tmp_path).returncode == 0
    assert (tmp_path / "answer.json").read_text() == (tmp_path / "other.json").read_text()


@pytest.mark.slow
def test_a_full_disk_and_a_reader_who_has_gone(tmp_path):
    full = exoid("--help", ">/dev/full", tmp_path)
    assert full.returncode == 2 and "No space left" in full.stderr
    line = f"{{ {sys.executable} -m exoid compare nowhere.csv 2>&1; echo $? > status; }} | true"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    subprocess.run(["/bin/sh", "-c", line], cwd=tmp_path, env=environment, timeout=HUNG, check=False)
    assert (tmp_path / "status").read_text().strip() == "2"
