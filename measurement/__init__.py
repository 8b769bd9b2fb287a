"""What was measured: recordings, their audit, signals, and the virtual test bench.

In a notebook: `from exoid.measurement import read_recording`; `run = read_recording("run1.csv")`.
"""

from typing import TYPE_CHECKING

from exoid.ground.lazy import lend

if TYPE_CHECKING:
    from exoid.measurement.bench.blind import draw_hidden as draw_hidden
    from exoid.measurement.bench.blind import write_runs as write_runs
    from exoid.measurement.bench.control import track as track
    from exoid.measurement.bench.hidden import Hidden as Hidden
    from exoid.measurement.bench.leg import paper_leg as paper_leg
    from exoid.measurement.bench.leg import standard_leg as standard_leg
    from exoid.measurement.bench.seal import open_seal as open_seal
    from exoid.measurement.bench.simulation import Bench as Bench
    from exoid.measurement.bench.simulation import simulate as simulate
    from exoid.measurement.bench.simulation import simulate_runs as simulate_runs
    from exoid.measurement.bench.walk import Walk as Walk
    from exoid.measurement.bench.wearer import Wearer as Wearer
    from exoid.measurement.finding import Finding as Finding
    from exoid.measurement.reading.conventions import read_as as read_as
    from exoid.measurement.reading.read import read_recording as read_recording
    from exoid.measurement.reading.read import read_recordings as read_recordings
    from exoid.measurement.recording import Recording as Recording
    from exoid.measurement.recording import write_recording as write_recording
    from exoid.measurement.trajectories.extremes import shortest_period as shortest_period
    from exoid.measurement.trajectories.trajectory import paper_trajectory as paper_trajectory
    from exoid.measurement.trajectories.trajectory_file import read_trajectory as read_trajectory
    from exoid.measurement.trajectories.trajectory_file import write_trajectory as write_trajectory

__all__ = lend(__name__)
