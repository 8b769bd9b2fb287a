"""The truth about blind recordings, in a file of its own that a glance does not give away.

The seal is JSON: a note for whoever finds it, SHA-256 of each recording it belongs to, and the truth, packed
so that it is not read by accident (it is no secret: `exoid reveal` opens it), with its own SHA-256 so that it
is not altered by accident either.
"""

from __future__ import annotations

import base64
import hashlib
import json
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from exoid.ground.delivery import where
from exoid.ground.errors import ExoidError, refused
from exoid.ground.files import sha256_file, write_whole
from exoid.ground.inputs import read_input
from exoid.ground.plain import SPOILT, AsJson

NOTE = "Sealed truth of blind recordings. Diagnose first; then: exoid reveal"
KIND = "exoid seal 1"
LARGEST = 4_000_000
"""Bytes. A truth has a few hundred; anything bigger is not a seal of ours, and is not unpacked."""

EVEN = 1200
"""Characters that truth and filler have together: a short seal would tell that little or nothing is hidden."""

DAMAGE = (*SPOILT, zlib.error)
"""What unpacking a file raises that is no seal."""


class SealError(ExoidError):
    """A seal that cannot be read, was altered, or does not belong to these recordings."""


@dataclass(frozen=True)
class HiddenTruth(AsJson):
    """One hidden effect: `id`, `joint` (None: both) and its `values` by name."""

    id: str
    joint: str | None
    values: dict[str, float]

    @property
    def term(self) -> str:
        """The term's name in a model, `stribeck:knee`."""
        return f"{self.id}:{self.joint}" if self.joint else self.id


@dataclass(frozen=True)
class Truth(AsJson):
    """The truth of the bench: the leg, its `base` parameters (8,), the hidden effects, and the `seed` of the runs."""

    leg: str
    base: tuple[float, ...]
    effects: tuple[HiddenTruth, ...]
    seed: int

    @property
    def terms(self) -> tuple[str, ...]:
        """Names of the hidden terms, () when nothing is hidden."""
        return tuple(effect.term for effect in self.effects)


@dataclass(frozen=True)
class OpenedSeal:
    """A `truth` and the recordings it belongs to: {file name: SHA-256}."""

    truth: Truth
    recordings: Mapping[str, str]


def write_seal(path: str | Path, truth: Truth, recordings: Sequence[str | Path]) -> Path:
    """Seal `truth` at `path` for the recording files given, whole or not at all, and return the path.

    Raises SealError when a recording is missing or the file cannot be written.
    """
    target = Path(path)
    with refused(SealError, "a recording cannot be read: {}", path):
        sums = {Path(file).name: sha256_file(where(file)) for file in recordings}
    content = json.dumps(truth.to_json(), sort_keys=True, ensure_ascii=False).encode()
    document = {
        "kind": KIND,
        "note": NOTE,
        "recordings": sums,
        "sha256": hashlib.sha256(content).hexdigest(),
        "truth": (packed := base64.b85encode(zlib.compress(content, 9)).decode("ascii")),
        "filler": _filler(content, -len(packed) % EVEN),
    }
    remedy = "check that the folder exists and may be written to"
    with refused(SealError, "the seal cannot be written ({})", target, remedy):
        return write_whole(target, json.dumps(document, indent=1, ensure_ascii=False) + "\n")


def _filler(content: bytes, count: int) -> str:
    """Return `count` characters that look like packed truth; the same for the same truth."""
    return base64.b85encode(hashlib.shake_256(content).digest(count)).decode("ascii")[:count]


def open_seal(path: str | Path, recordings: Sequence[str | Path] = ()) -> OpenedSeal:
    """Return the contents of the seal at `path`.

    With `recordings`, each must be one of those sealed, byte for byte (files may have been renamed). Raises
    SealError when the file is missing, is no seal, was altered, or belongs to other recordings.
    """
    place = str(path)
    with refused(SealError, "the seal cannot be read ({})", place):
        raw = read_input(path, LARGEST)
    remedy = "give the .seal file that exoid simulate wrote next to the recordings"
    with refused(SealError, "this is not a seal of exoid, or it is damaged", place, remedy, DAMAGE):
        document = json.loads(raw.decode("utf-8"))
        if document["kind"] != KIND:
            raise KeyError("kind")
        unpack = zlib.decompressobj()
        content = unpack.decompress(base64.b85decode(document["truth"]), LARGEST)
        if not unpack.eof:
            raise ValueError("packed truth is cut short or too large")
        whole = hashlib.sha256(content).hexdigest() == document["sha256"]
        opened = OpenedSeal(_truth(json.loads(content)), dict(document["recordings"]))
    if not whole:
        raise SealError("the seal was altered after it was written", where=place, remedy="simulate again")
    for file in recordings:
        _check_belongs(Path(file), opened, place)
    return opened


def _check_belongs(file: Path, opened: OpenedSeal, place: str) -> None:
    with refused(SealError, "a recording cannot be read ({})", file):
        found = sha256_file(file)
    if found not in opened.recordings.values():
        remedy = f"it belongs to {', '.join(sorted(opened.recordings))}, unchanged since the simulation"
        raise SealError(f"{file.name} is not one of the recordings of this seal", where=place, remedy=remedy)


def _truth(fields: Mapping[str, Any]) -> Truth:
    effects = tuple(
        HiddenTruth(str(entry["id"]), entry["joint"], {key: float(value) for key, value in entry["values"].items()})
        for entry in fields["effects"]
    )
    return Truth(str(fields["leg"]), tuple(float(x) for x in fields["base"]), effects, int(fields["seed"]))
