"""What was measured: recordings, their audit, signals, and the virtual test bench.

In a notebook: `from measurement import read_recording`; `run = read_recording("run1.csv")`.
"""

from typing import TYPE_CHECKING

from ground.lazy import lend

if TYPE_CHECKING:
    from measurement.bench.blind import draw_hidden as draw_hidden
    from measurement.bench.blind import write_runs as write_runs
    from measurement.bench.control import track as track
    from measurement.bench.hidden import Hidden as Hidden
    from measurement.bench.leg import paper_leg as paper_leg
    from measurement.bench.leg import standard_leg as standard_leg
    from measurement.bench.seal import open_seal as open_seal
    from measurement.bench.simulation import Bench as Bench
    from measurement.bench.simulation import simulate as simulate
    from measurement.bench.simulation import simulate_runs as simulate_runs
    from measurement.bench.walk import Walk as Walk
    from measurement.bench.wearer import Wearer as Wearer
    from measurement.finding import Finding as Finding
    from measurement.reading.read import read_recording as read_recording
    from measurement.reading.read import read_recordings as read_recordings
    from measurement.recording import Recording as Recording
    from measurement.recording import write_recording as write_recording
    from measurement.trajectories.extremes import shortest_period as shortest_period
    from measurement.trajectories.trajectory import paper_trajectory as paper_trajectory
    from measurement.trajectories.trajectory_file import read_trajectory as read_trajectory
    from measurement.trajectories.trajectory_file import write_trajectory as write_trajectory

__all__ = lend(__name__)
