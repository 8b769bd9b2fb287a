"""Draw the pictures of the README from the shipped demo recordings: `python benchmarks/make_pictures.py`."""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))


def main() -> None:
    from diagnosis.discover import discover
    from measurement.read import read_recording
    from symbolic.model import Model

    data = ROOT / "workbench" / "demo_data"
    train = [read_recording(data / f"train_{k}.csv") for k in (1, 2, 3)]
    found = discover(Model.standard(), train, [read_recording(data / "verify.csv")])
    target = ROOT / "docs" / "falling_error.png"
    found.plot().savefig(target, dpi=110, metadata={"Software": None})
    sys.stdout.write(f"{found!r}\n{target.relative_to(ROOT)}\n")


if __name__ == "__main__":
    main()
