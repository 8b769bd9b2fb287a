"""How the server's process ends where something still works."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.waiting import HUNG

DRAWING = """
import threading, time
from matplotlib.figure import Figure
from exoid.apps.page.serve import finish_threads

drawn = threading.Event()

def draw():
    while True:
        figure = Figure()
        figure.add_subplot().plot([0.0, 1.0])
        figure.savefig({picture!r})
        drawn.set()

def write():
    time.sleep({writing})
    open({written!r}, "w").close()

threading.Thread(target=write, daemon=True).start()
if {endless}:
    threading.Thread(target=draw, daemon=True).start()
    drawn.wait()
finish_threads({patience})
print("the interpreter ends by itself", flush=True)
"""


@pytest.mark.slow
@pytest.mark.parametrize(("endless", "writing", "patience"), [(True, 0.0, 0.5), (False, 0.5, 60.0)])
def test_what_still_works_is_waited_for_and_never_aborts(tmp_path, endless, writing, patience):
    pytest.importorskip("uvicorn")
    pytest.importorskip("matplotlib")
    written = tmp_path / "report.html"
    code = DRAWING.format(
        picture=str(tmp_path / "x.png"), written=str(written), endless=endless, writing=writing, patience=patience
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=Path(__file__).parents[3], capture_output=True, text=True, timeout=HUNG
    )
    assert done.returncode == 0, done.stderr
    assert written.exists() and done.stderr == ""
    assert ("by itself" in done.stdout) is not endless
