"""Freed memory is used again: arrays of some 100 kB do not come from the system every time."""

from __future__ import annotations

import platform
import subprocess
import sys

import pytest

CODE = """
import resource
import numpy as np
from exoid.ground.engines.memory import reuse_freed_memory
reuse_freed_memory()
began = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(200):
    one = np.ones(60_000)  # 480 kB
    del one
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - began)
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="what glibc does")
def test_pages_of_freed_arrays_are_used_again() -> None:
    faults = subprocess.run([sys.executable, "-c", CODE], check=True, capture_output=True, text=True).stdout
    assert int(faults) < 2_000  # 200 times 117 pages without
