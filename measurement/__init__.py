"""What was measured: recordings, their audit, signals, and the virtual test bench.

In a notebook: `from measurement import read_recording`; `run = read_recording("run1.csv")`.
"""

from typing import TYPE_CHECKING

from ground.lazy import lend

if TYPE_CHECKING:
    from measurement.bench.simulation import Bench, simulate_runs
    from measurement.finding import Finding
    from measurement.reading.read import read_recording
    from measurement.recording import Recording

__all__ = ["Bench", "Finding", "Recording", "read_recording", "simulate_runs"]

lend(
    __name__,
    {
        "Bench": "measurement.bench.simulation",
        "Finding": "measurement.finding",
        "Recording": "measurement.recording",
        "read_recording": "measurement.reading.read",
        "simulate_runs": "measurement.bench.simulation",
    },
)
