"""Results on disk: whole or not at all, and refused early when the place cannot be written."""

from __future__ import annotations

import errno
import json
import os
import re
import tempfile
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from exoid.ground.delivery import Delivery, current
from exoid.ground.errors import ExoidError, refused
from exoid.ground.files import write_whole
from exoid.ground.inputs import read_input
from exoid.ground.inside import refuse_links
from exoid.ground.ours import OTHERS, says_so
from exoid.ground.plain import plain

RESULTS = ("result.json", "report.html")
"""What a command with --out writes there at its end; what else it writes is looked at when it is written."""
LARGEST_JSON = 100_000_000
"""Bytes of a result that is read back; those of exoid have at most a few million."""


class OutputError(ExoidError):
    """A file or folder that cannot be written."""


def json_text(payload: Any) -> str:
    """Return `payload` as strict JSON text that ends with a line feed."""
    text = json.dumps(plain(payload), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    return _UNSEEN.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


_UNSEEN = re.compile("[\\x7f-\\x9f\\u200e\\u200f\\u2028-\\u202e\\u2066-\\u2069\\ud800-\\udfff]")
"""What a terminal obeys, or UTF-8 cannot say (half of a pair, from a file name in another encoding)."""


def read_json(path: str | Path) -> Any:
    """Return the content of a JSON file; raises OutputError where it cannot be read or is no JSON."""
    with (
        refused(OutputError, "is not JSON", path, "give a file that --json wrote", (ValueError, RecursionError)),
        refused(OutputError, "cannot be read: {}", path, "check the path"),
    ):
        return json.loads(read_input(path, LARGEST_JSON).decode("utf-8-sig"))


def write_text(path: str | Path, text: str) -> Path:
    """Write `text` as UTF-8 to `path`, whole or not at all; raises OutputError."""
    return write_bytes(path, text.encode("utf-8", "backslashreplace"))


def write_bytes(path: str | Path, content: bytes) -> Path:
    """Write `content` to `path`, whole or not at all; raises OutputError."""
    with _writing(path):
        return write_whole(path, content)


def make_folder(path: str | Path) -> Path:
    """Return the folder `path`, made with its parents if needed and writable; raises OutputError."""
    folder, delivery = Path(path), current() or Delivery()
    with _writing(path):
        if inside := delivery.fills(folder):
            refuse_links(folder, inside)
        delivery.fill(folder)
        delivery.make_folder(folder)
        with tempfile.TemporaryFile(dir=folder):
            return folder


def check_folder(path: str | Path) -> None:
    """Refuse a folder that could not be made or written to, without making it; raises OutputError."""
    place, delivery = Path(path).absolute(), current() or Delivery()
    delivery.fill(place)
    with _writing(path):
        for name in RESULTS:
            delivery.keep_others(place / name)
        while not place.exists() and place != place.parent:
            place = place.parent
        with tempfile.TemporaryFile(dir=place):
            return


def default_folder(name: str) -> str:
    """Return the folder `name` of the current folder, in which results go where none is named; OutputError for a link,
    which nobody has named.
    """
    if os.path.islink(name):
        raise OutputError("is a link, and was not named", where=name, remedy="name a folder with --out")
    return name


def check_target(path: str, ours: Callable[[bytes], bool] | None = None) -> None:
    """Refuse a place that cannot be written, or holds something else, before the work starts, not after it.

    `ours(content)` says whether what is there is of the kind that would take its place.
    """
    with _writing(path):
        if Path(path).is_dir():
            raise OutputError("this is a folder", where=path, remedy="name a file, or - for standard output")
        delivery = current() or Delivery()
        delivery.named.add(os.path.abspath(path))
        place = delivery.place(Path(path))
        if place.is_file() and ours is not None and not ours(_beginning(place)):
            what = "there is a file of another kind, and it would be lost"
            raise OutputError(what, where=path, remedy="choose another name, or remove that file first")
        if place.is_file() or not place.exists():
            with tempfile.TemporaryFile(dir=place.parent):
                return


def check_result(path: str | Path) -> None:
    """Refuse a file of --out, or one that nobody named, where somebody else's file is; raises OutputError."""
    place = Path(path)
    with _writing(path):
        delivery = current() or Delivery()
        if place.exists() and not says_so(place):
            raise OSError(errno.EEXIST, OTHERS.format(place.name), str(path))
        delivery.place(place)


def _beginning(path: Path) -> bytes:
    with path.open("rb") as stream:
        return stream.read(4096)


def _writing(target: str | Path) -> AbstractContextManager[None]:
    """Refuse what cannot be written inside."""
    remedy = "check that the folder exists, that you may write there and that the disk is not full, or choose another"
    return refused(OutputError, "cannot be written ({})", target, remedy)
