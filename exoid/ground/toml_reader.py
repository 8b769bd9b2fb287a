"""A TOML table that knows where it stands, so that every refusal names file, line, key and the nearest right key."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from exoid.ground.errors import ExoidError, ModelFileError, refused
from exoid.ground.inputs import open_input
from exoid.ground.suggest import did_you_mean

KeyPath = tuple[str | int, ...]


@dataclass(frozen=True, eq=False)
class Table:
    """The `values` of a table at `path` in the file `where` with the text `source`; what is wrong is a `refusal`."""

    values: Mapping[str, Any]
    path: KeyPath
    where: str
    source: str
    refusal: type[ExoidError] = ModelFileError

    def child(self, key: str | int, values: Mapping[str, Any]) -> Table:
        """Return a table below this one."""
        return replace(self, values=values, path=(*self.path, key))

    def place(self, key: str | None = None) -> str:
        """Return "file, line 12, custom_effects[1].torque"."""
        path = self.path if key is None else (*self.path, key)
        line = locate(self.source, path)
        words = "".join(f"[{p + 1}]" if isinstance(p, int) else f".{p}" for p in path).lstrip(".")
        return ", ".join(filter(None, (self.where, f"line {line}" if line else "", words)))

    def error(self, key: str | None, what: str, remedy: str) -> ExoidError:
        """Return the error to raise about a key of this table."""
        return self.refusal(what, where=self.place(key), remedy=remedy)

    def only(self, *known: str) -> None:
        """Refuse keys that are not known."""
        for key in self.values:
            if key not in known:
                hint = did_you_mean(key, known) or "known here: " + (", ".join(known) or "nothing")
                raise self.error(key, f"unknown key {key!r}", hint)

    def table(self, key: str) -> Table:
        """Return the table under `key`, which must be there."""
        if key not in self.values:
            raise self.error(None, f"{key} is missing", f"write [{key}] and its keys below")
        value = self.values[key]
        if not isinstance(value, dict):
            raise self.error(key, f"{key} is {_kind(value)}, not a table", f"write [{key}] and its keys below")
        return self.child(key, value)

    def tables(self, key: str) -> list[Table]:
        """Return the tables of an array of tables; empty where there is none."""
        value = self.values.get(key, [])
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            raise self.error(key, f"{key} is {_kind(value)}", f"write [[{key}]] with double brackets, once per effect")
        return [replace(self, values=item, path=(*self.path, key, k)) for k, item in enumerate(value)]

    def text(self, key: str, default: str | None = None) -> str:
        """Return the text under `key`; where it is not there the default, ModelFileError or the like without one."""
        if key not in self.values:
            if default is None:
                raise self.error(None, f"{key} is missing", f'add {key} = "..."')
            return default
        value = self.values[key]
        if not isinstance(value, str) or not value.strip():
            raise self.error(key, f"{key} is {_kind(value)}", f'write it in quotes: {key} = "..."')
        if len(value) > 4000:
            raise self.error(key, f"{key} has {len(value)} characters", "shorten it to at most 4000")
        return value

    def number(
        self,
        key: str,
        default: float | None = None,
        above: float | None = None,
        below: float | None = None,
        least: float | None = None,
    ) -> float:
        """Return the finite number under `key`, between `above` and `below`, `least` or more, or the default."""
        if key not in self.values:
            if default is None:
                raise self.error(None, f"{key} is missing", f"add {key} = <number>")
            return default
        number = self._checked(key, self.values[key], above, below)
        if least is not None and number < least:
            raise self.error(key, f"{key} = {number:g} is out of range", f"give {least:g} or more")
        return number

    def optional(self, key: str) -> float | None:
        """Return the finite number under `key`, or None."""
        return self.number(key) if key in self.values else None

    def flag(self, key: str) -> bool:
        """True if `key` is true; a key that is left out is not."""
        value = self.values.get(key, False)
        if not isinstance(value, bool):
            raise self.error(key, f"{key} is {_kind(value)}, neither true nor false", "write true or false")
        return value

    def numbers(self, key: str, count: int | None = None, low: float | None = None) -> list[float]:
        """Return the list of finite numbers under `key`, which must be there."""
        if key not in self.values:
            raise self.error(None, f"{key} is missing", f"add {key} = [...]")
        value = self.values[key]
        if not isinstance(value, list) or (count is not None and len(value) != count):
            wanted = "numbers" if count is None else f"{count} numbers"
            raise self.error(key, f"{key} is {_kind(value)}", f"write a list of {wanted}: {key} = [...]")
        return [self._checked(key, item, low, None) for item in value]

    def texts(self, key: str) -> list[str]:
        """Return the list of texts under `key`, which must be there and not be empty."""
        value = self.values.get(key)
        if value is None:
            raise self.error(None, f"{key} is missing", f'add {key} = ["..."]')
        whole = isinstance(value, list) and value and all(isinstance(item, str) and item.strip() for item in value)
        if not whole:
            raise self.error(key, f"{key} is {_kind(value)}", f'write a list of texts: {key} = ["..."]')
        return [str(item) for item in value]

    def _checked(self, key: str, value: Any, above: float | None, below: float | None) -> float:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self.error(
                key, f"{key} is {_kind(value)}, not a number", "write a number without quotes, in SI units"
            )
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self.error(key, f"{key} = {str(value)[:20]} is not finite", "write a finite number")
        if (above is not None and number <= above) or (below is not None and number >= below):
            limits = " and ".join(
                filter(None, ("" if above is None else f"above {above:g}", "" if below is None else f"below {below:g}"))
            )
            raise self.error(key, f"{key} = {number:g} is out of range", f"give a number {limits} (SI units)")
        return number


def read_toml(
    path: str | Path, most: int, error: type[ExoidError], *, what: str, remedy: str, remember: bool = True
) -> Table:
    """Return the whole of a TOML file of at most `most` bytes, which should be `what`.

    Raises `error`, with the `remedy`, where it cannot be read or is no TOML. `remember` is that of `open_input`.
    """
    with refused(error, "cannot be read: {}", path, "check the path"), open_input(path, remember=remember) as stream:
        data = stream.read(most + 1)
    if len(data) > most:
        raise error(f"is too large for a {what}", where=str(path), remedy=remedy)
    with refused(error, "is not UTF-8 text", path, "save it as UTF-8", (UnicodeDecodeError,)):
        text = data.decode("utf-8-sig")
    if text.lstrip()[:1] == "{":
        raise error(f"is JSON and no {what}", where=str(path), remedy=remedy)
    with refused(error, "is not valid TOML: {}", path, remedy, (ValueError, RecursionError)):
        return Table(tomllib.loads(text), (), str(path), text, error)


def _kind(value: Any) -> str:
    names = {bool: "true or false", str: "a text", int: "a number", float: "a number", list: "a list", dict: "a table"}
    if isinstance(value, list):
        return f"a list of {len(value)}"
    return "an empty text" if value == "" else names.get(type(value), "a date or time")


def locate(text: str, path: KeyPath) -> int | None:
    """Return the line (from 1) where `path` stands in TOML `text`, or its nearest ancestor that has a line of its
    own.
    """
    best: int | None = None
    for length in range(1, len(path) + 1):
        found = _line_of(text, path[:length], best or 1)
        best = found if found is not None else best
    return best


def _line_of(text: str, path: KeyPath, start: int) -> int | None:
    """Find a header "[a.b]", the n-th "[[a]]", or "key =" at or after line `start`."""
    names = [str(p) for p in path if isinstance(p, str)]
    lines = text.splitlines()
    if isinstance(path[-1], int):
        header = re.compile(r"\s*\[\[\s*" + r"\s*\.\s*".join(map(re.escape, names)) + r"\s*\]\]")
        hits = [k for k, line in enumerate(lines, 1) if header.match(line)]
        return hits[path[-1]] if path[-1] < len(hits) else None
    last = rf"[\"']?{re.escape(names[-1])}[\"']?"
    dotted = r"\s*\.\s*".join([*(re.escape(name) for name in names[:-1]), last])
    header = re.compile(rf"\s*\[\[?\s*{dotted}\s*[\].]")
    key = re.compile(rf"(^|[\s{{,.]){last}\s*[=.]")
    for k, line in enumerate(lines[start - 1 :], start):
        bare = line.split("#", 1)[0]
        if header.match(line) or key.search(bare):
            return k
        if k > start and len(path) > 1 and re.match(r"\s*\[", line) and not line.strip().startswith(f"[{names[0]}."):
            return None
    return None
