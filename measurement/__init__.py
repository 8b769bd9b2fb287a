"""What was measured: recordings, their audit, signals, and the virtual test bench.

In a notebook: `from measurement import read_recording`; `run = read_recording("run1.csv")`.
"""

from typing import TYPE_CHECKING

from ground.lazy import lend

if TYPE_CHECKING:
    from measurement.bench.control import track
    from measurement.bench.hidden import Hidden
    from measurement.bench.leg import paper_leg, standard_leg
    from measurement.bench.seal import open_seal
    from measurement.bench.simulation import Bench, simulate, simulate_runs
    from measurement.finding import Finding
    from measurement.reading.read import read_recording, read_recordings
    from measurement.recording import Recording, write_recording
    from measurement.trajectories.extremes import shortest_period
    from measurement.trajectories.trajectory import paper_trajectory
    from measurement.trajectories.trajectory_file import read_trajectory, write_trajectory

__all__ = [
    "Bench",
    "Finding",
    "Hidden",
    "Recording",
    "open_seal",
    "paper_leg",
    "paper_trajectory",
    "read_recording",
    "read_recordings",
    "read_trajectory",
    "shortest_period",
    "simulate",
    "simulate_runs",
    "standard_leg",
    "track",
    "write_recording",
    "write_trajectory",
]

lend(
    __name__,
    {
        "Bench": "measurement.bench.simulation",
        "Finding": "measurement.finding",
        "Hidden": "measurement.bench.hidden",
        "Recording": "measurement.recording",
        "open_seal": "measurement.bench.seal",
        "paper_leg": "measurement.bench.leg",
        "paper_trajectory": "measurement.trajectories.trajectory",
        "read_recording": "measurement.reading.read",
        "read_recordings": "measurement.reading.read",
        "read_trajectory": "measurement.trajectories.trajectory_file",
        "shortest_period": "measurement.trajectories.extremes",
        "simulate": "measurement.bench.simulation",
        "simulate_runs": "measurement.bench.simulation",
        "standard_leg": "measurement.bench.leg",
        "track": "measurement.bench.control",
        "write_recording": "measurement.recording",
        "write_trajectory": "measurement.trajectories.trajectory_file",
    },
)
