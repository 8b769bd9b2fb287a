"""The C compiler of this machine, if there is one that works: found, asked who it is, and never waited for
too long.

`EXOID_COMPILER` names another one; empty or "none" means: do without.
"""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import warnings
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

CANDIDATES = ("cc", "gcc", "clang")
ANSWER = 5.0
"""Seconds a compiler may take to say who it is."""

PATIENCE = 60.0
"""Seconds a compilation may take; a model takes 0.2 s, and a compiler that hangs must not hang us."""

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


@dataclass(frozen=True)
class Compiler:
    """A C compiler: its path and what it says it is."""

    path: str
    identity: str

    def build(self, source: Path, target: Path, flags: tuple[str, ...]) -> None:
        """Compile `source` into the shared library `target`; CompilerError where that fails.

        Compiling and linking are two steps, because linking with -ffast-math would add start-up code that switches
        subnormal numbers off for the whole process, for everybody's arithmetic.
        """
        part = source.with_suffix(".o")
        self._run(source.parent, [*flags, "-c", source.name, "-o", part.name])
        self._run(source.parent, ["-shared", part.name, "-o", target.name, "-lm"])
        if not target.is_file():
            raise CompilerError(f"{self.path} wrote no library")

    def _run(self, folder: Path, arguments: list[str]) -> None:
        try:
            done = subprocess.run(
                [self.path, *arguments], cwd=folder, capture_output=True, text=True, timeout=PATIENCE, check=False
            )
        except subprocess.TimeoutExpired as error:
            # Once is enough: the next model would wait as long again.
            _HANGING.add(self.path)
            raise CompilerError(f"{self.path} did not finish within {PATIENCE:g} s") from error
        except (OSError, UnicodeDecodeError) as error:
            raise CompilerError(f"{self.path}: {error}") from error
        if done.returncode:
            message = (done.stderr or done.stdout).strip().splitlines()[:5]
            raise CompilerError(f"{self.path} refused the generated code: " + " | ".join(message))


def find_compiler() -> Compiler | None:
    """Return the compiler to use, or None (one warning per process) where there is none."""
    found = _probe(os.environ.get("EXOID_COMPILER"))
    return None if found is None or found.path in _HANGING else found


_HANGING: set[str] = set()
"""Compilers of this process that took too long over a file."""


@lru_cache(maxsize=8)
def _probe(wanted: str | None) -> Compiler | None:
    if wanted is not None and wanted.strip().lower() in ("", "none"):
        warn_slow("EXOID_COMPILER says to do without a C compiler")
        return None
    for name in (wanted,) if wanted else CANDIDATES:
        path = shutil.which(name)
        if path and (identity := _ask(path)):
            return Compiler(path, identity)
    warn_slow(f"no working C compiler found ({wanted or ', '.join(CANDIDATES)})")
    return None


def _ask(path: str) -> str | None:
    """Return what the compiler says it is; None where it does not answer in time."""
    try:
        done = subprocess.run([path, "--version"], capture_output=True, text=True, timeout=ANSWER, check=False)
    except (OSError, subprocess.TimeoutExpired, UnicodeDecodeError):
        return None
    return f"{os.path.realpath(path)} {done.stdout.splitlines()[0]}" if not done.returncode and done.stdout else None


@lru_cache(maxsize=64)
def warn_slow(reason: str) -> None:
    """Say once per process and reason that the slow path is taken."""
    warnings.warn(
        f"{reason}; models run in CasADi's virtual machine: same numbers, slower. Install gcc or clang.",
        NoCompilerWarning,
        stacklevel=2,
    )
