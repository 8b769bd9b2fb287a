"""A recording of a machine: time, joint angles and motor torques in SI units, with its origin and its audit."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from exoid.ground.errors import RecordingError, refused
from exoid.ground.files import write_whole
from exoid.ground.frames import pandas
from exoid.ground.html import bullets, lines, picture, table
from exoid.measurement.finding import Finding
from exoid.measurement.logged import Logged
from exoid.measurement.plots import angles_and_torques
from exoid.measurement.signals.spikes import far_off, without_chatter
from exoid.symbolic.joints import LEG, UNNAMED, Joint, Vector, is_spatial, names
from exoid.symbolic.mechanics.payload import Payload
from exoid.symbolic.motion import Float, read_only

if TYPE_CHECKING:
    from matplotlib.figure import Figure


BASE_COLUMNS: Mapping[str, str] = MappingProxyType({"base_angle": "rad", "base_ax": "m/s²", "base_az": "m/s²"})
"""Columns of a recording that say how a measured base moved, and their units."""
SPACE_BASE_COLUMNS: Mapping[str, str] = MappingProxyType(
    {f"base_{name}": "rad" for name in ("roll", "pitch", "yaw")} | {f"base_a{axis}": "m/s²" for axis in "xyz"}
)
"""The same of a machine in space; its angles are about the fixed axes x, y, z, in this order."""


def base_columns(joints: Sequence[Joint]) -> Mapping[str, str]:
    """Return {column: unit} of what a recording of a machine with `joints` has of a measured base, angles first."""
    return SPACE_BASE_COLUMNS if is_spatial(joints) else BASE_COLUMNS




LARGEST = 1e30
"""Of any number in a recording: far more than readers of files let through, and sums of its squares are finite."""


@dataclass(frozen=True)
class Source:
    """The file a recording came from: its path as given and the SHA-256 of its bytes ("" when made in
    memory)."""

    path: str = ""
    sha256: str = ""


class ArrayError(RecordingError, ValueError):
    """Arrays that make no recording: their shapes, or numbers that no sensor gives."""


@dataclass(frozen=True, eq=False)
class Recording:
    """Time `t` (N,) in s, angles `q` (N, J) in rad, torques `tau` (N, J) in N·m; m and N where a joint slides.

    `joints` (J,) are those of the machine, in the order of the columns: hip and knee unless given.
    `valid` (N,) says which rows may enter a fit; in the others every value is a finite placeholder
    (interpolated) that must not be used. `angle_valid` and `torque_valid` (N, J) say the same of each angle and
    each torque: what is missing of one says nothing of another. `t` increases strictly. `dq` rad/s and `ddq` rad/s² are
    (N, J) or None. `forces` are {column: (N,)} of forces from outside in N, and torques in N·m: of cuffs (f1, ...), of
    the ground (grf_x, grf_z), about a joint (interaction_torque_hip); `contact` (N,) says when the foot carries load.
    `row` (N,) is the row of the file each sample stands in (line number for text files), for messages. `payloads` are
    known masses that hung on the leg meanwhile, `conventions` the names of those it was converted from, `passive` the
    joints that had no drive meanwhile: their torque is zero, whatever their channel reads. `base` (N, 3) is how a
    measured base moved: its angle rad and its acceleration forwards and upwards m/s² without gravity; in space
    (N, 6), three angles and three accelerations. None where nothing is known of it. `logged` are further columns of the
    file that say in what state the machine was.
    """

    name: str
    t: Float
    q: Float
    tau: Float
    valid: NDArray[np.bool_] = None  # type: ignore[assignment]
    dq: Float | None = None
    ddq: Float | None = None
    source: Source = Source()
    findings: tuple[Finding, ...] = ()
    row: NDArray[np.int64] = None  # type: ignore[assignment]
    payloads: tuple[Payload, ...] = ()
    conventions: tuple[str, ...] = ()
    passive: tuple[str, ...] = ()
    joints: tuple[Joint, ...] = LEG
    base: Float | None = None
    angle_valid: NDArray[np.bool_] = None  # type: ignore[assignment]
    torque_valid: NDArray[np.bool_] = None  # type: ignore[assignment]
    forces: Mapping[str, Float] = field(default_factory=dict)
    contact: Float | None = None
    logged: Mapping[str, Logged] = field(default_factory=dict)

    def __post_init__(self) -> None:
        count = np.asarray(self.t).shape[0]
        for name in ("t", "q", "tau", "dq", "ddq", "base", "contact"):
            value = getattr(self, name)
            if value is None and name not in ("t", "q", "tau"):
                continue
            array = read_only(value)
            width = len(base_columns(self.joints) if name == "base" else self.joints)
            shape = (count,) if name in ("t", "contact") else (count, width)
            if array.shape != shape:
                raise ArrayError(f"recording.{name} has shape {array.shape}, expected {shape}")
            if not np.max(np.abs(array), initial=0.0) <= LARGEST:
                what = "values that are not finite"
                if np.isfinite(array).all():
                    what = f"values as large as {np.abs(array).max():.3g}, which no sensor measures"
                raise ArrayError(f"recording.{name} holds {what}; mask those rows first")
            object.__setattr__(self, name, array)
        forces = {name: read_only(values) for name, values in self.forces.items()}
        for name, array in forces.items():
            if array.shape != (count,) or not np.isfinite(array).all():
                raise ArrayError(f"recording.forces[{name!r}] must hold {count} finite numbers")
        object.__setattr__(self, "forces", forces)
        valid = np.ones(count, dtype=bool) if self.valid is None else _kept(self.valid, bool)
        row = np.arange(1, count + 1) if self.row is None else _kept(self.row, np.int64)
        if valid.shape != (count,) or row.shape != (count,):
            raise ArrayError(f"recording.valid and .row must have shape {(count,)}")
        if np.any(np.diff(self.t) <= 0):
            raise ArrayError("recording.t must increase strictly")
        for name, value in (("valid", valid), ("row", row)):
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        for name in ("angle_valid", "torque_valid"):
            object.__setattr__(self, name, self._cells(name, getattr(self, name)))

    def _cells(self, name: str, given: NDArray[np.bool_] | None) -> NDArray[np.bool_]:
        """Values (N, J) of a channel that are valid: never those of a row that is not."""
        shape = (len(self), len(self.joints))
        rows = np.broadcast_to(self.valid[:, None], shape)
        if given is None:
            return rows
        if np.shape(given) != shape:
            raise ArrayError(f"recording.{name} has shape {np.shape(given)}, expected {shape}")
        cells: NDArray[np.bool_] = rows & np.asarray(given, dtype=bool)
        cells.setflags(write=False)
        return cells

    def __len__(self) -> int:
        return int(self.t.shape[0])

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints (J,)."""
        return names(self.joints)

    @cached_property
    def rate(self) -> float:
        """Median sampling rate in Hz (0 for fewer than two samples)."""
        return 1.0 / float(np.median(np.diff(self.t))) if len(self) > 1 else 0.0

    @cached_property
    def spikes(self) -> NDArray[np.bool_]:
        """Samples (N, J) at which the torque has spikes, told from its neighbours alone."""
        return without_chatter(self.tau, self.far_off, self.rate)

    @cached_property
    def far_off(self) -> NDArray[np.bool_]:
        """Samples (N, J) at which the torque is far off its neighbours: spikes, or the chatter of a drive."""
        return far_off(self.tau, self.rate, ~self.torque_valid)

    @property
    def complete(self) -> NDArray[np.bool_]:
        """Rows (N,) of which every angle and every torque is valid."""
        return np.asarray(self.valid & self.angle_valid.all(axis=1) & self.torque_valid.all(axis=1))

    @property
    def duration(self) -> float:
        """Time from the first to the last sample in s."""
        return float(self.t[-1] - self.t[0]) if len(self) else 0.0

    def with_findings(self, findings: tuple[Finding, ...]) -> Recording:
        """Return the same recording carrying `findings` instead of its own."""
        other = replace(self, findings=findings)
        if "far_off" in vars(self):
            vars(other)["far_off"] = self.far_off  # found once: its torques are the same
        return other

    def with_payload(self, mass: float, along: float | Vector, link: str = "shank") -> Recording:
        """Return the same recording, made with a known `mass` kg on the leg, `along` m below the knee (or the hip, for
        `link` "thigh"; of an arm in space at `along` (3,) m in the frame of the joint `link`). PayloadError where such
        a mass cannot be.
        """
        return replace(self, payloads=(*self.payloads, Payload(mass, along, link)))

    def with_passive(self, *joints: str) -> Recording:
        """Return the same recording, made while `joints` had no drive, so that their torque is zero for certain."""
        known = self.joint_names
        for joint in joints:
            if joint not in known:
                raise RecordingError(f"there is no joint {joint!r}", where=self.name, remedy=f"use {', '.join(known)}")
        return replace(self, passive=tuple(j for j in known if j in (*self.passive, *joints)))

    def of_machine(self, joints: tuple[Joint, ...]) -> Recording:
        """Return the recording as one of the machine with `joints`; RecordingError where it has others.

        Joints that nobody named when it was read are taken in order.
        """
        if self.joint_names == names(joints):
            return self
        unnamed = all(joint.name == f"{UNNAMED}{k}" for k, joint in enumerate(self.joints, start=1))
        if unnamed and len(self.joints) == len(joints):
            called = {item.name: other.name for item, other in zip(self.joints, joints, strict=True)}
            kept = ("-".join(called.get(part, part) for part in name.split("-")) for name in self.conventions)
            return replace(self, joints=joints, conventions=tuple(kept))
        mine, wanted = ", ".join(self.joint_names), ", ".join(names(joints))
        count = len(self.joints)
        mine = mine if not unnamed else "one joint" if count == 1 else f"{count} joints"
        what = f"the recording is of a machine with {mine}, the model has {wanted}"
        remedy = "give the machine's model with --model FILE, a URDF or what exoid model writes; in Python "
        remedy += "read_recording(FILE, joints=model.joints)"
        raise RecordingError(what, where=self.source.path or self.name, remedy=remedy)

    @property
    def quantities(self) -> dict[str, Float]:
        """The quantities of every joint, (N, J) each: {"q": angles, ...}, of q, dq, ddq and tau."""
        every = {"q": self.q, "dq": self.dq, "ddq": self.ddq, "tau": self.tau}
        return {name: values for name, values in every.items() if values is not None}

    def columns(self) -> dict[str, Float]:
        """Return {name: (N,)} with the canonical names t, q1, q2, tau1, ... in SI units; what is not valid is NaN."""
        out: dict[str, Float] = {"t": self.t}
        rows = np.broadcast_to(self.valid[:, None], self.q.shape)
        cells = {"q": self.angle_valid, "tau": self.torque_valid}
        for label, values in self.quantities.items():
            for joint in range(len(self.joints)):
                out[f"{label}{joint + 1}"] = np.where(cells.get(label, rows)[:, joint], values[:, joint], np.nan)
        if self.base is not None:
            out |= {n: np.where(self.valid, self.base[:, k], np.nan) for k, n in enumerate(base_columns(self.joints))}
        outside = {**self.forces, **({} if self.contact is None else {"contact": self.contact})}
        return out | {name: np.where(self.valid, values, np.nan) for name, values in outside.items()}

    def to_frame(self) -> Any:
        """Return a pandas DataFrame of the canonical columns; what is not valid is NaN, times excepted."""
        return pandas().DataFrame(self.columns())

    def to_polars(self) -> Any:
        """Return a polars DataFrame of the canonical columns, as `to_frame`."""
        import polars as pl

        return pl.DataFrame(self.columns())

    def to_xarray(self) -> Any:
        """Return an xarray Dataset of the canonical columns over the time, each with its unit."""
        import xarray as xr

        columns = self.columns()
        time = columns.pop("t")
        data = {}
        for name, cells in columns.items():
            carried = base_columns(self.joints)
            if name in carried or name in self.forces or name == "contact":
                data[name] = ("t", cells, {"units": carried.get(name, force_unit(name))})
                continue
            quantity = name.rstrip("0123456789")
            unit = self.joints[int(name.removeprefix(quantity)) - 1].unit(quantity)
            data[name] = ("t", cells, {"units": unit})
        return xr.Dataset(data, coords={"t": ("t", time, {"units": "s"})}, attrs={"name": self.name})

    def plot(self) -> Figure:
        """Draw angles and torques over time."""
        return angles_and_torques(self.name, self.t, self.q, self.tau, self.complete, self.joints)

    def _repr_html_(self) -> str:
        masked = len(self) - int(self.complete.sum())
        facts = (len(self), self.duration, self.rate, masked, self.source.sha256[:12] or "–")
        head = ("samples", "seconds", "Hz", "masked rows", "SHA-256")
        drawn = picture(self.plot(), f"Angles and torques of {self.name} over time")
        return lines(strong=self.name) + table(head, [facts]) + bullets(self.findings) + drawn

    def __repr__(self) -> str:
        masked = len(self) - int(self.complete.sum())
        worst = [f.check for f in self.findings if f.severity == "warning"]
        return (
            f"Recording({self.name!r}: {len(self)} samples, {self.duration:.4g} s at {self.rate:.4g} Hz, "
            f"{masked} rows masked, {len(self.findings)} findings"
            + (f", warnings: {', '.join(worst)}" if worst else "")
            + (f", with {', '.join(map(str, self.payloads))})" if self.payloads else ")")
        )


def force_unit(name: str) -> str:
    """Return the unit of a column of `Recording.forces`, "1" for the contact."""
    return "1" if name == "contact" else "N·m" if "torque" in name else "N"


def _kept(values: Any, kind: type) -> NDArray[Any]:
    """Return `values` as a copy of a `kind`, or as they are where nobody can write to them."""
    known = isinstance(values, np.ndarray) and values.dtype == kind and values.base is None
    return values if known and not values.flags.writeable else np.array(values, dtype=kind)


def to_csv(recording: Recording) -> bytes:
    """Return `recording` as CSV: canonical names, LF, shortest digits that read back as the same numbers.

    What is not valid is written as an empty cell, so that it is masked again when read.
    """
    columns = recording.columns()
    text = io.StringIO()
    text.write(",".join(columns) + "\n")
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    text.writelines(",".join("" if cell != cell else repr(cell) for cell in row) + "\n" for row in rows)
    return text.getvalue().encode("ascii")


def write_recording(recording: Recording, path: str | Path) -> Path:
    """Write `recording` as CSV (see `to_csv`) to `path`, whole or not at all, and return the path.

    The same recording gives the same bytes on every machine. Raises RecordingError when the folder cannot be
    written.
    """
    remedy = "check that the folder may be written to and is not full"
    with refused(RecordingError, "the recording cannot be written ({})", path, remedy):
        return write_whole(path, to_csv(recording))
