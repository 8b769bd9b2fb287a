"""Fixtures for all tests."""

import os
import shutil
import signal
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# Drawn examples are the same in every run, and how fast a machine is decides nothing.
settings.register_profile("same", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("same")

os.environ.setdefault("MPLBACKEND", "Agg")
# Before NumPy is imported: workers whose BLAS has as many threads as there are cores mostly wait for one another.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ["COLUMNS"] = "200"  # what commands say is not folded in the middle of what a test looks for


# A background job of a shell ignores Ctrl-C, one of nohup that its terminal closes; what tests start would too.
for name, usual in (("SIGINT", signal.default_int_handler), ("SIGHUP", signal.SIG_DFL)):
    number = getattr(signal, name, None)
    if number is not None and signal.getsignal(number) is signal.SIG_IGN:
        signal.signal(number, usual)


def pytest_configure(config):
    """Compile into a folder of this run, shared by all its workers, unless EXOID_CACHE names one.

    A machine without a C compiler is no failure: its one warning is not made an error.
    """
    config.addinivalue_line("filterwarnings", "ignore:.*same numbers, slower")
    if "EXOID_CACHE" not in os.environ:
        config.exoid_cache = os.environ["EXOID_CACHE"] = tempfile.mkdtemp(prefix="exoid-tests-")


def pytest_unconfigure(config):
    """Remove the folder if this process made it."""
    if folder := getattr(config, "exoid_cache", None):
        shutil.rmtree(folder, ignore_errors=True)
        del os.environ["EXOID_CACHE"]


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of example recordings that are not part of the project; tests that need it skip without it."""
    default = Path(__file__).resolve().parents[2] / "shared" / "data"
    folder = Path(os.environ.get("EXOID_SHARED_DATA", default))
    if not folder.is_dir():
        pytest.skip(f"no example recordings in {folder}")
    return folder


@pytest.fixture
def elsewhere(tmp_path):
    """A file that nobody may touch, and a name beside it that nobody may make."""
    path = tmp_path / "home" / "precious"
    path.parent.mkdir()
    path.write_text("precious")
    yield path
    assert path.read_text() == "precious" and [one.name for one in path.parent.iterdir()] == ["precious"]


@pytest.fixture(params=["link", "dangling", "link to a folder", "pipe"])
def plant(request, elsewhere):
    """Return what puts something at a place that is no file of exoid's."""

    def do(place):
        place.parent.mkdir(parents=True, exist_ok=True)
        if request.param == "pipe":
            os.mkfifo(place)
        else:
            files = {"link": elsewhere, "dangling": elsewhere.with_name("made")}
            place.symlink_to(files.get(request.param, elsewhere.parent))

    return do
