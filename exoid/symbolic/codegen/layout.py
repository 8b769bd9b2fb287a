"""Layout of the arrays of the generated code, for any number of joints."""

from __future__ import annotations

from collections.abc import Sequence

STEMS = ("theta", "dtheta", "ddtheta", "sign")


BASE_STATE = ("base", "dbase", "ddbase", "base_ax", "base_az")
"""Motion of a measured base: angle rad, its derivatives, acceleration forwards and upwards m/s²."""


_ANGLES = ("base_roll", "base_pitch", "base_yaw")
SPACE_BASE_STATE = (
    *_ANGLES, *(f"d{angle}" for angle in _ANGLES), *(f"dd{angle}" for angle in _ANGLES), "base_ax", "base_ay", "base_az"
)  # fmt: skip
"""The same in space: angles about the fixed axes x, y, z in this order (rad), their derivatives, acceleration m/s²."""


def base_state(moving: bool, spatial: bool) -> tuple[str, ...]:
    """Return the names of a base's motion; none where it stands still."""
    return () if not moving else SPACE_BASE_STATE if spatial else BASE_STATE


def state_names(count: int, base: Sequence[str] = (), forces: int = 0) -> tuple[str, ...]:
    """Return the names of the motion of `count` joints at an instant, in the order of the generated code's `state`;
    then those of the `base`'s, last those of `forces` columns of measured ones.
    """
    joints = (f"{stem}{k + 1}" for stem in STEMS for k in range(count))
    return ("t", *joints, *base, *force_names(forces))


def force_names(count: int) -> tuple[str, ...]:
    """Return the names of `count` columns of measured forces in the generated code's `state`."""
    return tuple(f"force{k + 1}" for k in range(count))


def widths(count: int, spatial: bool = False) -> dict[str, int]:
    """Return {function: numbers per sample} for `count` joints, without the columns; a point has two coordinates in a
    plane and three in space.
    """
    square = count * count
    return {
        "inverse_dynamics": count, "forward_dynamics": count, "mass_matrix": square, "coriolis": square,
        "gravity": count, "jacobian": (3 if spatial else 2) * count,
    }  # fmt: skip
