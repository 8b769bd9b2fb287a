"""Check that a torque text is a sum of coefficient × something: read off its tree, with a caret where it is not.

The degree of a text in its coefficients is 0 (none), 1 (proportional) or None (neither: mixed or not linear).
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from exoid.symbolic.language.tokens import refusal
from exoid.symbolic.language.tree import Binary, Call, Name, Unary

LINEAR_OPERATORS = frozenset(("delay", "lag", "slow", "ddt"))
"""Operators with memory that may act on what is proportional to a coefficient; play and dahl may not."""


def check_proportional(node: Any, text: str, unknowns: Collection[str], what: str) -> None:
    """Refuse a text that is not linear and homogeneous in `unknowns`; `what` says what these are."""
    if _degree(node, text, frozenset(unknowns), what) != 1:
        raise refusal(f"this has no {what} in front", text, node.span, f"multiply every part by a {what}")


def _degree(node: Any, text: str, unknowns: frozenset[str], what: str) -> int:
    def of(part: Any) -> int:
        return _degree(part, text, unknowns, what)

    if isinstance(node, Name):
        return int(node.name in unknowns)
    if isinstance(node, Unary):
        return of(node.operand)
    if isinstance(node, Binary):
        return _binary(node, text, of, what)
    if isinstance(node, Call):
        degrees = [of(argument) for argument in node.arguments]
        if any(degrees[1:]) or (degrees[0] and node.function not in LINEAR_OPERATORS):
            raise refusal(f"{node.function}() of a {what} is not linear in it", text, node.span, _remedy(what))
        return degrees[0]
    return 0


def _binary(node: Binary, text: str, of: Any, what: str) -> int:
    left, right = of(node.left), of(node.right)
    if node.operator in "+-":
        if left != right:
            lacking = node.left if right else node.right
            remedy = f"multiply every part by a {what}"
            raise refusal(f"this part has no {what} in front", text, lacking.span, remedy)
        return int(left)
    if node.operator == "*" and left + right <= 1:
        return int(left + right)
    if node.operator == "/" and not right:
        return int(left)
    if node.operator == "**" and not left and not right:
        return 0
    raise refusal(f"this is not linear in a {what}", text, node.span, _remedy(what))


def _remedy(what: str) -> str:
    return (
        "declare it as a shape with bounds instead"
        if what == "coefficient"
        else "only delay(), lag(), slow() and ddt() may act on it"
    )
