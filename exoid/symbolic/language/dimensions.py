"""Check that a torque text comes out in N·m: its units followed through the tree, with a caret where they do not fit.

Plain numbers count as 1. A number that stands beside a quantity in a sum, or scales the argument of a function, is read
as having the unit that fits: tanh(dtheta / 0.05), max(dtheta, 0.1).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from exoid.symbolic.language.tokens import refusal
from exoid.symbolic.language.tree import CONSTANTS, Binary, Call, Name, Node, Number, Unary
from exoid.symbolic.units import NONE, TIME, Dimension

PURE = ("sin", "cos", "tan", "exp", "log", "tanh")
"""Functions of a plain number."""


@dataclass(frozen=True)
class _Quantity:
    """A dimension (None: zero, which has every unit), and whether it is `plain` or has a plain number as a factor."""

    dimension: Dimension | None
    plain: bool = False
    scaled: bool = False


def check_dimensions(
    node: Node, text: str, units: Mapping[str, Dimension], wanted: Dimension, coefficients: Collection[str]
) -> None:
    """Refuse a text whose sum has a part that is not `wanted`; `units` are the dimensions of its words."""
    if isinstance(node, Unary):
        check_dimensions(node.operand, text, units, wanted, coefficients)
    elif isinstance(node, Binary) and node.operator in "+-":
        check_dimensions(node.left, text, units, wanted, coefficients)
        check_dimensions(node.right, text, units, wanted, coefficients)
    else:
        found = _Walk(text, units).of(node).dimension
        if found is not None and found != wanted:
            used = [name for name in coefficients if name in node.names()]
            remedy = "mend a unit"
            if len(used) == 1:
                remedy = f"give {used[0]} the unit {units[used[0]] * wanted / found}"
            raise refusal(f"this comes out in {found}, not in {wanted}", text, node.span, f"{remedy}, or the text")


@dataclass(frozen=True)
class _Walk:
    text: str
    units: Mapping[str, Dimension]

    def of(self, node: Node) -> _Quantity:
        if isinstance(node, Number):
            return _Quantity(NONE if node.value else None, plain=True)
        if isinstance(node, Name):
            return _Quantity(NONE, plain=True) if node.name in CONSTANTS else _Quantity(self.units[node.name])
        if isinstance(node, Unary):
            return self.of(node.operand)
        if isinstance(node, Binary):
            return self._binary(node)
        return self._call(node)

    def _binary(self, node: Binary) -> _Quantity:
        left = self.of(node.left)
        if node.operator == "**" and isinstance(node.right, Number):
            powered = None if left.dimension is None else left.dimension**node.right.value
            return _Quantity(powered, left.plain, left.scaled)
        right = self.of(node.right)
        if node.operator in "+-":
            return self._alike(node, (left, right))
        if left.dimension is None or right.dimension is None:
            return _Quantity(None, left.plain and right.plain)
        product = left.dimension * right.dimension if node.operator == "*" else left.dimension / right.dimension
        plain = left.plain and right.plain
        return _Quantity(product, plain, not plain and (left.plain or right.plain or left.scaled or right.scaled))

    def _call(self, node: Call) -> _Quantity:
        parts = [self.of(argument) for argument in node.arguments]
        first, word = parts[0], node.function
        if word in PURE:
            if first.dimension not in (NONE, None) and not first.scaled:
                what = f"{word}() of a quantity in {first.dimension}"
                raise refusal(what, self.text, node.arguments[0].span, "divide it by a shape of its unit")
            return _Quantity(NONE, first.plain)
        if word == "sgn":
            return _Quantity(NONE, first.plain)
        if word in ("max", "min"):
            return self._alike(node, parts)
        if word == "sqrt":
            return _Quantity(None if first.dimension is None else first.dimension**0.5, first.plain, first.scaled)
        if word == "ddt":
            return _Quantity(None if first.dimension is None else first.dimension / TIME, first.plain, first.scaled)
        if len(parts) > 1:
            self._parameter(node, first, parts[1])
        return _Quantity(NONE) if word == "dahl" else first

    def _parameter(self, node: Call, signal: _Quantity, parameter: _Quantity) -> None:
        """Check what an operator with memory is given besides its signal: plain numbers have the unit that fits."""
        own = signal.dimension or NONE
        wanted = {"play": own, "dahl": own**-1, "delay": TIME, "lag": TIME, "slow": TIME**-1}[node.function]
        if not parameter.plain and parameter.dimension not in (wanted, None):
            what = f"{node.function}() wants {wanted} here, this is in {parameter.dimension}"
            raise refusal(what, self.text, node.arguments[1].span, "mend it")

    def _alike(self, node: Binary | Call, parts: Collection[_Quantity]) -> _Quantity:
        """Unit of a sum, a max or a min; all parts must be in the same unit."""
        known = [part for part in parts if part.dimension is not None and not part.plain]
        if len({part.dimension for part in known}) > 1:
            what = " and ".join(f"{part.dimension}" for part in known) + " are added or compared"
            raise refusal(what, self.text, node.span, "mend a unit")
        if known:
            return _Quantity(known[0].dimension, False, all(part.scaled for part in known))
        return _Quantity(None if all(part.dimension is None for part in parts) else NONE, plain=True)
