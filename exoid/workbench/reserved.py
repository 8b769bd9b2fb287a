"""Names that exported files and functions cannot have, because they already mean something where they are used."""

from __future__ import annotations

import keyword
import re
import sys

C_WORDS = """
    alignas alignof and asm auto bitand bitor bool break case catch char class compl const constexpr continue default
    delete do double else enum explicit export extern false float for friend goto if inline int long main mutable
    namespace new not nullptr operator or private protected public register restrict return short signed sizeof static
    struct switch template this thread_local throw true try typedef typeid typename typeof union unsigned using virtual
    void volatile while xor
"""
C_HEADERS = """
    assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg stdatomic
    stdbool stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar wctype
"""
IMPORTED = """
    numpy np casadi scipy pandas sympy matplotlib exoid
"""
"""What an exported module, or a script beside it, imports."""


def is_taken(name: str) -> bool:
    """True if a file or function called `name` would be or hide something else: a word of C, C++ or Python, a header,
    a module of Python, of its numerical packages or of exoid, a device of Windows.
    """
    word = name.lower()
    words = f"{C_WORDS} {C_HEADERS} {IMPORTED} con prn nul".split()
    known = {*words, *map(str.lower, sys.stdlib_module_names)}
    return (
        keyword.iskeyword(name)
        or keyword.issoftkeyword(name)
        or word in known
        or word.startswith("_")
        or re.fullmatch(r"(com|lpt)\d", word) is not None
    )
