"""Places of recordings: files, folders, patterns, archives; what of them is read, and under which name.

A folder means the recordings in it (not in folders below), a pattern what it matches, a ZIP archive its members, which
are named `archive.zip/run1.csv`. A folder that ROS 2 wrote (with metadata.yaml) is one recording.
"""

from __future__ import annotations

import glob
import hashlib
import shutil
import stat
import tempfile
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache
from pathlib import Path, PurePosixPath
from types import ModuleType
from typing import IO

from exoid.ground.errors import NO_NUMBERS, RecordingError, refused
from exoid.ground.files import MODEL_FILES
from exoid.ground.folder import modules_in
from exoid.ground.inputs import open_input
from exoid.ground.suggest import nearest
from exoid.measurement.reading import formats

MOST_FILES = 1000
MOST_BYTES = 8_000_000_000
"""A small archive can unpack to any size."""
LOOKED_AT = 2_000_000
"""Bytes of a file in a folder or an archive of which its format says whether it is a recording."""
BAG = "metadata.yaml"
DAMAGE = (zipfile.BadZipFile, NotImplementedError, RuntimeError, ValueError, EOFError, OSError, zlib.error)
"""What reading an archive raises that is none, or cut off."""
NO_PATH = (OSError, ValueError, RuntimeError)
"""What looking at a path raises; before Python 3.13 a loop of links is a RuntimeError."""
OTHERS = frozenset({"readme.txt", "license.txt", "requirements.txt", "notes.txt", "log.txt"})
"""Files of a folder that are texts about the recordings; one that is named is read all the same."""
NO_MEMBERS = "the archive holds no recordings"
OTHER_TYPES = "of other types"


@cache
def find_formats() -> tuple[ModuleType, ...]:
    """Return every module in `exoid/measurement/reading/formats/`."""
    return tuple(modules_in(formats).values())


def suffixes() -> tuple[str, ...]:
    """Return the suffixes of all formats."""
    return tuple(suffix for module in find_formats() for suffix in module.SUFFIXES)


def expand(paths: str | Path | Sequence[str | Path]) -> list[str]:
    """Return the path of every single recording that `paths` (files, folders, patterns, archives; one or several) mean,
    in order, as `find_files` finds them.
    """
    return find_files(paths)[0]


def find_files(paths: str | Path | Sequence[str | Path]) -> tuple[list[str], dict[str, str]]:
    """Return the path of every single recording that `paths` mean, and {path: kind} of what lies beside them.

    What is a file is returned as it is, whether it can be read or not. RecordingError for a folder, a pattern or an
    archive without recordings, and, naming all of them, for files that are not there.
    """
    found: list[str] = []
    others: dict[str, str] = {}
    missing: list[str] = []
    for given in map(str, [paths] if isinstance(paths, (str, Path)) else paths):
        try:
            path = Path(given)
            if path.is_dir() and not is_bag(path):
                found += _chosen(_in_folder(path), given, "the folder holds no recordings", others)
            elif path.suffix.lower() == ".zip" and path.is_file():
                inside = {f"{given}/{member}": kind for member, kind in _all_members(path).items()}
                found += _chosen(inside, given, NO_MEMBERS, others)
            elif not path.exists() and glob.has_magic(given):
                found += _chosen(_matching(given), given, "no file matches this pattern", others)
            else:
                found.append(given)
                if not path.exists() and _in_archive(path) is None:
                    missing.append(given)
        except (OSError, ValueError, RuntimeError):
            found.append(given)  # refused with its reason when it is read
    if len(missing) > 1:
        raise RecordingError(
            f"{len(missing)} files do not exist: {', '.join(missing[:8])}" + (" and more" if len(missing) > 8 else ""),
            where=missing[0],
            remedy="check the paths",
        )
    return found, others


def _in_folder(folder: Path) -> dict[str, str]:
    """Return {path: kind of other file, "" for a recording} of what lies in a folder, models and mappings apart."""
    inside = sorted(path for path in folder.iterdir() if not path.name.startswith("."))
    return {
        str(item): "" if is_bag(item) else kind_of_file(item)
        for item in inside
        if is_bag(item) or (item.is_file() and item.suffix.lower() not in MODEL_FILES)
    }


def kind_of_file(file: Path) -> str:
    """Return the kind of a file of a folder that is no recording, "" for one: not notes or settings beside them."""
    if file.suffix.lower() not in suffixes():
        return OTHER_TYPES
    if file.name.lower() in OTHERS:
        return NO_NUMBERS
    try:
        with open_input(file, remember=False) as stream:
            return "" if _holds_recording(file.suffix, file.stat().st_size, stream) else NO_NUMBERS
    except OSError:
        return ""  # refused with its reason when it is read


def _holds_recording(suffix: str, size: int, stream: IO[bytes]) -> bool:
    """True if a format in which much else is written finds a recording; what is too long to look at counts as one."""
    chosen = next((item for item in find_formats() if suffix.lower() in item.SUFFIXES), None)
    if chosen is None or not hasattr(chosen, "holds_recording") or size > LOOKED_AT:
        return True
    return bool(chosen.holds_recording(stream.read(LOOKED_AT)))


def _matching(pattern: str) -> dict[str, str]:
    inside = sorted(path for path in glob.iglob(pattern, recursive=True) if Path(path).is_file() or is_bag(Path(path)))
    return {
        path: "" if is_bag(Path(path)) or Path(path).suffix.lower() in suffixes() else OTHER_TYPES
        for path in inside
        if Path(path).suffix.lower() not in MODEL_FILES
    }


def _chosen(inside: dict[str, str], where: str, none: str, others: dict[str, str]) -> list[str]:
    """Return the recordings among {path: kind}, and put what else is there into `others`."""
    found = [path for path, kind in inside.items() if not kind]
    if not found:
        raise RecordingError(none, where=where, remedy=f"recordings end in {', '.join(suffixes())}")
    if len(found) > MOST_FILES:
        what = f"{len(found)} recordings at a time"
        raise RecordingError(what, where=where, remedy=f"name {MOST_FILES} of them or fewer")
    others |= {path: kind for path, kind in inside.items() if kind}
    return found


def is_bag(path: Path) -> bool:
    """True if `path` is a folder that ROS 2 recorded into."""
    return path.is_dir() and (path / BAG).is_file()


def members(archive: Path) -> list[str]:
    """Return the names of the recordings in a ZIP archive, sorted."""
    return _chosen(_all_members(archive), str(archive), NO_MEMBERS, {})


def _all_members(archive: Path) -> dict[str, str]:
    """Return {name: kind of other file, "" for a recording} of what lies in a ZIP archive, sorted."""
    with _archive(archive, archive) as content:
        inside = {entry.filename: entry for entry in content.infolist() if not entry.is_dir()}
        return {
            name: _kind_of_member(content, inside[name])
            for name in sorted(inside)
            if not PurePosixPath(name).name.startswith((".", "__MACOSX"))
            and not name.startswith("__MACOSX")
            and PurePosixPath(name).suffix.lower() not in MODEL_FILES
        }


def _kind_of_member(content: zipfile.ZipFile, entry: zipfile.ZipInfo) -> str:
    name = PurePosixPath(entry.filename)
    if name.suffix.lower() not in suffixes():
        return OTHER_TYPES
    if name.name.lower() in OTHERS:
        return NO_NUMBERS
    return "" if entry.flag_bits & 1 or _member_is_meant(content, entry) else NO_NUMBERS


def _member_is_meant(content: zipfile.ZipFile, entry: zipfile.ZipInfo) -> bool:
    with content.open(entry) as stream:
        return _holds_recording(PurePosixPath(entry.filename).suffix, entry.file_size, stream)


@contextmanager
def _archive(path: Path, where: object) -> Iterator[zipfile.ZipFile]:
    """Yield an open ZIP archive; RecordingError where it is damaged."""
    damaged = refused(RecordingError, "the ZIP archive is damaged ({})", where, "copy it again", DAMAGE)
    with damaged, zipfile.ZipFile(path) as content:
        yield content


def _in_archive(path: Path) -> tuple[Path, str] | None:
    """Return (archive, member) where `path` goes on behind a ZIP archive."""
    for parent in path.parents:
        if parent.suffix.lower() == ".zip" and parent.is_file():
            return parent, path.relative_to(parent).as_posix()
    return None


def folder_of(path: Path) -> Path:
    """Return the folder in which a recording lies; of a member of an archive, that of the archive."""
    inside = None if path.exists() else _in_archive(path)
    return (path if inside is None else inside[0]).parent


@contextmanager
def opened(path: Path) -> Iterator[Path]:
    """Yield an ordinary file (or a ROS 2 folder) with the content of `path`, which may lie in an archive.

    RecordingError when there is none, or when it may not be read.
    """
    with refused(RecordingError, "this is not a path of a file", str(path)[:200], "check the spelling", NO_PATH):
        inside = None if path.exists() or path.is_symlink() else _in_archive(path)
    if inside is None:
        _check(path)
        if path.suffix.lower() != ".zip":
            yield path
            return
        found = members(path)
        if len(found) > 1:
            what = f"the archive holds {len(found)} recordings: {', '.join(found[:8])}"
            remedy = f"name one: {path}/{found[0]}, or read them all with read_recordings"
            raise RecordingError(what, where=str(path), remedy=remedy)
        inside = path, found[0]
    archive, member = inside
    with tempfile.TemporaryDirectory(prefix="exoid-") as folder:
        target = Path(folder) / f"member{PurePosixPath(member).suffix.lower()}"
        _unpack(archive, member, target, str(path))
        yield target


def _unpack(archive: Path, member: str, target: Path, where: str) -> None:
    with _archive(archive, where) as content:
        entry = next((item for item in content.infolist() if item.filename == member), None)
        if entry is None:
            held = ", ".join(members(archive)[:10])
            raise RecordingError("the archive has no such member", where=where, remedy=f"it holds {held}")
        if entry.file_size > min(MOST_BYTES, shutil.disk_usage(target.parent).free // 2):
            what = f"the member unpacks to {entry.file_size / 1e9:.3g} GB"
            raise RecordingError(what, where=where, remedy="unpack it by hand")
        if entry.flag_bits & 1:
            raise RecordingError("the archive is encrypted", where=where, remedy="unpack it by hand")
        with content.open(entry) as stream, target.open("wb") as out:
            shutil.copyfileobj(stream, out, 1 << 20)


def _check(path: Path) -> None:
    """Refuse what is not a readable file."""
    with refused(RecordingError, "the file cannot be reached ({})", str(path)[:200], "check the path", NO_PATH):
        if not path.exists():
            if path.is_symlink():
                what = "this is a link that leads nowhere"
                raise RecordingError(what, where=str(path), remedy="give the path of the file itself")
            raise RecordingError("there is no such file", where=str(path), remedy=_nearby(path))
        kind = path.stat()
    if stat.S_ISDIR(kind.st_mode) and not is_bag(path):
        remedy = "name one of its files; compare, diagnose, discover and read_recordings take the whole folder"
        raise RecordingError("this is a folder, not a recording", where=str(path), remedy=remedy)
    if not (stat.S_ISREG(kind.st_mode) or is_bag(path)):
        raise RecordingError("this is not an ordinary file", where=str(path), remedy="give the path of a file on disk")


@contextmanager
def noting() -> Iterator[dict[str, str]]:
    """Yield a dictionary that takes the SHA-256 of every file that is read inside, by its path."""
    noted: dict[str, str] = {}
    token = _NOTED.set(noted)
    try:
        yield noted
    finally:
        _NOTED.reset(token)


_NOTED: ContextVar[dict[str, str] | None] = ContextVar("noted", default=None)


def digest(path: Path) -> str:
    """Return the SHA-256 of the file in hex, of a ROS 2 folder that of its files in order of their names."""
    total = hashlib.sha256()
    files = sorted(entry for entry in path.iterdir() if entry.is_file()) if path.is_dir() else [path]
    with refused(RecordingError, "the file cannot be read ({})", path, "check that you may read it"):
        for file in files:
            with open_input(file) as stream:
                hashlib.file_digest(stream, lambda: total)
    if (noted := _NOTED.get()) is not None:
        noted[str(path)] = total.hexdigest()
    return total.hexdigest()


def _nearby(path: Path) -> str:
    """Return advice that names a file of a similar name in the same folder, if there is one."""
    if not path.parent.is_dir():
        return f"the folder {path.parent} does not exist either"
    try:
        close = nearest(path.name, (entry.name for entry in path.parent.iterdir()), 1, cutoff=0.75)
    except OSError:
        close = []
    return f"did you mean {path.parent / close[0]}?" if close else "check the path"
