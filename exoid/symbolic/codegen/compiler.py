"""The C compiler of this machine, if there is one that works: found, asked who it is, and never waited for for ever.

How long it may take is counted in its own processor time: on a busy machine the clock says nothing about it.
`EXOID_COMPILER` names another one; empty or "none" means: do without.
"""

from __future__ import annotations

import os
import platform
import shutil
import signal
import subprocess
import warnings
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

CANDIDATES = ("cc", "gcc", "clang")
ANSWER = 60.0
"""Seconds by the clock in which a compiler says who it is, which takes it milliseconds."""

PATIENCE = 120
"""Seconds of processor that a step of a compilation may take; that of a leg takes 0.2."""

HUNG = 600.0
"""Seconds by the clock after which a compiler waits for something that will not come: a licence, another machine."""

EXACT = ("-O2", "-fPIC", "-std=c99", "-ffp-contract=off", "-march=native")
"""Flags for equations: IEEE arithmetic, no contraction, so that VM and C agree to the last digits."""

_WIDE = ("-mprefer-vector-width=512",) if platform.machine().lower() in ("x86_64", "amd64") else ()

_RELAXED = (
    "-ffp-contract=fast",
    "-fno-signed-zeros",
    "-fno-trapping-math",
    "-fno-math-errno",
    "-ffinite-math-only",
    "-freciprocal-math",
)
"""What -ffast-math allows, by name: -ffast-math itself, at link time, makes loading the library turn tiny numbers into
zero in the whole process (GCC before 13). Without reassociation: it would turn chains of fused multiply-adds into trees
of products and sums, a quarter slower; the sums over samples are reordered because the loops ask for it.
"""

FAST = ("-O3", "-fPIC", "-shared", "-std=c99", "-march=native", *_RELAXED, "-fopenmp-simd", *_WIDE)
"""Flags for loops that sum thousands of terms; NaN is dealt with before they are called."""


class NoCompilerWarning(UserWarning):
    """There is no working C compiler: everything runs, but slower."""


class CompilerError(Exception):
    """The compiler failed on our code, took too long, or could not be started."""


class _TooLong(CompilerError):
    """Trying again would take as long."""


@dataclass(frozen=True)
class Compiler:
    """A C compiler: its path and what it says it is."""

    path: str
    identity: str

    def build(self, source: Path, target: Path, flags: tuple[str, ...]) -> None:
        """Compile `source` into the shared library `target`; CompilerError where that fails twice: memory may have been
        short for a moment.
        """
        try:
            self._build(source, target, flags)
        except _TooLong:
            raise
        except CompilerError:
            self._build(source, target, flags)

    def _build(self, source: Path, target: Path, flags: tuple[str, ...]) -> None:
        """Compile and link in two steps: linking with -ffast-math would add start-up code that switches subnormal
        numbers off for the whole process, for everybody's arithmetic.
        """
        part = source.with_suffix(".o")
        self._run(source.parent, [*flags, "-c", source.name, "-o", part.name])
        self._run(source.parent, ["-shared", part.name, "-o", target.name, "-lm"])
        if not target.is_file():
            raise CompilerError(f"{self.path} wrote no library")

    def _run(self, folder: Path, arguments: list[str]) -> None:
        words = [self.path, *arguments]
        if os.name == "posix":  # whatever it starts inherits the limit
            words = ["/bin/sh", "-c", f'ulimit -S -t {PATIENCE} 2>/dev/null; exec "$0" "$@"', *words]
        try:
            done = subprocess.run(
                words, cwd=folder, capture_output=True, text=True, errors="replace", timeout=HUNG, check=False,
                env={**os.environ, "LC_ALL": "C"},
            )  # fmt: skip
        except subprocess.TimeoutExpired as error:
            # Once is enough: the next model would wait as long again.
            _HANGING.add(self.path)
            raise _TooLong(f"{self.path} did not finish within {HUNG:g} s, and is not asked again") from error
        except OSError as error:
            raise CompilerError(f"{self.path} cannot be started: {error}") from error
        if not done.returncode:
            return
        said = (done.stderr or done.stdout).strip()
        if OUT_OF_TIME in said or done.returncode == -_XCPU:
            raise _TooLong(f"{self.path} took more than {PATIENCE} s of processor for one model")
        what = "failed" if done.returncode > 0 else f"was ended by signal {-done.returncode}"
        raise CompilerError(" | ".join([f"{self.path} {what}", *said.splitlines()[:5]]))


OUT_OF_TIME = "CPU time limit exceeded"
"""What compilers say of a part of theirs that took too long."""
_XCPU = getattr(signal, "SIGXCPU", 0)


def find_compiler() -> Compiler | None:
    """Return the compiler to use, or None (one warning per process) where there is none."""
    found = _probe(os.environ.get("EXOID_COMPILER"))
    return None if found is None or found.path in _HANGING else found


_HANGING: set[str] = set()
"""Compilers of this process that hung."""


@lru_cache(maxsize=8)
def _probe(wanted: str | None) -> Compiler | None:
    if wanted is not None and wanted.strip().lower() in ("", "none"):
        warn_slow("EXOID_COMPILER says to do without a C compiler", "Unset EXOID_COMPILER for C")
        return None
    dumb = []
    for name in (wanted,) if wanted else CANDIDATES:
        path = shutil.which(name)
        if path is None:
            continue
        try:
            return Compiler(path, _ask(path))
        except CompilerError as error:
            dumb.append(str(error))
    if dumb:
        warn_slow(f"no C compiler here works ({'; '.join(dumb)})", "Mend it, or name another one in EXOID_COMPILER")
    elif wanted:
        warn_slow(f"there is no C compiler {wanted!r}, which EXOID_COMPILER names", "Name another one, or unset it")
    else:
        warn_slow(f"there is no C compiler ({', '.join(CANDIDATES)})", "Install gcc or clang")
    return None


def _ask(path: str) -> str:
    """Place and version of the compiler; CompilerError where it says nothing."""
    words = [path, "--version"]
    try:
        done = subprocess.run(words, capture_output=True, text=True, errors="replace", timeout=ANSWER, check=False)
    except subprocess.TimeoutExpired as error:
        raise CompilerError(f"{path} does not say who it is within {ANSWER:g} s") from error
    except OSError as error:
        raise CompilerError(f"{path} cannot be started: {error}") from error
    if done.returncode or not done.stdout.strip():
        raise CompilerError(f"{path} --version says nothing")
    return f"{os.path.realpath(path)} {done.stdout.strip().splitlines()[0]}"


@lru_cache(maxsize=64)
def warn_slow(reason: str, remedy: str = "") -> None:
    """Say once per process and reason that the slow path is taken, and what there is to do about it."""
    warnings.warn(
        f"{reason}; models run in CasADi's virtual machine: same numbers, slower" + (remedy and f". {remedy}"),
        NoCompilerWarning,
        stacklevel=2,
    )
