"""What is not installed is said in words, with the command that installs it; nothing else needs it."""

from __future__ import annotations

import ast
import re
import sys
import tomllib

import numpy as np
import pytest

import exoid
from exoid.apps.campaign.engines.dask import dask
from exoid.apps.campaign.engines.slurm import slurm
from exoid.apps.watch.io.mqtt import Broker
from exoid.apps.watch.io.prometheus import Scraped
from exoid.ground import cache, cores
from exoid.ground.engines.processes import processes
from exoid.ground.errors import ExoidError
from exoid.optimisation.contest.rivals import entrants
from exoid.optimisation.optimiser import Box
from exoid.optimisation.optimisers import optimisers
from exoid.workbench.command import main
from tests.architecture.source import ROOT, SOURCES, faults, imported, layer_named, name_of

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
FOR_DEVELOPERS = {"test", "notebooks", "peers", "docs", "dev"}
IMPORTED_AS = {"tomli-w": "tomli_w", "lazy-loader": "lazy_loader"}
OF_THE_CORE = {"mpmath", "cycler", "markupsafe"}
"""What packages of the core bring: SymPy, matplotlib, Jinja2."""
ANYWAY = {"rclpy", "sensor_msgs", "polars", "xarray", "pandas", "statsmodels", "pyarrow", "matio", "lz4"}
"""What is asked for and done without, or is handed over by who has it; tests of their own say how."""
PAGE = ("apps/page/app.py", "apps/page/guard.py", "apps/page/reply.py", "apps/page/serve.py")
"""Loaded by `exoid open` alone, after it has looked for what they import."""


ASKED_BEFORE = {
    "measurement/reading/formats/rosbag.py": {"rosbags"},
    "measurement/reading/sheet_process.py": {"python_calamine"},
    "apps/contest/pymoo_engine.py": {"pymoo"},
}
"""Imported after another function has looked for it."""


def start(name):
    def run(_):
        x = np.random.default_rng(1).random((6, 2))
        optimisers()[name]().start(x, x.sum(axis=1), Box(np.zeros(2), np.ones(2)), np.random.default_rng(1))

    return run


def read(suffix, content):
    def run(folder):
        (folder / f"run{suffix}").write_bytes(content)
        exoid.read_recording(folder / f"run{suffix}")

    return run


MATLAB = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512) + b"\x89HDF\r\n\x1a\n"
ASKED = [
    ("h5py", "hdf5", read(".h5", b"\x89HDF\r\n\x1a\n" + bytes(100))),
    ("h5py", "hdf5", read(".mat", MATLAB)),
    ("pyarrow", "parquet", read(".parquet", b"PAR1" + bytes(100))),
    ("python_calamine", "excel", read(".xlsx", b"PK\x03\x04" + bytes(100))),
    ("rosbags", "ros", read(".bag", b"#ROSBAG V2.0\n" + bytes(100))),
    ("nptdms", "tdms", read(".tdms", b"TDSm" + bytes(100))),
    ("pandas", "pandas", lambda _: exoid.simulate(bench=exoid.Bench(duration=5.0)).to_frame()),
    ("joblib", "rivals", lambda _: processes(2)),
    *(("pymoo", "rivals", start(name)) for name in ("ga", "pso", "de")),
    ("distributed", "dask", lambda _: dask("local", 1)),
    ("submitit", "slurm", lambda folder: slurm("local", folder, 1)),
    ("paho", "fleet", lambda _: Broker("mqtt://localhost", "leg")),
    ("prometheus_client", "fleet", lambda _: Scraped(0, "leg")),
]


@pytest.fixture
def without(monkeypatch):
    """Return a function that takes packages away as if they had never been installed."""

    def block(*packages):
        for name in list(sys.modules):
            if name.partition(".")[0] in packages:
                monkeypatch.delitem(sys.modules, name)
        for name in packages:
            monkeypatch.setitem(sys.modules, name, None)

    return block


@pytest.mark.parametrize(("package", "extra", "ask"), ASKED, ids=lambda one: one if isinstance(one, str) else "")
def test_who_asks_for_what_is_not_installed_is_told_the_command(package, extra, ask, without, tmp_path):
    without(package)
    with pytest.raises(ExoidError, match=rf"which is not installed\n.*pip install 'exoid\[{extra}\]'"):
        ask(tmp_path)


@pytest.mark.parametrize(
    ("package", "extra", "words"),
    [
        ("starlette", "page", ["open", "--no-browser"]),
        ("uvicorn", "page", ["open", "--no-browser"]),
        ("joblib", "page", ["open", "--no-browser"]),
        ("shtab", "completion", ["completion", "bash"]),
    ],
)
def test_a_command_without_its_extra_says_so_and_ends_with_2(package, extra, words, without, capsys):
    without(package)
    assert main(words) == 2
    assert f"pip install 'exoid[{extra}]'" in " ".join(capsys.readouterr().err.split())


@pytest.mark.slow
def test_a_contest_of_what_is_installed_needs_no_extra(without):
    without("pymoo", "joblib")
    found = exoid.rivals(
        seeds=2, generations=2, individuals=6, jobs=1, competing={"nfo": entrants()["nfo"]},
    )  # fmt: skip
    assert set(found.outcomes) == {"nfo"} and found.contest.fingerprint()


def test_every_extra_that_is_named_is_there_and_is_explained():
    named = {extra for path in SOURCES for extra in re.findall(r"exoid\[(\w+)\]", path.read_text("utf-8"))}
    assert named | {extra for _, extra, _ in ASKED} <= set(EXTRAS)
    explained = re.findall(r"^\| `(\w+)` \|", (ROOT / "docs" / "install.md").read_text("utf-8"), re.MULTILINE)
    assert sorted(explained) == sorted(set(EXTRAS) - FOR_DEVELOPERS)


def core():
    names = [re.match(r"[\w-]+", one)[0] for one in PROJECT["dependencies"]]
    return {IMPORTED_AS.get(name, name) for name in names}


@pytest.mark.slow
def test_nothing_else_is_imported_without_saying_where_it_comes_from():
    ours = core() | set(sys.stdlib_module_names) | OF_THE_CORE | ANYWAY

    def unsaid(path):
        if name_of(path) in PAGE:
            return
        for node in unguarded(ast.parse(path.read_text("utf-8"))):
            yield from (m for m in imported(node) if not layer_named(m) and m.partition(".")[0] not in ours)

    def unguarded(node):
        if isinstance(node, ast.With) and "needing" in ast.dump(node.items[0].context_expr):
            return
        yield node
        for child in ast.iter_child_nodes(node):
            yield from unguarded(child)

    found = faults(SOURCES, unsaid)
    assert {path: {name.partition(".")[0] for name in names} for path, names in found.items()} == ASKED_BEFORE


def test_the_cores_of_a_container_are_those_it_is_granted(monkeypatch, tmp_path):
    monkeypatch.setattr(cores.os, "sched_getaffinity", lambda _: set(range(64)), raising=False)
    monkeypatch.setattr(cores, "QUOTA", tmp_path / "cpu.max")
    assert cores.cores() == 64
    for granted, count in (("max 100000", 64), ("150000 100000", 2), ("1000 100000", 1)):
        (tmp_path / "cpu.max").write_text(granted + "\n")
        assert cores.cores() == count


@pytest.mark.skipif(sys.platform != "linux", reason="the place is another one elsewhere")
def test_the_usual_cache_is_where_the_system_keeps_such_things(monkeypatch, tmp_path):
    monkeypatch.delenv("EXOID_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache.cache_folder() == tmp_path / "exoid"
