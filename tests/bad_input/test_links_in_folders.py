"""A folder that somebody else handed on leads nowhere: no link in it is followed, and only files in it are opened."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from exoid.ground.delivery import together
from exoid.ground.files import write_whole
from exoid.ground.inputs import read_input
from exoid.ground.inside import is_inside, refuse_links
from exoid.ground.lock import FolderHeld, FolderLock
from exoid.workbench.command import main
from exoid.workbench.command_line.inputs import beside

DEMO = Path(__file__).parents[2] / "exoid" / "workbench" / "demo_data"


def test_what_is_inside():
    assert is_inside("a/b", "a") and is_inside("/x/a/b/c", "/x/a")
    assert not is_inside("a", "a") and not is_inside("a/../b", "a") and not is_inside("/x/ab", "/x/a")
    with pytest.raises(OSError, match="outside"):
        refuse_links("a/../b", "a")


def test_the_folder_itself_may_be_a_link(tmp_path):
    (tmp_path / "disk").mkdir()
    (tmp_path / "out").symlink_to(tmp_path / "disk")
    write_whole(tmp_path / "out" / "deep" / "x", "1", inside=tmp_path / "out")
    assert read_input(tmp_path / "out" / "deep" / "x", 10, inside=tmp_path / "out") == b"1"
    assert main(["effects", "--out", str(tmp_path / "out"), "--quiet"]) == 0


def test_nothing_is_read_or_written_through_it(plant, tmp_path):
    folder = tmp_path / "out"
    for name in ("file", "deep"):
        plant(folder / name)
    for path in (folder / "file", folder / "deep" / "file"):
        with pytest.raises(OSError, match=r"link|ordinary|folder|directory"):
            read_input(path, 100, inside=folder)
        for at_once in (False, True):
            with pytest.raises(OSError, match=r"link|ordinary|folder|directory|exists"), together():
                write_whole(path, "mine", at_once=at_once, inside=folder)


def test_a_link_that_comes_between_is_not_followed(tmp_path, elsewhere):
    target = tmp_path / "out" / "file"
    with pytest.raises(OSError, match="link"), together():
        write_whole(target, "mine", inside=tmp_path / "out")
        target.symlink_to(elsewhere)


@pytest.mark.parametrize("name", ["stribeck.txt", "effects.json"])
def test_results_of_a_command(name, plant, tmp_path, capsys):
    plant(tmp_path / "out" / name)
    assert main(["effects", "--out", str(tmp_path / "out"), "--quiet"]) == 2
    assert "cannot be written" in capsys.readouterr().err


@pytest.mark.slow
def test_figures_of_a_report(elsewhere, tmp_path, capsys):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "figures").symlink_to(elsewhere.parent)
    assert main(["compare", str(DEMO / "train_1.csv"), "--out", str(tmp_path / "out"), "--quiet"]) == 2
    assert "is a link" in capsys.readouterr().err


def test_what_a_command_names_by_itself_is_followed_in_a_folder_of_results_too(tmp_path):
    (tmp_path / "there.json").write_text("{}")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "found.json").symlink_to(tmp_path / "there.json")
    words = ["effects", "--out", str(tmp_path / "out"), "--json", str(tmp_path / "out" / "found.json"), "--quiet"]
    assert main(words) == 0
    assert json.loads((tmp_path / "there.json").read_text())["schema"] == "exoid.effects/1"


@pytest.mark.parametrize(("verb", "name"), [("generate", "generated"), ("demo", "exoid-demo")])
def test_a_folder_that_nobody_named_is_no_link(verb, name, tmp_path, elsewhere, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path(name).symlink_to(elsewhere.parent)
    assert main([verb, "--quiet"]) == 2
    assert "is a link" in capsys.readouterr().err


def test_a_name_that_exoid_chooses_is_no_link(tmp_path, elsewhere):
    (tmp_path / "leg+stribeck-knee.toml").symlink_to(elsewhere.with_name("made"))
    assert Path(beside(str(tmp_path / "leg.toml"), "stribeck:knee")).name == "leg+stribeck-knee-2.toml"


def test_a_mapping_beside_recordings(plant, tmp_path, capsys):
    text = (DEMO / "train_1.csv").read_text().replace("t,q1,q2,tau1,tau2", "t,A,B,C,D", 1)
    folder = tmp_path / "theirs"
    plant(folder / "exoid.toml")
    (folder / "run.csv").write_text(text)
    assert main(["map", str(folder / "run.csv"), "--map", "q1=A,q2=B,tau1=C,tau2=D", "--quiet"]) == 2
    assert "exoid.toml" in capsys.readouterr().err


def test_a_lock_is_one_process_at_a_time_and_its_file_the_folders_own(plant, tmp_path):
    pytest.importorskip("fcntl")
    first = FolderLock(tmp_path)
    with pytest.raises(FolderHeld):
        FolderLock(tmp_path)
    first.release()
    FolderLock(tmp_path).release()
    (tmp_path / ".lock").unlink()
    plant(tmp_path / ".lock")
    with pytest.raises(OSError, match=r"link|ordinary"):
        FolderLock(tmp_path)
