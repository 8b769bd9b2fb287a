"""Sizes that a MATLAB file of version 4 to 7 announces, compared with what it holds, before anything is read.

SciPy makes room for what a header announces: bytes of an element, cells of an array. So every announced size is
looked at first: it must lie within what encloses it and within the budget of a recording.
"""

from __future__ import annotations

import math
import struct
import zlib
from pathlib import Path

import numpy as np

from exoid.measurement.reading.limits import Budget

SUBSYSTEM_OFFSET = slice(116, 124)
HEADER = 128
"""Bytes before the first variable of version 5 to 7."""
MATRIX, COMPRESSED = 14, 15
"""Types of element: an array with its header, and one that is packed."""
CELL, STRUCT, OBJECT, CHAR, SPARSE, FUNCTION, OPAQUE = 1, 2, 3, 4, 5, 16, 17
"""Classes of array that hold something else than plain numbers; there are none beyond."""
INTEGERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4"}
"""Types of element that hold whole numbers."""
PLAIN = frozenset({*INTEGERS, 7, 9, 12, 13, 16, 17, 18})
"""Types of element that hold numbers or text."""
DEEPEST = 40
"""Cells and structs within each other: readers call themselves for each."""
ARRAY = 128
"""Bytes that an array takes beside its numbers."""
KINDS_OF_4 = (8, 4, 4, 2, 2, 1)
"""Bytes of a number of version 4, by its code."""


class Unsound(ValueError):
    """A size that the file announces cannot be true."""


def check(path: Path) -> None:
    """Refuse a file whose announced sizes exceed the budget (RecordingError) or what is there (Unsound)."""
    budget = Budget(str(path))
    Budget(str(path)).take(path.stat().st_size)
    data = memoryview(path.read_bytes())
    if 0 in data[:4]:
        _version_4(data, budget)
    else:
        _version_5(data, budget)


def _version_4(data: memoryview, budget: Budget) -> None:
    code = struct.unpack_from("<i", data)[0]
    order, at = "<" if 0 <= code <= 5000 else ">", 0
    while at < len(data):
        code, rows, columns, imaginary, name = struct.unpack_from(f"{order}5i", data, at)
        kind = code // 10 % 10
        if min(rows, columns, name, code) < 0 or kind >= len(KINDS_OF_4):
            raise Unsound("an array has an impossible header")
        size = rows * columns * KINDS_OF_4[kind] * (2 if imaginary else 1)
        at += 20 + name + size
        budget.count()
        budget.take(size, "an array")
        if at > len(data):
            raise Unsound("an array is longer than the file")


def _version_5(data: memoryview, budget: Budget) -> None:
    order = "<" if bytes(data[126:128]) == b"IM" else ">"
    offset, starts = struct.unpack(f"{order}Q", data[SUBSYSTEM_OFFSET])[0], set()
    at = HEADER
    while at + 8 <= len(data):
        starts.add(at)
        at = _variable(data, at, order, budget)
    if bytes(data[SUBSYSTEM_OFFSET]).strip(b"\x00 ") and offset not in starts:
        raise Unsound("its objects are said to lie where no variable begins")


def _variable(data: memoryview, at: int, order: str, budget: Budget) -> int:
    """Look at the element at `at`, unpacked if need be, and return where the next one begins."""
    kind, size = struct.unpack_from(f"{order}II", data, at)
    begin, end = at + 8, at + 8 + size
    if end > len(data):
        raise Unsound("a variable is longer than the file")
    budget.count()
    if kind != COMPRESSED:
        budget.take(size, "a variable")
        if kind == MATRIX:
            _array(data[begin:end], order, budget, 0)
        return int(end)
    unpack, plain, most = zlib.decompressobj(), bytearray(), 8
    for k in range(begin, end, 1 << 16):
        piece: bytes | memoryview = data[k : min(end, k + (1 << 16))]
        while piece and not unpack.eof and len(plain) < most:
            plain += unpack.decompress(piece, min(most - len(plain), 1 << 22))
            if most == 8 and len(plain) == 8:  # its tag says how much follows
                kind, size = struct.unpack(f"{order}II", plain)
                budget.take(size, "a packed variable")
                most += size
            piece = unpack.unconsumed_tail
    if len(plain) < most or most == 8:
        raise Unsound("a packed variable is longer than what it unpacks to")
    if kind == MATRIX:
        _array(memoryview(plain)[8:], order, budget, 0)
    return int(end)


def _element(data: memoryview, at: int, order: str) -> tuple[int, memoryview, int]:
    """Return (type, content, where the next begins) of the element at `at`; short ones carry four bytes in the tag."""
    kind, size = struct.unpack_from(f"{order}II", data, at)
    if kind >> 16:
        kind, size, begin, after = kind & 0xFFFF, kind >> 16, at + 4, at + 8
        if size > 4:
            raise Unsound("a short element is too long")
    else:
        begin, after = at + 8, at + 8 + (size if kind == MATRIX else -(-size // 8) * 8)
    if begin + size > len(data):
        raise Unsound("an element is longer than what encloses it")
    return kind, data[begin : begin + size], min(after, len(data))


def _array(data: memoryview, order: str, budget: Budget, depth: int) -> None:
    """Look at the content of an array and at the arrays in it."""
    if depth > DEEPEST:
        raise Unsound(f"cells or structs lie more than {DEEPEST} deep in each other")
    if not len(data):
        return
    _, flags, at = _element(data, 0, order)
    kind = struct.unpack_from(f"{order}I", flags)[0] & 0xFF
    if not CELL <= kind <= OPAQUE:
        raise Unsound(f"an array is of class {kind}, which is unknown")
    if kind in (OPAQUE, FUNCTION):
        _rest(data, at, order, budget, depth)
        return
    _, sizes, at = _element(data, at, order)
    dims = struct.unpack(f"{order}{len(sizes) // 4}i", sizes[: len(sizes) // 4 * 4])
    if any(dim < 0 for dim in dims):
        raise Unsound("an array has a negative size")
    _, name, at = _element(data, at, order)
    count, left = math.prod(dims), len(data) - at
    if kind == CELL:
        if count > left // 8:
            raise Unsound("an array of cells announces more of them than there are")
        _rest(data, at, order, budget, depth)
    elif kind in (STRUCT, OBJECT):
        if kind == OBJECT:
            _, _, at = _element(data, at, order)
        _, length, at = _element(data, at, order)
        _, names, at = _element(data, at, order)
        width = struct.unpack_from(f"{order}i", length)[0]
        if width <= 0:
            raise Unsound("a struct has field names of no length")
        fields = len(names) // width
        budget.count(fields + (0 if fields else count))
        if count * fields > (len(data) - at) // 8:
            raise Unsound("a struct announces more elements than there are")
        _rest(data, at, order, budget, depth)
    elif kind == SPARSE:
        _sparse(data, at, order, dims)
    else:
        budget.take(4 * count if kind == CHAR else 0, "an array of text")
        while at + 8 <= len(data):
            inner, content, at = _element(data, at, order)
            if inner not in PLAIN:
                raise Unsound("an array holds neither numbers nor text")
            if depth == 0 and not len(name) and bytes(content[2:4]) in (b"IM", b"MI"):
                _subsystem(content, budget)


def _sparse(data: memoryview, at: int, order: str, dims: tuple[int, ...]) -> None:
    """Refuse a sparse array whose indices lead out of it: SciPy follows them."""
    indices = []
    for _ in range(2):
        kind, content, at = _element(data, at, order)
        if kind not in INTEGERS:
            raise Unsound("a sparse array has no indices")
        type_of = np.dtype(f"{order}{INTEGERS[kind]}")
        indices.append(np.frombuffer(content[: len(content) // type_of.itemsize * type_of.itemsize], type_of))
    kind, numbers, _ = _element(data, at, order)
    rows, ends = (part.astype(np.int64) for part in indices)
    sound = len(dims) == 2 and len(ends) == dims[1] + 1 and ends[0] == 0 and not np.any(np.diff(ends) < 0)
    if not sound or ends[-1] > min(len(rows), len(numbers)) or np.any((rows < 0) | (rows >= dims[0])):
        raise Unsound("the indices of a sparse array lead out of it")


def _rest(data: memoryview, at: int, order: str, budget: Budget, depth: int) -> None:
    """Look at the elements from `at` on, and at the arrays among them."""
    while at + 8 <= len(data):
        inner, content, at = _element(data, at, order)
        budget.take(ARRAY, "the cells of the file")
        if inner == MATRIX:
            _array(content, order, budget, depth + 1)


def _subsystem(data: memoryview, budget: Budget) -> None:
    """Look at a file within the file, in which MATLAB keeps objects."""
    order, at = "<" if bytes(data[2:4]) == b"IM" else ">", 8
    while at + 8 <= len(data):
        kind, content, at = _element(data, at, order)
        budget.take(len(content), "an object")
        if kind == MATRIX:
            _array(content, order, budget, 1)
