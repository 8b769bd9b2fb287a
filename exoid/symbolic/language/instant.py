"""Take a torque text apart: what an instant suffices for, and the operators that need the past.

sgn of a joint velocity becomes the motion's sign (which is how a joint at rest is distinguished from one that creeps),
and each operator with memory becomes the word `memory<k>`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from exoid.symbolic.language.tree import OPERATORS, Call, Name, rebuilt


@dataclass(frozen=True, eq=False)
class Operation:
    """An operator with memory: its word, the word `name` that stands for its value, argument and parameter."""

    operator: str
    name: str
    argument: Any
    parameter: Any | None


def split_memory(node: Any, count: int) -> tuple[Any, list[Operation]]:
    """Return the text without operators, and the operators in the order in which they must be evaluated.

    `count` is how many memories there are already.
    """
    operations: list[Operation] = []

    def walk(tree: Any) -> Any:
        tree = rebuilt(tree, walk)
        if not isinstance(tree, Call):
            return tree
        first, *rest = tree.arguments
        if tree.function in OPERATORS:
            name = f"memory{count + len(operations)}"
            operations.append(Operation(tree.function, name, first, rest[0] if rest else None))
            return Name(name)
        if tree.function == "sgn" and isinstance(first, Name) and first.name.startswith("dtheta"):
            return Name(f"sign{first.name.removeprefix('dtheta')}")
        return tree

    return walk(node), operations
