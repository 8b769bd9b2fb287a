"""The key of a compiled model depends on what is computed, not on what is said about it."""

from pathlib import Path

import pytest

from exoid.symbolic.codegen import fingerprint
from exoid.symbolic.codegen.pruned import computing_part

SOURCE = '''"""Module."""
LIMIT = 3
"""How many."""


def half(x: float) -> float:
    """Return half of it."""
    remedy = "give a number"
    if x > LIMIT:
        raise ValueError(f"{x} is too large", remedy)
    if x < 0:
        raise _refusal(x)
    # a comment
    return x / 2


def _refusal(x: float) -> ValueError:
    return ValueError(f"{x} is negative: {_words()}")


def _words() -> str:
    return "use its size"
'''


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"""Module."""', '"""Another sentence."""'),
        ('"""How many."""\n', ""),
        ("Return half of it.", "Halve it."),
        ("is too large", "is above the limit"),
        ("give a number", "halve it first"),
        ("is negative", "lies below zero"),
        ("use its size", "take the absolute value"),
        ("    # a comment\n", ""),
        ("x / 2", "x  /  2"),
    ],
)
def test_words_change_nothing(old, new):
    assert old in SOURCE
    assert computing_part(SOURCE.replace(old, new)) == computing_part(SOURCE)


@pytest.mark.parametrize(
    ("old", "new"),
    [("x / 2", "x / 3"), ("LIMIT = 3", "LIMIT = 4"), ("x > LIMIT", "x >= LIMIT"), ("ValueError(f", "TypeError(f")],
)
def test_what_is_computed_counts(old, new):
    changed = SOURCE.replace(old, new, 1)
    assert changed != SOURCE
    assert computing_part(changed) != computing_part(SOURCE)


@pytest.fixture
def copied(tmp_path, monkeypatch):
    """The code that generates, copied to where it may be edited, with a cache of its own."""
    original = Path(fingerprint.__file__).parents[1]
    for part in fingerprint.GENERATING:
        (tmp_path / "symbolic" / part).mkdir(parents=True)
        for path in (original / part).glob("*.py"):
            (tmp_path / "symbolic" / part / path.name).write_bytes(path.read_bytes())
    monkeypatch.setattr(fingerprint, "__file__", str(tmp_path / "symbolic" / "codegen" / "fingerprint.py"))
    monkeypatch.setenv("EXOID_CACHE", str(tmp_path / "cache"))
    return tmp_path / "symbolic"


def key():
    fingerprint.generator_key.cache_clear()
    try:
        return fingerprint.generator_key()
    finally:
        fingerprint.generator_key.cache_clear()


def test_rewording_an_error_recompiles_nothing_and_another_equation_does(copied):
    before = key()
    parser = copied / "language" / "parser.py"
    parser.write_text(parser.read_text().replace("the torque text is empty", "there is no torque text"))
    assert key() == before == key()  # the second answer is read from the cache
    lagrange = copied / "mechanics" / "lagrange.py"
    lagrange.write_text(lagrange.read_text().replace("return rate - diff(", "return rate + diff("))
    assert key() != before


def test_a_docstring_of_a_derivation_changes_no_key():
    def one(mechanism, symbols):
        """Return the mechanism."""
        return mechanism, 2.0

    def other(mechanism, symbols):
        """Return it as it is."""
        return mechanism, 2.0

    def third(mechanism, symbols):
        """Return the mechanism."""
        return mechanism, 3.0

    contents = [fingerprint.code_content(f) for f in (one, other, third)]
    assert contents[0] == contents[1] != contents[2]
