"""`exoid discover` on arms as they are recorded: processor seconds and peak memory, after the first derivation.

    python benchmarks/arm_speed.py [--joints 6 7] [--keep FOLDER]

Each arm is one of `pinocchio_arms.py` with load friction at the second joint and an offset of the last torque sensor,
in five recordings of 33 to 58 s at 125 Hz, one of them held out. Nothing is asserted. Needs the extra `peers`.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402 - the number of threads must be set first

SECONDS, RATE, OFFSET = (33.0, 39.0, 45.0, 52.0, 58.0), 125.0, 0.6
"""s and Hz of the recordings; N·m that the last sensor reads too much."""


def write(folder: Path, joints: int) -> list[str]:
    """Write model and recordings of an arm; return what `exoid discover` is asked."""
    from benchmarks.pinocchio_arms import Arm, simulate
    from exoid.measurement.recording import to_csv
    from exoid.symbolic.model import model_of
    from exoid.symbolic.robot_file import parse_robot
    from exoid.symbolic.spatial_machine import spatial_machine

    rng = np.random.default_rng(joints)
    arm = Arm.of(f"load_friction:{joints}:1", rng)
    machine = folder / f"arm_{joints}.urdf"
    machine.write_text(arm.text)
    model = model_of(spatial_machine(parse_robot(arm.text.encode())).model)
    files = []
    for k, seconds in enumerate(SECONDS):
        run = simulate(arm, rng, f"run_{k}", model, seconds, RATE)
        run.tau.setflags(write=True)
        run.tau[:, -1] += OFFSET
        files.append(folder / f"arm_{joints}_{k}.csv")
        files[-1].write_bytes(to_csv(run))
    model.columns(_still(joints))  # derived, compiled and kept
    return ["discover", *map(str, files[:-1]), "--verify", str(files[-1]), "--model", str(machine)]


def _still(joints: int) -> object:
    from exoid.symbolic.motion import Motion

    none = np.zeros((2, joints))
    return Motion(np.arange(2.0), none, none, none)


def main() -> None:
    """Make each arm, and run the command as a user would."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--joints", type=int, nargs="+", default=[6, 7])
    parser.add_argument("--keep", type=Path, help="make the files in this folder and leave them there")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = args.keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        for joints in args.joints:
            asked = write(folder, joints)
            process = subprocess.Popen([sys.executable, "-m", "exoid", *asked], cwd=ROOT, stdout=subprocess.PIPE)
            said = process.stdout.read().decode() if process.stdout else ""
            _, _, usage = os.wait4(process.pid, 0)
            busy = usage.ru_utime + usage.ru_stime
            print(f"{joints} joints: processor {busy:.0f} s, peak {usage.ru_maxrss / 1024:.0f} MB")
            print("  " + "\n  ".join(said.strip().splitlines()[:6]), flush=True)


if __name__ == "__main__":
    main()
