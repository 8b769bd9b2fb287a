"""The key of a compiled model depends on what is computed, not on what is said about it."""

from pathlib import Path

import pytest

from exoid.symbolic.codegen import fingerprint


@pytest.fixture
def copied(tmp_path, monkeypatch):
    """The code that generates, copied to where it may be edited."""
    original = Path(fingerprint.__file__).parents[1]
    for part in fingerprint.GENERATING:
        (tmp_path / "symbolic" / part).mkdir(parents=True)
        for path in (original / part).glob("*.*"):
            (tmp_path / "symbolic" / part / path.name).write_bytes(path.read_bytes())
    monkeypatch.setattr(fingerprint, "__file__", str(tmp_path / "symbolic" / "codegen" / "fingerprint.py"))
    return tmp_path / "symbolic"


def key():
    fingerprint.generator_key.cache_clear()
    try:
        return fingerprint.generator_key()
    finally:
        fingerprint.generator_key.cache_clear()


def test_another_equation_makes_what_was_compiled_stale(copied):
    before = key()
    assert key() == before
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
