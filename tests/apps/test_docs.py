"""Every `exoid` command that the documentation shows runs, in the order shown, in an empty folder."""

from __future__ import annotations

import os
import re
import runpy
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from exoid.workbench.command import main, verb_parser
from tests.waiting import HUNG

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted(p for p in (ROOT / "docs").glob("*.md") if "```sh" in p.read_text(encoding="utf-8"))


def commands(page: Path) -> list[str]:
    blocks = re.findall(r"^```sh\n(.*?)^```", page.read_text(encoding="utf-8"), flags=re.S | re.M)
    return [line for block in blocks for line in block.splitlines() if line.startswith("exoid ")]


def write_files(page: Path, folder: Path) -> None:
    """Write the TOML files that a page shows, those that start with their name, `# plan.toml`, and the URDFs."""
    whole = page.read_text("utf-8")
    for name, text in re.findall(r"^```xml\n<!-- (\S+\.urdf) -->\n(.*?)^```", whole, flags=re.S | re.M):
        (folder / name).write_text(text, encoding="utf-8")
    for name, text in re.findall(r"^```toml\n# (\S+\.toml)\n(.*?)^```", whole, flags=re.S | re.M):
        (folder / name).write_text(text, encoding="utf-8")


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_commands_of_a_page_are_commands(page):
    found = commands(page)
    assert found
    for line in found:
        verb, *arguments = shlex.split(line)[1:]
        if not verb.startswith("-"):
            verb_parser(verb).parse(arguments)


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_commands_of_a_page_run(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "generated", tmp_path / "generated")
    write_files(page, tmp_path)
    for line in commands(page):
        status = main(shlex.split(line)[1:])
        said = capsys.readouterr()
        assert status == 0, f"{line}: {said.err} {said.out}"


def test_links_between_pages_lead_somewhere():
    for page in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md")]:
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_the_documentation_is_short_enough_to_be_read():
    pages = [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]
    words = {page.name: len(page.read_text("utf-8").split()) for page in pages}
    assert words["README.md"] <= 800
    assert sum(words.values()) <= 29_980, sorted(words.items(), key=lambda one: -one[1])


def test_the_readme_names_the_numbers_that_its_pictures_show():
    script = runpy.run_path(str(ROOT / "benchmarks" / "make_pictures.py"))
    text = " ".join((ROOT / "README.md").read_text("utf-8").split())
    said = re.search(r"falls from ([\d.]+) to ([\d.]+) N·m", text).groups()
    assert set(said) <= set(script["text_on"](ROOT / "docs" / "page.png").split())


def test_pictures_of_another_answer_are_noticed():
    script = runpy.run_path(str(ROOT / "benchmarks" / "make_pictures.py"))
    other = {"steps": [{"verify_rms": [0.332, 0.672]}, {"verify_rms": [0.331, 0.177]}]}
    assert {"0.33 is not on falling_error.png", "0.177 is not on report.png"} <= set(script["out_of_date"](other))


def test_readme_has_two_commands_of_set_up():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```sh\n(.*?)^```", text, flags=re.S | re.M)
    assert len(blocks) == 2
    assert all(len(block.strip().splitlines()) == 1 for block in blocks)
    assert "exoid demo" in blocks[0] and "pytest" in blocks[1]


@pytest.fixture
def four_runs(tmp_path, monkeypatch, capsys):
    """An empty folder with the recordings that the README speaks of; Stribeck friction is hidden in the hip."""
    monkeypatch.chdir(tmp_path)
    making = "simulate --effect stribeck:hip=2.6 --runs 4 --duration 20 --seed 3 --out . --quiet"
    assert main(making.split()) == 0, capsys.readouterr().err
    for k in range(4):
        Path(f"run_{k}.csv").rename(f"run{k + 1}.csv")


def blocks_of_readme(language):
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.S | re.M)


@pytest.mark.slow
def test_the_loop_of_the_readme_runs(four_runs, capsys):
    lines = [line.removeprefix("$ ") for block in blocks_of_readme("console") for line in block.splitlines()]
    assert len(lines) == 4
    for line in lines:
        status = main(shlex.split(line, comments=True)[1:])
        said = capsys.readouterr()
        assert status == 0, f"{line}: {said.err} {said.out}"


@pytest.mark.slow
def test_the_python_of_the_readme_runs(four_runs):
    (script,) = blocks_of_readme("python")
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False, env=environment(), timeout=HUNG
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(("missing:", "ambiguous:"))


def environment():
    return {**os.environ, "PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg"}


@pytest.mark.slow
def test_the_catalogue_page_is_what_the_catalogue_says():
    script = runpy.run_path(str(ROOT / "benchmarks" / "make_effects_page.py"))
    fresh, shown = script["page"](), (ROOT / "docs" / "effects.md").read_text(encoding="utf-8")
    assert shown == fresh, "run python benchmarks/make_effects_page.py"


@pytest.mark.slow
def test_the_effect_of_the_page_is_found(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    page = (ROOT / "docs" / "add_an_effect.md").read_text(encoding="utf-8")
    Path("leg.toml").write_text(re.findall(r"^```toml\n(.*?)^```", page, flags=re.S | re.M)[0], encoding="utf-8")
    lines = re.findall(r"^\$ (exoid .*)$", page, flags=re.M)
    assert len(lines) == 4
    for line in lines:
        status = main(shlex.split(line)[1:])
        out = capsys.readouterr()
        assert status == 0, f"{line}: {out.err}"
        if "diagnose" in line:
            assert "Found: magnet brake at the knee" in out.out
    assert "magnet_brake" in Path("leg2.toml").read_text(encoding="utf-8")


def test_the_page_on_the_paper_says_what_the_check_says():
    from exoid.symbolic.check import check_equations
    from exoid.symbolic.model import Model

    page = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
    printed = " ".join(str(line) for line in check_equations(Model.standard()))
    assert "(1, 3)" in page and ("(1, 3)" in printed or "(1,3)" in printed)


@pytest.mark.slow
def test_commands_of_the_page_on_real_recordings_run(shared_data, tmp_path, monkeypatch, capsys):
    folder = shared_data / "two_link_rig_c0"
    if not folder.is_dir():
        pytest.skip("the recordings are not there")
    monkeypatch.chdir(tmp_path)
    for recording in folder.glob("run_*.csv"):
        shutil.copy(recording, tmp_path)
    page = (ROOT / "docs" / "real_recordings.md").read_text(encoding="utf-8")
    Path("rig.toml").write_text(re.findall(r"^```toml\n(.*?)^```", page, flags=re.S | re.M)[0], encoding="utf-8")
    lines = re.findall(r"^\$ (exoid .*)$", page, flags=re.M)
    assert len(lines) == 4
    said = []
    for line in lines:
        status = main(shlex.split(line)[1:])
        out = capsys.readouterr()
        assert status in (0, 1), f"{line}: {out.err}"
        said.append(" ".join(out.out.split()))
    assert "not the 0.4 m of the model" in said[0] and "not the 0.2 m of the model" not in said[1]
    assert "Which numbers can I trust?" in said[2]
