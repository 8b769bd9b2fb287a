"""What lies in the cache is run: it is used only where nobody else could have put it there, and nothing in it waits."""

import json
import os
import shutil
import stat
import warnings
from pathlib import Path

import pytest

from exoid.ground import cache
from exoid.ground.cache import cache_folder, distrust, read_trusted, write_trusted
from exoid.ground.files import sha256
from exoid.symbolic.codegen.cache import LIBRARY, RECORD, SEAL, GeneratedC, load_library
from exoid.symbolic.codegen.compiler import EXACT, find_compiler

posix = pytest.mark.skipif(os.name != "posix", reason="access rights of POSIX")
compiles = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
root = pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="only the superuser gives files away")


def one(text="double answer(void) { return 42.0; }"):
    return GeneratedC(text, EXACT, {"a": 1})


@pytest.fixture
def folder(tmp_path, monkeypatch):
    path = tmp_path / "cache"
    monkeypatch.setenv("EXOID_CACHE", str(path))
    cache._say_once.cache_clear()
    return path


def entry_of(folder) -> Path:
    (found,) = folder.glob("kind-*")
    return found


@posix
@pytest.mark.parametrize("mode", [0o777, 0o770, 0o722, 0o1777])
def test_a_folder_others_may_write_to_is_not_used(folder, mode):
    folder.mkdir()
    folder.chmod(mode)
    with pytest.warns(UserWarning, match="others may write"):
        found = cache_folder()
    assert found != folder and stat.S_IMODE(found.stat().st_mode) == 0o700


@posix
def test_nor_one_that_could_be_exchanged(tmp_path, monkeypatch):
    above = tmp_path / "above"
    above.mkdir()
    cache._say_once.cache_clear()
    monkeypatch.setenv("EXOID_CACHE", str(above / "cache"))
    above.chmod(0o777)
    with pytest.warns(UserWarning, match="others may write"):
        assert cache_folder() != above / "cache"
    above.chmod(0o1777)  # as /tmp: everybody may write, nobody may rename
    assert cache_folder() == above / "cache"
    (tmp_path / "link").symlink_to(above / "elsewhere")
    (above / "elsewhere").mkdir(mode=0o700)
    monkeypatch.setenv("EXOID_CACHE", str(tmp_path / "link"))
    assert cache_folder() == tmp_path / "link"
    (above / "elsewhere").chmod(0o777)
    with pytest.warns(UserWarning, match="others may write"):
        assert cache_folder() != tmp_path / "link"


@root
def test_nor_one_of_somebody_else(folder, tmp_path, monkeypatch):
    folder.mkdir(mode=0o700)
    os.chown(folder, 12345, 12345)
    with pytest.warns(UserWarning, match="somebody else"):
        assert cache_folder() != folder
    os.chown(folder, 0, 0)
    assert cache_folder() == folder
    os.chown(tmp_path, 12345, 12345)
    cache._say_once.cache_clear()
    with pytest.warns(UserWarning, match="somebody else"):
        assert cache_folder() != folder


def test_what_cannot_be_a_folder_is_no_traceback(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("x")
    (tmp_path / "loop").symlink_to("loop")
    for name in ("file", "file/below", "loop", "loop/below", "x" * 300):
        monkeypatch.setenv("EXOID_CACHE", str(tmp_path / name))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            assert cache_folder().is_dir()


@pytest.mark.slow
@posix
@compiles
@pytest.mark.parametrize("change", [
    "other mode of the entry", "other mode of the library", "link", "pipe", "device", "huge", "entry is a pipe",
    "entry is a file", "entry is a link", "pipe for a seal", "planted", "no seal", "seal is a list",
])  # fmt: skip
def test_an_entry_somebody_could_have_made_is_built_again(folder, change, tmp_path, monkeypatch):
    load_library("kind", "x", EXACT, one, ["answer"])
    entry = entry_of(folder)
    asked = []

    def again():
        asked.append(1)
        return one()

    assert load_library("kind", "x", EXACT, again, ["answer"]) is not None and not asked
    library, seal = entry / LIBRARY, entry / SEAL
    if change == "other mode of the entry":
        entry.chmod(0o777)
    elif change == "other mode of the library":
        library.chmod(0o666)
    elif change == "link":
        shutil.copy(library, tmp_path / "planted.so")
        library.unlink()
        library.symlink_to(tmp_path / "planted.so")
    elif change in ("pipe", "pipe for a seal"):
        place = library if change == "pipe" else seal
        place.unlink()
        os.mkfifo(place)
    elif change == "device":
        library.unlink()
        library.symlink_to("/dev/zero")
    elif change == "huge":
        os.truncate(library, 10**12)
    elif change.startswith("entry is"):
        shutil.rmtree(entry)
        if change.endswith("pipe"):
            os.mkfifo(entry)
        elif change.endswith("file"):
            entry.write_text("x")
        else:
            entry.symlink_to("/")
    elif change == "planted":
        library.unlink()  # this process still has the old one mapped
        library.write_bytes(b"\x7fELF")
        seal.write_text(json.dumps({LIBRARY: sha256(b"\x7fELF"), RECORD: json.loads(seal.read_text())[RECORD]}))
        library.chmod(0o622)
    elif change == "no seal":
        seal.unlink()
    else:
        seal.write_text("[]")
    found = load_library("kind", "x", EXACT, again, ["answer"])
    assert asked == [1] and found is not None and not distrust(entry_of(folder))
    assert Path("/etc").is_dir()


@root
@compiles
def test_a_library_of_somebody_else_is_not_loaded(folder):
    load_library("kind", "x", EXACT, one, ["answer"])
    for name in (LIBRARY, RECORD, SEAL, "."):
        os.chown(entry_of(folder) / name, 12345, 12345)
        asked = []
        load_library("kind", "x", EXACT, lambda asked=asked: asked.append(1) or one(), ["answer"])
        assert asked == [1], name


@compiles
@posix
def test_the_umask_does_not_matter(tmp_path, monkeypatch):
    """Nor for the folders above the cache: in ~/.cache that others may write to, it would be distrusted for ever."""
    folder = tmp_path / "home" / ".cache" / "exoid"
    monkeypatch.setenv("EXOID_CACHE", str(folder))
    before = os.umask(0)
    try:
        assert cache_folder() == folder
        write_trusted(folder / "record", "text")
        assert read_trusted(folder / "record", 64) == b"text"
        assert load_library("kind", "x", EXACT, one, ["answer"]) is not None
        assert load_library("kind", "x", EXACT, pytest.fail, ["answer"]) is not None
    finally:
        os.umask(before)
    assert all(stat.S_IMODE(part.stat().st_mode) == 0o700 for part in (folder, folder.parent, folder.parent.parent))


@posix
def test_a_note_in_the_cache_is_read_only_where_it_is_an_ordinary_file(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "zero").symlink_to("/dev/zero")
    (tmp_path / "large").write_text("x" * 100)
    (tmp_path / "open").write_text("x")
    (tmp_path / "open").chmod(0o666)
    for name in ("pipe", "zero", "large", "open", "nowhere"):
        with pytest.raises(OSError, match=r"."):
            read_trusted(tmp_path / name, 64)
