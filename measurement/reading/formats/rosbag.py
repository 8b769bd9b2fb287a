"""ROS 1 and ROS 2 bags and MCAP files through rosbags, which is an optional extra.

Every number of every message becomes a column `topic/field`; arrays beside a list of names (JointState) become one
column per name, `topic/name/position`. The time is that of the header where a message has one, else that of its
arrival. Topics are put on the clock of the one with the joint angles.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ground.errors import RecordingError
from measurement.finding import Finding
from measurement.reading.names import quantity_of, recognise
from measurement.reading.raw import RawColumn, RawTable
from measurement.reading.resample import onto
from symbolic.motion import Float

SUFFIXES = (".bag", ".mcap", ".db3")
SIGNATURES = (b"#ROSBAG V", b"\x89MCAP0\r\n")
MOST_CELLS = 100_000_000
WIDEST = 64
"""Numbers of one message; more are an image or a scan."""
DEEPEST = 5


@dataclass(eq=False)
class Topic:
    """The numbers of one topic: stamps of header and arrival in ns, columns by name with one entry per message."""

    sent: list[int] = field(default_factory=list)
    arrived: list[int] = field(default_factory=list)
    columns: dict[str, list[float]] = field(default_factory=dict)

    def add(self, numbers: dict[str, float], sent: int, arrived: int) -> None:
        """Append one message; what it lacks, and what the ones before lacked, is NaN."""
        count = len(self.arrived)
        for name, value in numbers.items():
            self.columns.setdefault(name, [float("nan")] * count).append(value)
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
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise RecordingError(
            "ROS bags and MCAP files need the package rosbags, which is not installed",
            where=str(path),
            remedy="pip install 'exoid[ros]'",
        ) from error
    topics: dict[str, Topic] = {}
    skipped: set[str] = set()
    cells = 0
    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
            for connection, arrived, raw in reader.messages():
                if len(raw) > 100_000 or connection.topic in skipped:
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
                topics.setdefault(connection.topic, Topic()).add(numbers, _stamp(message), arrived)
                cells += len(numbers)
                if cells > MOST_CELLS:
                    raise RecordingError(
                        f"the bag holds more than {MOST_CELLS} numbers",
                        where=str(path),
                        remedy="cut it, or fewer topics",
                    )
    except RecordingError:
        raise
    except Exception as error:
        raise RecordingError(
            f"the bag is damaged or incomplete ({str(error)[:200]})",
            where=str(path),
            remedy="ros2 bag reindex or rosbag reindex may mend it",
        ) from error
    return _table(topics, skipped, str(path))


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
        raise RecordingError(
            "no topic of the bag holds numbers",
            where=where,
            remedy="record a sensor_msgs/JointState, or messages with position and effort",
        )

    def angles(topic: Topic) -> tuple[int, int]:
        found = [recognise(name) for name in topic.columns]
        kinds = [quantity_of(one.name) for one in found if one]
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
