"""`exoid discover` on arms as they are recorded, beside the leg: processor and peak memory, as times those of the demo.

    python benchmarks/arm_speed.py [--joints 6 7] [--shorter N] [--keep FOLDER]

Each arm is one of `pinocchio_arms.py` with load friction at the second joint and an offset of the last torque sensor,
in five recordings of 33 to 58 s at 125 Hz (N times less), one of them held out; where EXOID_SHARED_DATA names the
folder of example recordings, that of the UR10 too. All after the first derivation. Nothing is asserted. Needs `peers`.
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


def write(folder: Path, joints: int, shorter: float) -> list[str]:
    """Write model and recordings of an arm; return the arguments of `exoid` about it."""
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
        run = simulate(arm, rng, f"run_{k}", model, seconds / shorter, RATE)
        run.tau.setflags(write=True)
        run.tau[:, -1] += OFFSET
        files.append(folder / f"arm_{joints}_{k}.csv")
        files[-1].write_bytes(to_csv(run))
    return ["discover", *map(str, files[:-1]), "--verify", str(files[-1]), "--model", str(machine)]


def leg() -> list[str]:
    """Arguments of `exoid` about the demo's leg."""
    demo = ROOT / "exoid" / "workbench" / "demo_data"
    return ["discover", *(str(demo / f"train_{k}.csv") for k in (1, 2, 3)), "--verify", str(demo / "verify.csv")]


def real() -> list[str]:
    """Arguments about the UR10; none where its recording is not there."""
    where = Path(os.environ.get("EXOID_SHARED_DATA", "")) / "arm_ur10"
    found = "EXOID_SHARED_DATA" in os.environ and where.is_dir()
    return ["discover", str(where / "exciting.csv"), "--model", str(where / "ur10.urdf")] if found else []


def measured(asked: list[str]) -> tuple[float, float, str]:
    """Return processor seconds, peak MB and what a command said, once what it derives is kept."""
    from exoid.symbolic.model import Model, read_model
    from exoid.symbolic.motion import Motion

    model = read_model(asked[-1]) if "--model" in asked else Model.standard()
    none = np.zeros((2, len(model.joints)))
    model.columns(Motion(np.arange(2.0), none, none, none))  # derived, compiled and kept
    process = subprocess.Popen([sys.executable, "-m", "exoid", *asked], cwd=ROOT, stdout=subprocess.PIPE)
    said = process.stdout.read().decode() if process.stdout else ""
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(f"exoid {' '.join(asked)} failed: {said}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, said


def main() -> None:
    """Make each arm, and run the command as a user would."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--joints", type=int, nargs="+", default=[6, 7])
    parser.add_argument("--shorter", type=float, default=1.0, metavar="N", help="make recordings N times shorter")
    parser.add_argument("--keep", type=Path, help="make the files in this folder and leave them there")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = args.keep or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        arms = {f"{joints} joints": write(folder, joints, args.shorter) for joints in args.joints}
        of_leg, room, _ = measured(leg())
        print(f"leg: processor {of_leg:.1f} s, peak {room:.0f} MB")
        for name, asked in {**arms, "UR10, one recording": real()}.items():
            if not asked:
                print(f"{name}: not there (EXOID_SHARED_DATA)")
                continue
            busy, peak, said = measured(asked)
            times = f"{busy / of_leg:.1f} and {peak / room:.1f} times the leg"
            print(f"{name}: processor {busy:.1f} s, peak {peak:.0f} MB, {times}")
            print("  " + "\n  ".join(said.strip().splitlines()[:6]), flush=True)


if __name__ == "__main__":
    main()
