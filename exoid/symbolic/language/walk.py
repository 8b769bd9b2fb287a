"""One walk over a torque tree for every language it is written in: each language is a table of how it writes a node."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from exoid.ground.errors import ExpressionError
from exoid.symbolic.language.tree import Binary, Call, Name, Node, Number, Unary

NONE: Mapping[str, Any] = {}


@dataclass(frozen=True)
class Spelling:
    """Spelling of each kind of node in one target language.

    `signs` gives, for a velocity, what its sign is: near standstill a measured sign is more than
    sgn(velocity). `shortcut` gives what a call is where the language has a better way to write the whole of it.
    """

    number: Callable[[float], Any]
    name: Callable[[str], Any]
    negative: Callable[[Any], Any]
    power: Callable[[Any, float], Any]
    binary: Mapping[str, Callable[[Any, Any], Any]]
    functions: Mapping[str, Callable[..., Any]]
    signs: Mapping[str, Any] = field(default_factory=lambda: NONE)
    shortcut: Callable[[Call], Any] = lambda call: None


def lower(node: Node, table: Spelling) -> Any:
    """Translate a tree by a table; ExpressionError for a word the table does not have."""
    if isinstance(node, Number):
        return table.number(node.value)
    if isinstance(node, Name):
        return table.name(node.name)
    if isinstance(node, Unary):
        return table.negative(lower(node.operand, table))
    if isinstance(node, Binary):
        if node.operator == "**" and isinstance(node.right, Number):
            return table.power(lower(node.left, table), node.right.value)
        return table.binary[node.operator](lower(node.left, table), lower(node.right, table))
    if node.function == "sgn" and isinstance(node.arguments[0], Name) and node.arguments[0].name in table.signs:
        return table.signs[node.arguments[0].name]
    if node.function not in table.functions:
        what = f"{node.function} needs a whole recording and cannot be written here"
        raise ExpressionError(what, where=f"{node.function}(...)", remedy="replace it by a named input (split_memory)")
    if (found := table.shortcut(node)) is not None:
        return found
    return table.functions[node.function](*(lower(argument, table) for argument in node.arguments))
