"""A model of the leg, or of another machine: what it consists of, its torque, and its files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

from exoid.symbolic.columns import (
    MovingTorque,
    following_columns,
    following_places,
    held_places,
    model_columns,
    model_torque,
    moving_torque,
    needs_reference,
    reference_places,
    whole_columns,
)
from exoid.symbolic.model_file import Identified, read_structure, write_model
from exoid.symbolic.model_structure import ModelStructure
from exoid.symbolic.motion import Float, Motion
from exoid.symbolic.robot_file import RobotFile, read_robot
from exoid.symbolic.spatial_machine import RobotMachine, robot_structure


@dataclass(frozen=True, eq=False, repr=False)
class Model(ModelStructure):
    """A leg with thigh length m, gravity m/s², the limits of its joints, and its terms beyond rigid body
    and friction.

    `joints` (J,) make another machine of it, in the order of every axis of length J: Joints, or the names of ones that
    turn. `terms` may be named: "stribeck:hip". EffectError for joints
    that make no machine, and effects that have no place there.
    """

    @staticmethod
    def load(path: str | Path) -> Model:
        """Read a model file, or a URDF; ModelFileError says what is wrong, in which line, and what to do."""
        return read_model(path)

    @staticmethod
    def from_urdf(path: str | Path, joints: Sequence[str] = (), gravity: float | None = None) -> Model:
        """Return the machine that the `joints` of a robot's URDF make (default: all that move), in a plane or in space.

        Others stand still at zero. `gravity` in m/s² is that within the plane of a planar machine, or downwards (9.81).
        RobotFileError says what is wrong with the file or its joints.
        """
        return robot_machine(read_robot(path), joints, gravity, str(path)).model

    def save(self, path: str | Path, fit: Identified | None = None) -> Path:
        """Write the model, with the numbers of `fit` where given, whole or not at all; return the path.

        ModelFileError where the model holds an effect that TOML cannot express.
        """
        return write_model(self, path, fit)

    def columns(self, motion: Motion, shape: Float | None = None, reference: Float | None = None) -> Float:
        """Return the regressor (J, N, P).

        `shape` (S,) are values of the shapes (default: typical), `reference` (P,) the linear parameters
        from which a column that depends on the model's torque computes it (default: zero). ValueError on
        wrong lengths.
        """
        return model_columns(self, motion, shape, reference)

    def whole_columns(self, motion: Motion, shape: Float | None = None, reference: Float | None = None) -> Float:
        """Return `columns`, with one more, (J, N, P + 1), where the model has measured forces: the torque that these
        ask for without a number, their place and gain being known.
        """
        return whole_columns(self, motion, shape, reference)

    def torque(self, motion: Motion, linear: Any, shape: Float | None = None) -> Float:
        """Return the torque (N, J) in N·m that the model says `motion` takes, for linear parameters (P,)."""
        return model_torque(self, motion, linear, shape)

    def moving_torque(self, motion: Motion, linear: Float, shape: Float, index: int) -> MovingTorque:
        """Return the torque (N, J) that shape value `index` has no part in, the joints (A,) of the rest, and what gives
        the rest (V, A, N) at V values of it; other arguments as of `torque`.
        """
        return moving_torque(self, motion, linear, shape, index)

    def following_columns(
        self, motion: Motion, chosen: Sequence[int], nodes: Float, reference: Float | None = None
    ) -> Float:
        """Return the columns (V, J, m, N) of the parameters `chosen` (m,), all of `following_places` or `held_places`,
        at V rows of shapes, `nodes` (V, S), and with the parameters at `reference` (P,) where columns depend on these.
        """
        return following_columns(self, motion, chosen, nodes, reference)

    @cached_property
    def needs_reference(self) -> bool:
        """True if some column depends on the linear parameters themselves."""
        return needs_reference(self)

    @cached_property
    def reference_places(self) -> tuple[int, ...]:
        """The indices of the linear parameters that columns depend on; () where they depend on none."""
        return reference_places(self)

    @cached_property
    def following_places(self) -> tuple[int, ...]:
        """The indices (m,) of the parameters whose columns follow the shapes, or the parameters where these are fed
        back, all others staying what they are; none where shapes reach into the equations or into whole torques.
        """
        return following_places(self)

    @cached_property
    def held_places(self) -> tuple[int, ...]:
        """The same where columns depend on the parameters and these are held; () where others may follow as well."""
        return held_places(self)


def robot_machine(
    robot: RobotFile, names: Sequence[str] = (), gravity: float | None = None, where: str = "URDF"
) -> RobotMachine[Model]:
    """Return the machine that the joints called `names` (default: all that move) make; others stand still at zero.

    `gravity` in m/s² is that within the plane of a planar machine, or downwards. RobotFileError says what is wrong with
    the file or its joints.
    """
    found = robot_structure(robot, names, gravity, where)
    return RobotMachine(model_of(found.model), found.names, found.notes)


def read_model(path: str | Path) -> Model:
    """Read a model file, or the machine of all joints that move in a robot's URDF.

    ModelFileError says what is wrong, in which line, and what to do; of a URDF, RobotFileError does.
    """
    return model_of(read_structure(path))


def model_of(structure: ModelStructure) -> Model:
    """Return the model that consists of what `structure` does."""
    return Model(**{field.name: getattr(structure, field.name) for field in fields(structure)})
