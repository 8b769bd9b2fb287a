"""The tree of a torque text: five kinds of node, each knowing where in the text it stands."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

FUNCTIONS = {
    "sin": 1,
    "cos": 1,
    "tan": 1,
    "exp": 1,
    "log": 1,
    "sqrt": 1,
    "abs": 1,
    "sgn": 1,
    "tanh": 1,
    "max": 2,
    "min": 2,
}
"""Functions of the language and how many arguments each takes."""

OPERATORS = {"play": 2, "dahl": 2, "delay": 2, "lag": 2, "slow": 2, "ddt": 1}
"""Words with memory: they need a whole recording, so they are computed in operators.py."""

CONSTANTS = {"pi": 3.141592653589793}

Span: TypeAlias = tuple[int, int]
"""First character and the one behind the last, counted from 0."""


@dataclass(frozen=True)
class _Node:
    def walk(self) -> Iterator[Node]:
        """Yield this node and all below it, without recursion."""
        waiting: list[_Node] = [self]
        while waiting:
            node = waiting.pop()
            yield node  # type: ignore[misc]
            waiting.extend(reversed(node.children()))

    def children(self) -> tuple[Node, ...]:
        """Return the nodes directly below."""
        return ()

    def names(self) -> frozenset[str]:
        """Return the names the text uses, without functions and without `pi`."""
        return frozenset(node.name for node in self.walk() if isinstance(node, Name)) - CONSTANTS.keys()

    def calls(self) -> frozenset[str]:
        """Return the functions and operators the text uses."""
        return frozenset(node.function for node in self.walk() if isinstance(node, Call))


@dataclass(frozen=True)
class Number(_Node):
    """A finite number; negative only as an exponent."""

    value: float
    span: Span = field(default=(0, 0), compare=False, repr=False)


@dataclass(frozen=True)
class Name(_Node):
    """A signal, coefficient, shape, or `pi`."""

    name: str
    span: Span = field(default=(0, 0), compare=False, repr=False)


@dataclass(frozen=True)
class Unary(_Node):
    """A minus sign (`operator` "-") before its operand; a plus sign leaves no trace."""

    operator: str
    operand: Node
    span: Span = field(default=(0, 0), compare=False, repr=False)

    def children(self) -> tuple[Node, ...]:
        """Return the operand."""
        return (self.operand,)


@dataclass(frozen=True)
class Binary(_Node):
    """`left operator right`, operator one of + - * / **; behind ** stands a Number."""

    operator: str
    left: Node
    right: Node
    span: Span = field(default=(0, 0), compare=False, repr=False)

    def children(self) -> tuple[Node, ...]:
        """Return both sides."""
        return (self.left, self.right)


@dataclass(frozen=True)
class Call(_Node):
    """A function or an operator with memory, applied to its arguments."""

    function: str
    arguments: tuple[Node, ...]
    span: Span = field(default=(0, 0), compare=False, repr=False)

    def children(self) -> tuple[Node, ...]:
        """Return the arguments."""
        return self.arguments


Node: TypeAlias = Number | Name | Unary | Binary | Call


def rebuilt(node: Node, change: Callable[[Node], Node]) -> Node:
    """Return the node with what `change` makes of each node directly below it."""
    if isinstance(node, Unary):
        return Unary(node.operator, change(node.operand), node.span)
    if isinstance(node, Binary):
        return Binary(node.operator, change(node.left), change(node.right), node.span)
    if isinstance(node, Call):
        return Call(node.function, tuple(change(part) for part in node.arguments), node.span)
    return node
