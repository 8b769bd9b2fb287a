"""A designed motion on disk: its coefficients as TOML, and its samples as CSV for a controller.

period = 10.0                                   # s
[hip]
offset = 0.61                                   # rad
sine = [0.1, ...]                               # rad, harmonics 1, 2, ...
cosine = [0.2, ...]
[knee]
...
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from exoid.ground.files import write_whole
from exoid.ground.ours import WRITTEN
from exoid.ground.toml_reader import read_toml
from exoid.measurement.trajectories.trajectory import Fourier, TrajectoryError
from exoid.symbolic.quantity import JOINTS

LARGEST_FILE = 100_000
"""Bytes; a motion has a few hundred."""
MOST_HARMONICS = 20
MOST_SAMPLES = 10_000_000


def trajectory_content(trajectory: Fourier, joints: Sequence[str] = JOINTS) -> dict[str, Any]:
    """Return a motion as plain data."""
    content: dict[str, Any] = {"period": float(trajectory.period)}
    for j, joint in enumerate(joints):
        content[joint] = {
            "offset": float(trajectory.offset[j]),
            "sine": trajectory.sine[j].tolist(),
            "cosine": trajectory.cosine[j].tolist(),
        }
    return content


def write_trajectory(trajectory: Fourier, path: str | Path, joints: Sequence[str] = JOINTS) -> Path:
    """Write the coefficients of a motion as TOML, whole or not at all; return the path."""
    import tomli_w

    head = f"# {WRITTEN}: period in s; offset and coefficients in rad, harmonics 1, 2, ...\n"
    return write_whole(path, head + tomli_w.dumps(trajectory_content(trajectory, joints)))


def read_trajectory(path: str | Path, joints: Sequence[str] = JOINTS) -> Fourier:
    """Read a motion of `joints`; TrajectoryError says what is wrong, where, and what to do."""
    top = read_toml(path, LARGEST_FILE, TrajectoryError, what="motion", remedy="give the file that exoid design wrote")
    top.only("period", *joints)
    offset, sine, cosine = [], [], []
    for joint in joints:
        own = top.table(joint)
        own.only("offset", "sine", "cosine")
        count = len(own.values["sine"]) if isinstance(own.values.get("sine"), list) else 1
        if not 1 <= count <= MOST_HARMONICS:
            raise own.error("sine", f"{count} harmonics", f"give 1 to {MOST_HARMONICS} numbers in rad")
        offset.append(own.number("offset"))
        sine.append(own.numbers("sine", count))
        cosine.append(own.numbers("cosine", count))
    if len({len(entry) for entry in sine}) > 1:
        counts = (f"the {joint} has {len(item)}" for joint, item in zip(joints, sine, strict=True))
        what = f"harmonics differ: {', '.join(counts)}"
        raise TrajectoryError(what, where=top.where, remedy="fill the shorter lists with zeros")
    return Fourier(np.array(offset), np.array(sine), np.array(cosine), top.number("period", above=0.0))


def samples_per_period(period: float, rate: float) -> int:
    """Number of samples at `rate` Hz in a `period` in s; TrajectoryError where that is no whole number."""
    count = period * rate
    if not np.isfinite(count) or count > MOST_SAMPLES:
        raise TrajectoryError(f"{count:g} samples are too many", remedy="choose a lower rate")
    if abs(count - round(count)) > 1e-6 * count or round(count) < 2:
        raise TrajectoryError(
            f"a period of {period:g} s at {rate:g} Hz is {count:g} samples, no whole number: played in a loop it would "
            "jump",
            remedy="choose a rate or a period so that their product is a whole number",
        )
    return round(count)


def sample_table(trajectory: Fourier, rate: float) -> str:
    """Return the samples of one period at `rate` Hz as CSV: t, q1, ..., dq1, ..., ddq1, ... in SI units.

    The last sample is one step before the motion repeats, so that a controller can play the table in a loop.
    TrajectoryError where the period is no whole number of samples, or there would be too many.
    """
    t = np.arange(samples_per_period(trajectory.period, rate)) / rate
    motion = trajectory.at(t)
    stream = io.StringIO()
    columns = [f"{key}{j + 1}" for key in ("q", "dq", "ddq") for j in range(len(trajectory.offset))]
    stream.write(",".join(["t", *columns]) + "\n")
    np.savetxt(stream, np.column_stack([t, motion.q, motion.dq, motion.ddq]), fmt="%.9g", delimiter=",")
    return stream.getvalue()
