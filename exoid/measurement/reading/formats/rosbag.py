"""ROS 1 and ROS 2 bags and MCAP files through rosbags, which is an optional extra.

Every number of every message becomes a column `topic/field`; arrays beside a list of names (JointState) become one
column per name, `topic/name/position`. The time is that of the header where a message has one, else that of its
arrival. Topics are put on the clock of the one with the joint angles.
"""

from __future__ import annotations

import bz2
import re
import sqlite3
from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import IO, Any

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.ground.extras import needing
from exoid.measurement.finding import Finding
from exoid.measurement.reading import limits
from exoid.measurement.reading.limits import Budget, Within, damaged
from exoid.measurement.reading.names import quantity_of, recognise
from exoid.measurement.reading.raw import RawColumn, RawTable
from exoid.measurement.reading.resample import onto
from exoid.symbolic.motion import Float

SUFFIXES = (".bag", ".mcap", ".db3")
SIGNATURES = (b"#ROSBAG V", b"\x89MCAP0\r\n")
WIDEST = 64
"""Numbers of one message; more are an image or a scan."""
LONGEST = 100_000
"""Bytes of one message."""
MESSAGE = 32
"""Bytes that a message takes beside its numbers: its stamps."""
COMPUTED = re.compile(r"\b(AS|VIRTUAL|VIEW|TRIGGER)\b", re.IGNORECASE)
"""Words of a table that is not stored but computed, at any length."""
DEEPEST = 5


@dataclass(eq=False)
class Topic:
    """The numbers of one topic: stamps of header and arrival in ns, columns by name with one entry per message."""

    sent: list[int] = field(default_factory=list)
    arrived: list[int] = field(default_factory=list)
    columns: dict[str, array[float]] = field(default_factory=dict)

    def add(self, numbers: dict[str, float], sent: int, arrived: int, budget: Budget) -> None:
        """Append one message; what it lacks, and what the ones before lacked, is NaN."""
        count, new = len(self.arrived), len(numbers.keys() - self.columns.keys())
        budget.count(new)
        budget.take(MESSAGE + 8 * (len(self.columns) + new * (count + 1)), "the messages of the bag")
        for name, value in numbers.items():
            self.columns.setdefault(name, array("d", [float("nan")]) * count).append(value)
        for column in self.columns.values():
            if len(column) == count:
                column.append(float("nan"))
        self.sent.append(sent)
        self.arrived.append(arrived)

    def time(self, origin: int) -> Float:
        """Return seconds since `origin` (ns), of the headers where they run on, else of the arrivals."""
        sent = np.array(self.sent, dtype=np.int64)
        runs = sent.size > 1 and sent[0] > 0 and np.mean(np.diff(sent) > 0) > 0.5
        stamps = sent if runs else np.array(self.arrived, dtype=np.int64)
        return (stamps - origin).astype(float) * 1e-9


def read(path: Path) -> RawTable:
    """Return the columns of all topics; raises RecordingError when it is damaged or rosbags is not installed."""
    with needing("ros", "ROS bags and MCAP files", "rosbags", where=path, error=RecordingError):
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    _bound_unpacking()
    topics: dict[str, Topic] = {}
    skipped: set[str] = set()
    budget = Budget(str(path))
    # The package raises whatever the bytes of a damaged bag happen to hit.
    with damaged("bag", path, (Exception,), "ros2 bag reindex or rosbag reindex may mend it"):
        for part in path.glob("*.db3") if path.is_dir() else (path,):
            if part.suffix == ".db3":
                _refuse_computed_tables(part)
        with AnyReader([_BoundedPath(path)], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
            for connection, arrived, raw in reader.messages():
                if len(raw) > LONGEST or connection.topic in skipped:
                    skipped.add(connection.topic)
                    continue
                try:
                    message = reader.deserialize(raw, connection.msgtype)
                except KeyError:
                    skipped.add(connection.topic)
                    continue
                numbers = dict(_numbers(connection.topic, message, 0))
                if not numbers or len(numbers) > WIDEST:
                    skipped.add(connection.topic)
                    continue
                topics.setdefault(connection.topic, Topic()).add(numbers, _stamp(message), arrived, budget)
    return _table(topics, skipped, str(path))


class _BoundedPath(type(Path())):  # type: ignore[misc]
    """A path whose files never make room for more bytes than they have, whatever a record in them claims."""

    def open(self, mode: str = "r", *args: Any, **options: Any) -> IO[Any]:
        """Return the file open for reading."""
        return Within(Path(self)) if mode == "rb" else super().open(mode, *args, **options)


def _bound_unpacking() -> None:
    """Put a bound on what the package unpacks: a few kB stand for any number of bytes."""
    import lz4.frame
    from rosbags.rosbag1 import reader as old
    from rosbags.rosbag2 import reader, storage_mcap

    zstd = storage_mcap.zstd
    old.decompressors["bz2"] = lambda data: _unpacked(bz2.BZ2Decompressor(), data)
    old.decompressors["lz4"] = lambda data: _unpacked(lz4.frame.LZ4FrameDecompressor(), data)
    storage_mcap.DECOMPRESSORS["lz4"] = lambda data, _: _unpacked(lz4.frame.LZ4FrameDecompressor(), data)
    storage_mcap.DECOMPRESSORS["zstd"] = lambda data, _: _unpacked(zstd.ZstdDecompressor(), data)
    bounded = SimpleNamespace(
        decompress=lambda data: _unpacked(zstd.ZstdDecompressor(), data),
        open=lambda stream, mode: _BoundedStream(zstd.open(stream, mode)),
    )
    vars(reader)["zstd"] = bounded


def _unpacked(unpack: Any, data: Any) -> bytes:
    most = limits.MOST_BYTES // 4
    out: bytes = unpack.decompress(bytes(data), most)
    if not unpack.eof:
        raise ValueError(f"a chunk unpacks to more than {most / 1e9:g} GB, or is cut off")
    return out


@dataclass(eq=False)
class _BoundedStream:
    """A packed file of which no more is unpacked than a recording may take."""

    stream: Any
    budget: Budget = field(default_factory=lambda: Budget("the packed file of the bag"))

    def __enter__(self) -> _BoundedStream:
        return self

    def __exit__(self, *_: object) -> None:
        self.stream.close()

    def read(self, size: int) -> bytes:
        """Return at most `size` bytes more."""
        out: bytes = self.stream.read(size)
        self.budget.take(len(out), "it")
        return out


def _refuse_computed_tables(path: Path) -> None:
    """Refuse a database with views, triggers or computed columns: they can yield any number of rows of any size."""
    store = sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro&immutable=1", uri=True)
    try:
        found = store.execute("SELECT type, substr(sql, 1, 10000) FROM sqlite_master").fetchmany(limits.MOST_ENTRIES)
    finally:
        store.close()
    if any(kind not in ("table", "index") or COMPUTED.search(sql or "") for kind, sql in found):
        raise ValueError("its tables are computed, not recorded")


def _stamp(message: Any) -> int:
    """Return the stamp of a message's header in ns, 0 where it has none."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec) if stamp is not None else 0


def _numbers(name: str, value: Any, depth: int) -> Iterator[tuple[str, float]]:
    """Yield (column name, number) for all numbers below `value`."""
    if isinstance(value, (bool, int, float, np.number)):
        yield name, float(value)
    elif isinstance(value, (list, tuple, np.ndarray)):
        cells = value if len(value) <= WIDEST else ()
        for i, item in enumerate(cells):
            yield from _numbers(f"{name}{i}", item, depth + 1)
    elif hasattr(value, "__dataclass_fields__") and depth < DEEPEST:
        names = getattr(value, "name", getattr(value, "joint_names", None))
        named = [str(item) for item in names] if isinstance(names, (list, tuple)) else []
        for key in value.__dataclass_fields__:
            item = getattr(value, key)
            if key.startswith("__") or key in ("header", "layout", "stamp"):
                continue
            if named and isinstance(item, (list, tuple, np.ndarray)) and len(item) == len(named):
                for joint, cell in zip(named, item, strict=True):
                    yield from _numbers(f"{name}/{joint}/{key}", cell, depth + 1)
            else:
                yield from _numbers(f"{name}/{key}", item, depth + 1)


def _table(topics: dict[str, Topic], skipped: set[str], where: str) -> RawTable:
    """Return one table on the clock of the topic with most joint angles."""
    topics = {name: topic for name, topic in topics.items() if len(topic.arrived) > 1}
    if not topics:
        remedy = "record a sensor_msgs/JointState, or messages with position and effort"
        raise RecordingError("no topic of the bag holds numbers", where=where, remedy=remedy)

    def angles(topic: Topic) -> tuple[int, int]:
        found = [recognise(name) for name in topic.columns]
        kinds = [quantity_of(item.name) for item in found if item]
        return sum(kind == "q" for kind in kinds), len(kinds)

    main = max(topics, key=lambda name: (angles(topics[name]), len(topics[name].arrived)))
    origin = topics[main].arrived[0]
    time = topics[main].time(origin)
    columns = [RawColumn("time", time, "s")]
    moved = []
    for name, topic in topics.items():
        for column, cells in topic.columns.items():
            values = np.array(cells)
            if name != main:
                values = onto(time, topic.time(origin), values)
                moved.append(name)
            shown = "".join(c if c.isprintable() else "?" for c in column.lstrip("/"))
            columns.append(RawColumn(shown, values))
    notes = []
    if moved:
        what = f"topics {', '.join(sorted(set(moved))[:8])} were put on the clock of {main}"
        notes.append(Finding("format", "info", what, where))
    if skipped:
        what = f"topics without columns of numbers: {', '.join(sorted(skipped)[:8])}"
        notes.append(Finding("format", "info", what, where))
    return RawTable(tuple(columns), np.arange(1, time.size + 1), tuple(notes))
