"""A session's folder: recordings by their content, one process at a time, whole at every moment, nothing outside."""

from __future__ import annotations

import json
import os
import shutil
import stat
import subprocess
import sys
import warnings
import zipfile
from pathlib import Path

import pytest

from exoid.apps.page import folder as module
from exoid.apps.page.folder import SessionFolder
from exoid.apps.page.given import VERIFY, read_given
from exoid.apps.page.saved import keep_in, reopen, save
from exoid.apps.page.workspace import Workspace
from exoid.ground.delivery import PREFIX
from exoid.ground.errors import RecordingError
from exoid.ground.files import sha256
from exoid.ground.lock import LOCK
from exoid.workbench.command import main
from exoid.workbench.commands.demo import DATA

ROOT = Path(__file__).parents[3]
HEAD = "t,q1,q2,tau1,tau2\n"


@pytest.fixture
def runs(tmp_path):
    """Two recordings of one name in two folders."""
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "run.csv").write_text(HEAD + f"0,0,0,{name == 'b':d},0\n")
    return {name: tmp_path / name / "run.csv" for name in ("a", "b")}


@pytest.fixture
def workspace(tmp_path):
    made = []

    def make(*paths, role="fit"):
        space = Workspace(tmp_path / "mappings")
        made.append(space)
        for path in paths:
            space.add_file(path, path.name, role)
        return space

    yield make
    for space in made:
        space.close()


def contents(folder):
    """Return {name: content} of the recordings that a session names."""
    told = json.loads((folder / "session.json").read_text())
    return {one["name"]: (folder / one["file"]).read_text() for one in told["recordings"]}


def files(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def test_two_recordings_of_one_name_are_never_mixed_up(runs, workspace, tmp_path):
    for name in ("a", "b"):
        space = workspace(runs[name])
        keep_in(space, tmp_path / "kept")
        save(space, tmp_path / "kept")
        space.close()
        assert contents(tmp_path / "kept") == {"run.csv": runs[name].read_text()}
    both = workspace(runs["a"], runs["b"])
    save(both, tmp_path / "kept")
    assert contents(tmp_path / "kept") == {"run.csv": runs["a"].read_text(), "run (2).csv": runs["b"].read_text()}


def test_a_closed_recording_leaves_the_folder_and_is_not_lost(runs, workspace, tmp_path):
    space = workspace(runs["a"], runs["b"])
    kept = save(space, tmp_path / "kept")
    space.remove_file(1)
    save(space, kept)
    assert list(contents(kept).values()) == [runs["b"].read_text()]
    assert len(list((kept / "recordings").iterdir())) == 1 and not (tmp_path / "kept-closed").exists()
    space.close()
    runs["b"].unlink()  # from here on the session has the only copy
    again = workspace()
    reopen(again, kept)
    again.add_file(runs["a"], "run.csv")
    again.remove_file(1)
    save(again, kept)
    assert list(contents(kept).values()) == [runs["a"].read_text()]
    (aside,) = (tmp_path / "kept-closed").iterdir()
    assert aside.read_text() == HEAD + "0,0,0,1,0\n" and len(list((kept / "recordings").iterdir())) == 1


@pytest.mark.slow
def test_dropped_recordings_that_are_closed_are_nowhere_any_more(runs, workspace, tmp_path):
    """Their only copies were the page's own, and the disk of who drops and closes all day would fill."""
    space = workspace()
    keep_in(space, tmp_path / "kept")
    for number in range(20):
        place = space.drop_place("run.csv")
        place.write_text(HEAD + f"0,0,0,{number},0\n")
        space.add_file(place, f"run{number}.csv")
    with zipfile.ZipFile(space.drop_place("runs.zip"), "w") as archive:
        archive.write(runs["a"], "deep/a.csv")
        archive.write(runs["b"], "deep/b.csv")
    for name in ("a", "b"):
        space.add_file(Path(archive.filename) / "deep" / f"{name}.csv", f"{name}.csv")
    save(space, tmp_path / "kept")
    assert len(files(tmp_path / "kept" / "recordings")) == 22
    for one in list(space.given)[:-1]:
        space.remove_file(one.id)
        save(space, tmp_path / "kept")
    assert {*files(space.place)} - {LOCK} == {Path(archive.filename).relative_to(space.place).as_posix()}
    assert list(contents(tmp_path / "kept")) == ["b.csv"] and len(files(tmp_path / "kept" / "recordings")) == 1
    space.remove_file(space.given[0].id)
    save(space, tmp_path / "kept")
    assert os.listdir(space.place) == [LOCK] and not files(tmp_path / "kept" / "recordings")
    assert runs["a"].exists() and not (tmp_path / "kept-closed").exists()


def test_what_others_put_there_stays(runs, workspace, tmp_path):
    space = workspace(runs["a"])
    kept = save(space, tmp_path / "kept")
    (kept / "recordings" / "notes.txt").write_text("mine")
    (kept / "letter.md").write_text("mine")
    space.remove_file(1)
    save(space, kept)
    assert {"recordings/notes.txt", "letter.md"} <= set(files(kept)) and not contents(kept)


def test_a_recording_that_changed_since_it_was_read_is_not_kept_under_its_numbers(workspace, tmp_path):
    path = Path(shutil.copy(DATA / "train_1.csv", tmp_path / "run.csv"))
    space = workspace(path)
    space.given[0] = read_given(space.given[0], tmp_path / "mappings")
    with path.open("a") as stream:
        stream.write("100,0,0,0,0\n")
    with pytest.raises(RecordingError, match="changed since it was read"):
        save(space, tmp_path / "kept")
    assert not (tmp_path / "kept" / "session.json").exists()


def test_a_recording_that_is_gone_once_it_is_kept_is_no_trouble(workspace, tmp_path):
    path = Path(shutil.copy(DATA / "train_1.csv", tmp_path / "run.csv"))
    space = workspace(path)
    space.given[0] = read_given(space.given[0], tmp_path / "mappings")
    kept = save(space, tmp_path / "kept")
    path.unlink()
    assert contents(save(space, kept)) == {"run.csv": (DATA / "train_1.csv").read_text()}
    with pytest.raises(RecordingError, match="no such file"):
        save(space, tmp_path / "another")


def test_parts_of_archives_and_mappings_beside_a_recording_are_kept_too(workspace, tmp_path):
    text = (DATA / "train_1.csv").read_text().replace("t,q1,q2,tau1,tau2", "t,A,B,C,D", 1)
    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs" / "run.csv").write_text(text)
    (tmp_path / "theirs" / "exoid.toml").write_text(
        '[[recordings]]\nheader = ["t", "A", "B", "C", "D"]\n'
        'columns = { q1 = "A", q2 = "B", tau1 = "C", tau2 = "D" }\n'
    )  # fmt: skip
    with zipfile.ZipFile(tmp_path / "runs.zip", "w") as archive:
        archive.write(DATA / "train_2.csv", "deep/run2.csv")
    space = workspace(tmp_path / "theirs" / "run.csv", tmp_path / "runs.zip" / "deep" / "run2.csv")
    space.given[:] = [read_given(one, tmp_path / "mappings") for one in space.given]
    kept = save(space, tmp_path / "kept")
    assert contents(kept)["run2.csv"] == (DATA / "train_2.csv").read_text()
    again = workspace()
    reopen(again, kept)
    read = [read_given(one, tmp_path / "no mappings") for one in again.given]
    assert [one.error for one in read] == [None, None]


def test_a_copy_with_a_long_name_is_dropped_under_its_own(runs, workspace, tmp_path):
    path = tmp_path / f"{'long' * 40}.csv"
    path.write_text(runs["a"].read_text())
    kept = save(workspace(path), tmp_path / "kept")
    again = workspace()
    for file in files(kept):
        shutil.copy(kept / file, again.session_place(1, f"kept/{file}" if "/" in file else file))
    reopen(again, again.place / "session-1", kept=False)
    assert again.given[0].path.read_text() == runs["a"].read_text()


def test_sessions_as_they_were_saved_before_still_open(runs, workspace, tmp_path):
    """Recordings were numbered, and the model that everything starts from was base.toml."""
    space = workspace(runs["a"], runs["b"])
    kept = save(space, tmp_path / "kept")
    told = json.loads((kept / "session.json").read_text())
    for k, one in enumerate(told["recordings"], start=1):
        shutil.copy(kept / one["file"], kept / f"recordings/{k:02d}-run.csv")
        one["file"] = f"recordings/{k:02d}-run.csv"
    space.close()
    (kept / "session.json").write_text(json.dumps(told))
    again = workspace()
    reopen(again, kept)
    save(again, kept)
    assert contents(kept) == {"run.csv": runs["a"].read_text(), "run (2).csv": runs["b"].read_text()}
    again.remove_file(1)
    save(again, kept)
    assert files(kept / "recordings") == ["02-run.csv"] and "01-run.csv" in files(tmp_path / "kept-closed")


def test_a_recording_that_was_altered_in_the_folder_is_noticed(runs, workspace, tmp_path):
    kept = save(workspace(runs["a"]), tmp_path / "kept")
    (path,) = (kept / "recordings").iterdir()
    path.write_text("other")
    with pytest.raises(RecordingError, match="not what was kept"):
        reopen(workspace(), kept)


# -- one process at a time -----------------------------------------------------------------------------------------


HOLD = """
import sys, time
from pathlib import Path
from exoid.apps.page.folder import SessionFolder
SessionFolder(Path(sys.argv[1]))
print("held", flush=True)
time.sleep(600)
"""


@pytest.fixture
def holder(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, tmp_path / "kept"], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )
    yield process
    process.kill()
    process.wait()
    process.stdout.close()


@pytest.mark.slow
def test_another_process_has_it(runs, workspace, tmp_path, holder, capsys):
    pytest.importorskip("fcntl")
    assert holder.stdout.readline() == "held\n"
    space = workspace(runs["a"])
    for ask in (save, reopen, keep_in):
        with pytest.raises(RecordingError, match="another exoid has this session open"):
            ask(space, tmp_path / "kept")
    assert main(["open", str(runs["a"]), "--out", str(tmp_path / "kept"), "--no-browser"]) == 2
    assert "another exoid" in capsys.readouterr().err
    holder.kill()
    holder.wait()
    save(space, tmp_path / "kept")


def test_a_session_that_somebody_else_changed_is_not_written_over(runs, workspace, tmp_path):
    """Where the file system knows no locks."""
    first, second = workspace(runs["a"]), workspace(runs["b"])
    kept = save(first, tmp_path / "kept")
    reopen(second, kept)
    second.add_file(runs["b"], "run.csv")
    save(second, kept)
    before = (kept / "session.json").read_text()
    with pytest.raises(RecordingError, match="changed by somebody else"):
        save(first, kept)
    assert (kept / "session.json").read_text() == before
    first.keeping.changed()
    first.keeping.write()
    assert first.keeping.unkept is not None and not first.keeping.kept


def test_nothing_is_left_of_a_folder_in_which_nothing_was_kept(workspace, tmp_path):
    space = workspace()
    keep_in(space, tmp_path / "kept")
    assert (tmp_path / "kept").is_dir()
    space.close()
    assert not (tmp_path / "kept").exists()


# -- at every moment -----------------------------------------------------------------------------------------------


def killed_at(count, work):
    """Do `work` in a copy of this process that ends, as if killed, at its change of the disk number `count`; whether it
    came to its end.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        child = os.fork()
    if not child:
        calls = iter(range(10_000))

        def ending(done):
            def call(*args, **options):
                if next(calls) == count:
                    os._exit(9)
                return done(*args, **options)

            return call

        for name in ("replace", "rename", "link", "unlink", "fsync"):
            setattr(os, name, ending(getattr(os, name)))
        try:
            work()
        finally:
            os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="only where processes are copied")
@pytest.mark.parametrize("links", [True, False], ids=["", "without hard links"])
def test_it_is_whole_whenever_the_process_is_killed(links, runs, workspace, tmp_path, monkeypatch):
    if not links:
        monkeypatch.setattr(os, "link", _no_links)
    old, new = {"run.csv": runs["a"].read_text()}, {"run.csv": runs["b"].read_text()}
    seen = []
    for count in range(100):
        kept = tmp_path / f"kept{count}"
        space = workspace(runs["a"])
        save(space, kept)
        space.close()

        def work(kept=kept):
            space = Workspace(tmp_path / "mappings")
            space.add_file(runs["b"], "run.csv", VERIFY)
            save(space, kept)

        ended = killed_at(count, work)
        found = contents(kept)
        assert found in (old, new)
        seen.append(found)
        again = workspace()
        reopen(again, kept)
        save(again, kept)
        assert contents(kept) == found and len(files(kept / "recordings")) == 1
        assert not list(kept.rglob(f"{PREFIX}*"))
        again.close()
        if ended:
            break
    assert ended and old in seen and new in seen


def _no_links(*_args, **_options):
    raise PermissionError


# -- nothing outside -----------------------------------------------------------------------------------------------


@pytest.fixture
def elsewhere(tmp_path):
    path = tmp_path / "precious"
    path.write_text("precious")
    yield path
    assert path.read_text() == "precious"


def plant(how, place, target):
    place.parent.mkdir(parents=True, exist_ok=True)
    if place.is_dir() and not place.is_symlink():
        shutil.rmtree(place)
    place.unlink(missing_ok=True)
    if how == "pipe":
        os.mkfifo(place)
    else:
        place.symlink_to({"link": target, "dangling": target.with_name("made"), "up": "../precious"}[how])


NAMES = ("model.toml", "session.json", ".lock", "report.html")


@pytest.mark.parametrize("how", ["link", "dangling", "up", "pipe"])
@pytest.mark.parametrize("name", [*NAMES, "recordings"])
def test_a_folder_of_somebody_else_writes_nowhere_else(how, name, runs, workspace, tmp_path, elsewhere, capsys):
    kept = save(workspace(runs["a"]), tmp_path / "kept")
    module._HELD.clear()
    plant(how, kept / name, elsewhere)
    space = workspace(runs["b"])
    for ask in (reopen, save):
        try:
            ask(space, kept)
        except RecordingError as error:
            assert error.remedy
            assert str(kept) in str(error)
    space.keeping.changed()
    space.keeping.write()
    assert not (tmp_path / "made").exists()


@pytest.mark.parametrize("how", ["link", "dangling", "pipe"])
def test_nor_do_places_of_copies(how, runs, workspace, tmp_path, elsewhere):
    kept = save(workspace(runs["a"]), tmp_path / "kept")
    digest = sha256(runs["b"].read_text())[:32]
    plant(how, kept / "recordings" / f"run-{digest}.csv", elsewhere)
    plant(how, kept / "recordings" / "01-run.csv.part", elsewhere)
    with pytest.raises(RecordingError, match=r"link|ordinary file"):
        save(workspace(runs["b"]), kept)
    assert not (tmp_path / "made").exists()


def test_a_recording_that_is_a_link_is_not_read(runs, workspace, tmp_path):
    kept = save(workspace(runs["a"]), tmp_path / "kept")
    (path,) = (kept / "recordings").iterdir()
    path.unlink()
    path.symlink_to(runs["a"])
    with pytest.raises(RecordingError, match="is a link"):
        reopen(workspace(), kept)


def test_the_folder_for_closed_recordings_is_no_link(runs, workspace, tmp_path):
    kept = save(workspace(runs["a"], runs["b"]), tmp_path / "kept")
    (tmp_path / "other").mkdir()
    (tmp_path / "kept-closed").symlink_to(tmp_path / "other")
    again = workspace()
    reopen(again, kept)
    again.remove_file(1)
    with pytest.raises(RecordingError, match="is a link"):
        save(again, kept)
    assert not list((tmp_path / "other").iterdir())


def test_a_folder_that_may_not_be_written_to_is_opened_all_the_same(runs, workspace, tmp_path, monkeypatch):
    kept = save(workspace(runs["a"]), tmp_path / "kept")
    module._HELD.clear()

    def refused(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(module, "FolderLock", refused)
    again = workspace()
    reopen(again, kept)
    assert [one.name for one in again.given] == ["run.csv"] and "Permission denied" in str(again.keeping.unkept)


def test_the_lock_and_the_copies_are_the_users_own(runs, workspace, tmp_path):
    kept = save(workspace(runs["a"]), tmp_path / "kept")
    for path in kept.rglob("*"):
        assert path.is_dir() or stat.S_ISREG(path.lstat().st_mode)
    assert isinstance(SessionFolder(kept), SessionFolder)
