"""The names that `exoid.measurement` hands out, each loaded from its module at first use."""

from .bench.blind import draw_hidden as draw_hidden
from .bench.blind import write_runs as write_runs
from .bench.control import track as track
from .bench.hidden import Hidden as Hidden
from .bench.leg import paper_leg as paper_leg
from .bench.leg import standard_leg as standard_leg
from .bench.seal import open_seal as open_seal
from .bench.simulation import Bench as Bench
from .bench.simulation import simulate as simulate
from .bench.simulation import simulate_runs as simulate_runs
from .bench.walk import Walk as Walk
from .bench.wearer import Wearer as Wearer
from .finding import Finding as Finding
from .reading.conventions import read_as as read_as
from .reading.read import read_recording as read_recording
from .reading.read import read_recordings as read_recordings
from .recording import Recording as Recording
from .recording import write_recording as write_recording
from .trajectories.extremes import shortest_period as shortest_period
from .trajectories.trajectory import paper_trajectory as paper_trajectory
from .trajectories.trajectory_file import read_trajectory as read_trajectory
from .trajectories.trajectory_file import write_trajectory as write_trajectory
