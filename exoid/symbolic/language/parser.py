"""The torque language: a text such as "c * sgn(dtheta) * exp(-(dtheta / v_s)**2)" becomes a tree.

    sum     = product { ("+" | "-") product }
    product = signed { ("*" | "/") signed }
    signed  = { "+" | "-" } power
    power   = atom [ ("**" | "^") { "+" | "-" } atom ]        the exponent is a small constant
    atom    = number | name | function "(" sum { "," sum } ")" | "(" sum ")"

Nothing of a text is ever executed. A text is refused, with a caret under the offence, before it can cost
time or memory: length, depth, unknown names, constants that are not finite.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Collection
from dataclasses import dataclass

from exoid.ground.errors import ExpressionError
from exoid.ground.suggest import nearest
from exoid.symbolic.language.tokens import Token, refusal, tokenize
from exoid.symbolic.language.tree import (
    CONSTANTS,
    FUNCTIONS,
    OPERATORS,
    Binary,
    Call,
    Name,
    Node,
    Number,
    Span,
    Unary,
)

DEEPEST = 40
"""Brackets and signs inside each other."""
TALLEST = 120
"""Height of the tree, hence the most terms of one sum; it keeps every walk within Python's stack."""
LARGEST_EXPONENT = 8.0

_VALUES: dict[str, Callable[..., float]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv, "**": math.pow,
    "abs": abs, "sgn": lambda a: float((a > 0) - (a < 0)), "max": max, "min": min,
    **{word: getattr(math, word) for word in ("sin", "cos", "tan", "exp", "log", "sqrt", "tanh")},
}  # fmt: skip


def parse(text: str, names: Collection[str]) -> Node:
    """Return the tree of a torque `text` that may use `names`, `pi`, the functions and the operators.

    ExpressionError for everything else; its `where` shows the text with carets, its `remedy` what is
    allowed.
    """
    return _Parser(text, frozenset(names)).parse()


@dataclass(frozen=True)
class _Part:
    """A subtree, its height, and its value where it is made of numbers only."""

    node: Node
    height: int = 1
    value: float | None = None


class _Parser:
    """Recursive descent over the tokens of one text."""

    def __init__(self, text: str, names: frozenset[str]) -> None:
        self.text = text
        self.names = names
        self.tokens = tokenize(text)
        self.at = 0
        self.depth = 0

    def parse(self) -> Node:
        if self.here.kind == "end":
            raise self.refuse("the torque text is empty", self.here.span, 'write for example "c * dtheta"')
        part = self.sum()
        if self.here.kind != "end":
            raise self.unexpected("an operator")
        return part.node

    @property
    def here(self) -> Token:
        return self.tokens[self.at]

    def take(self, *marks: str) -> Token | None:
        """Consume and return the next token if it is one of `marks`."""
        token = self.here
        if token.kind != "mark" or token.text not in marks:
            return None
        self.at += 1
        return token

    def sum(self) -> _Part:
        left = self.product()
        while sign := self.take("+", "-"):
            left = self.binary(sign, left, self.product())
        return left

    def product(self) -> _Part:
        left = self.signed()
        while sign := self.take("*", "/"):
            left = self.binary(sign, left, self.signed())
        return left

    def signed(self) -> _Part:
        signs: list[Token] = []
        while sign := self.take("+", "-"):
            signs.append(sign)
            if len(signs) + self.depth > DEEPEST:
                raise self.too_deep(sign.span)
        part = self.power()
        for sign in reversed(signs):
            if sign.text == "-":
                span = (sign.span[0], part.node.span[1])
                value = None if part.value is None else -part.value
                part = self.part(Unary("-", part.node, span), (part,), value)
        return part

    def power(self) -> _Part:
        base = self.atom()
        sign = self.take("**")
        if sign is None:
            return base
        exponent = self.exponent()
        if self.here.kind == "mark" and self.here.text == "**":
            raise self.refuse("a power of a power", self.here.span, "use round brackets, and one exponent of at most 8")
        return self.binary(sign, base, exponent)

    def exponent(self) -> _Part:
        """Return the exponent as one Number; refuses anything but a small integer or half-integer."""
        start = self.here.span[0]
        negative = False
        while sign := self.take("+", "-"):
            negative ^= sign.text == "-"
        part = self.atom()
        span = (start, self.tokens[self.at - 1].span[1])
        remedy = "use an integer or half-integer between -8 and 8, or exp(n * log(x)) for a variable exponent"
        if part.value is None:
            raise self.refuse("the exponent is not a constant", span, remedy)
        value = -part.value if negative else part.value
        if abs(value) > LARGEST_EXPONENT or value * 2.0 != round(value * 2.0):
            raise self.refuse(f"the exponent {value:.6g} is not allowed", span, remedy)
        return _Part(Number(value + 0.0, span), 1, value + 0.0)

    def atom(self) -> _Part:
        token = self.here
        if token.kind == "number":
            self.at += 1
            return _Part(Number(token.value, token.span), 1, token.value)
        if token.kind == "name":
            self.at += 1
            following = self.here
            if following.kind == "mark" and following.text == "(":
                return self.call(token)
            return self.name(token)
        if self.take("("):
            part = self.bracketed(token)
            self.close(token)
            return part
        raise self.unexpected("a number, a name or a bracket")

    def bracketed(self, opening: Token) -> _Part:
        """Parse what stands inside brackets, one level deeper."""
        self.depth += 1
        if self.depth > DEEPEST:
            raise self.too_deep(opening.span)
        part = self.sum()
        self.depth -= 1
        return part

    def close(self, opening: Token) -> None:
        if self.take(")"):
            return
        if self.here.kind == "end":
            raise self.refuse("this bracket is not closed", opening.span, "add a )")
        raise self.unexpected("an operator or )")

    def name(self, token: Token) -> _Part:
        word = token.text
        if word in self.names:
            return _Part(Name(word, token.span))
        if word in CONSTANTS:
            return _Part(Name(word, token.span), 1, CONSTANTS[word])
        if word in FUNCTIONS or word in OPERATORS:
            raise self.refuse(f"{word} is a function", token.span, f"give it its argument: {word}(...)")
        words = self.names | CONSTANTS.keys()
        functions = FUNCTIONS.keys() | OPERATORS.keys()
        misspelt = nearest(word, functions, 1) and not nearest(word, words, 1)
        raise self.unknown("function", token, functions) if misspelt else self.unknown("name", token, words)

    def call(self, token: Token) -> _Part:
        word = token.text
        count = FUNCTIONS.get(word) or OPERATORS.get(word)
        if count is None:
            if word in self.names or word in CONSTANTS:
                raise self.refuse(f"{word} is not a function", token.span, f"to multiply, write {word} * (...)")
            raise self.unknown("function", token, FUNCTIONS.keys() | OPERATORS.keys())
        opening = self.here
        self.at += 1
        parts: list[_Part] = []
        if not (self.here.kind == "mark" and self.here.text == ")"):
            parts.append(self.bracketed(opening))
            while self.take(","):
                parts.append(self.bracketed(opening))
        self.close(opening)
        span = (token.span[0], self.tokens[self.at - 1].span[1])
        if len(parts) != count:
            plural = "" if count == 1 else "s"
            raise self.refuse(
                f"{word} takes {count} argument{plural}, here it has {len(parts)}",
                span,
                f"write {word}({', '.join(['x', 'y'][:count])})",
            )
        node = Call(word, tuple(part.node for part in parts), span)
        return self.part(node, parts, None if word in OPERATORS else self.constant(word, span, parts))

    def binary(self, sign: Token, left: _Part, right: _Part) -> _Part:
        span = (left.node.span[0], right.node.span[1])
        if right.value == 0.0 and sign.text == "/":
            raise self.refuse("division by zero", right.node.span, "divide by something that is not zero")
        node = Binary(sign.text, left.node, right.node, span)
        return self.part(node, (left, right), self.constant(sign.text, span, (left, right)))

    def part(self, node: Node, below: Collection[_Part], value: float | None) -> _Part:
        height = 1 + max(part.height for part in below)
        if height > TALLEST:
            raise self.refuse(
                f"more than {TALLEST} terms or factors in a row", node.span, "split it into several effects"
            )
        return _Part(node, height, value)

    def constant(self, word: str, span: Span, parts: Collection[_Part]) -> float | None:
        """Return the value of an operation on numbers only; refuses one that is not a finite number."""
        values = [part.value for part in parts]
        if None in values:
            return None
        try:
            value = float(_VALUES[word](*values))
        except (OverflowError, ValueError, ZeroDivisionError):
            value = math.nan
        if not math.isfinite(value):
            raise self.refuse("this is not a finite number", span, "use constants of ordinary magnitude")
        return value

    def refuse(self, what: str, span: Span, remedy: str) -> ExpressionError:
        return refusal(what, self.text, span, remedy)

    def too_deep(self, span: Span) -> ExpressionError:
        return self.refuse(f"more than {DEEPEST} brackets or signs inside each other", span, "simplify the torque")

    def unexpected(self, wanted: str) -> ExpressionError:
        token = self.here
        what = "the text ends here" if token.kind == "end" else f"{token.text!r} is not expected here"
        remedy = f"{wanted} is expected"
        if token.kind in ("name", "number") or token.text == "(":
            remedy += "; a product needs its *"
        return self.refuse(what, token.span, remedy)

    def unknown(self, kind: str, token: Token, allowed: Collection[str]) -> ExpressionError:
        """Return the refusal of an unknown word: the nearest allowed ones, then all of them."""
        typed = sorted(word for word in allowed if "_by_" not in word)  # slopes of a torque are the catalogue's own
        near = nearest(token.text, typed, 2)
        hint = f"did you mean {' or '.join(near)}? " if near else ""
        return self.refuse(f"unknown {kind} {token.text!r}", token.span, f"{hint}allowed {kind}s: {', '.join(typed)}")
