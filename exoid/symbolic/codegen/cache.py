"""Compiled C libraries, kept in the user's cache under the hash of everything they depend on.

An entry is a folder with the library, a JSON record and the hash of both. It is made under another name and
moved into place in one step, so that two processes may build the same entry at once. An entry whose content
does not match its hash is thrown away and built again.
"""

from __future__ import annotations

import ctypes
import json
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from exoid.ground.cache import cache_folder, distrust, read_trusted
from exoid.ground.delivery import sweep
from exoid.ground.files import sha256, sha256_file
from exoid.ground.plain import SPOILT
from exoid.symbolic.codegen.compiler import Compiler, CompilerError, find_compiler, warn_slow
from exoid.symbolic.codegen.fingerprint import canonical_json, generator_key, library_versions, processor

LIBRARY, RECORD, SEAL = "library.so", "record.json", "seal.json"

LARGEST = 200_000_000
"""Bytes of a file of an entry; a library has some hundred thousand."""


@dataclass(frozen=True, eq=False)
class GeneratedC:
    """C text, the flags it is to be compiled with, and a `record` (plain data) to be kept beside the
    library.
    """

    text: str
    flags: tuple[str, ...]
    record: dict[str, Any]


@dataclass(frozen=True, eq=False)
class CompiledLibrary:
    """A loaded library and its record."""

    c: ctypes.CDLL
    record: dict[str, Any]


def load_library(
    kind: str, content: Any, flags: tuple[str, ...], generate: Callable[[], GeneratedC], functions: Iterable[str]
) -> CompiledLibrary | None:
    """Return the library for `content` (plain data) with its `functions`, generating and compiling it only where the
    cache has none.

    None (with one warning) where there is no compiler or it fails: the caller then takes the slow path.
    """
    wanted = tuple(functions)
    compiler = find_compiler()
    if compiler is None:
        return None
    entry = cache_folder() / f"{kind}-{_key(content, compiler, flags)[:40]}"
    found = _open(entry, wanted)
    if found is not None:
        return found
    try:
        _build(entry, generate(), compiler)
    except (CompilerError, OSError) as error:
        warn_slow(str(error))
        return None
    found = _open(entry, wanted)
    if found is None:
        warn_slow(f"what {compiler.path} made of the generated code cannot be used")
    return found


def _key(content: Any, compiler: Compiler, flags: tuple[str, ...]) -> str:
    parts = [content, library_versions(), compiler.identity, flags, processor(), generator_key()]
    return sha256(canonical_json(parts))


def _open(entry: Path, functions: Iterable[str]) -> CompiledLibrary | None:
    """Load an entry after checking that nobody else made it, its seal, and that the functions are in it; any other is
    removed.
    """
    if not os.path.lexists(entry):
        return None
    try:
        trusted = not distrust(entry)
        content = {name: read_trusted(entry / name, LARGEST) for name in (LIBRARY, RECORD, SEAL)} if trusted else {}
        seal = json.loads(content[SEAL])
        intact = all(sha256(content[name]) == seal[name] for name in (LIBRARY, RECORD))
        record = json.loads(content[RECORD]) if intact else None
        library = ctypes.CDLL(str(entry / LIBRARY)) if intact else None
    except (OSError, *SPOILT):
        record = library = None
    if library is None or not isinstance(record, dict) or not all(hasattr(library, name) for name in functions):
        _discard(entry)
        return None
    return CompiledLibrary(library, record)


def _build(entry: Path, source: GeneratedC, compiler: Compiler) -> None:
    sweep(entry.parent, ".building-*", ".damaged-*")
    folder = Path(tempfile.mkdtemp(prefix=".building-", dir=entry.parent))
    try:
        (folder / "library.c").write_text(source.text)
        compiler.build(folder / "library.c", folder / LIBRARY, source.flags)
        (folder / RECORD).write_text(canonical_json(source.record))
        seal = {name: sha256_file(folder / name) for name in (LIBRARY, RECORD)}
        (folder / SEAL).write_text(canonical_json(seal))
        for name in (LIBRARY, RECORD, SEAL):
            (folder / name).chmod(0o600)  # whatever the umask says: `_open` trusts no other
        try:
            os.rename(folder, entry)
        except OSError:
            # Another process was first, which is as good, or left something broken, which _open has to judge.
            if not entry.is_dir():
                raise
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _discard(entry: Path) -> None:
    """Take a damaged entry out of the way in one step, then delete it."""
    try:
        grave = Path(tempfile.mkdtemp(prefix=".damaged-", dir=entry.parent))
        os.rename(entry, grave / "entry")
    except OSError:
        return
    shutil.rmtree(grave, ignore_errors=True)
