"""Run the notebooks and keep their outputs small: `python benchmarks/run_notebooks.py [notebooks/04_*.ipynb ...]`.

Each is executed from top to bottom in a fresh kernel and written back: pictures with 64 colours, no times, no state of
widgets (every control stands below a picture that shows the same without it). Anything on standard error is an error.
"""

from __future__ import annotations

import base64
import io
import os
import re
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LIMIT = 60.0
"""Seconds a notebook may take."""
INSIDE = "data:image/png;base64,"


def main() -> int:
    """Execute the notebooks named (default: all); 1 when one of them fails, warns or takes too long."""
    paths = [Path(name).resolve() for name in sys.argv[1:]] or sorted((ROOT / "notebooks").glob("*.ipynb"))
    os.environ["PYTHONPATH"] = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    bad = 0
    for path in paths:
        seconds, complaints = run(path)
        if seconds > LIMIT:
            complaints.append(f"it took more than {LIMIT:.0f} s")
        bad += bool(complaints)
        size = path.stat().st_size / 1000
        sys.stdout.write(f"{path.name:<34} {seconds:5.1f} s {size:6.0f} kB  {' | '.join(complaints)}\n")
    return 1 if bad else 0


def run(path: Path) -> tuple[float, list[str]]:
    """Execute one notebook in place; return seconds and what was written to standard error."""
    import nbformat
    from jupyter_client.manager import AsyncKernelManager
    from nbclient import NotebookClient

    book = nbformat.read(path, as_version=4)
    began = time.perf_counter()
    kernel = AsyncKernelManager(kernel_name="python3", transport="ipc")
    NotebookClient(book, km=kernel, timeout=240, resources={"metadata": {"path": ROOT}}).execute()
    seconds = time.perf_counter() - began
    complaints = []
    for cell in (c for c in book.cells if c.cell_type == "code"):
        cell.metadata.pop("execution", None)
        for output in cell.outputs:
            if output.get("name") == "stderr":
                complaints.append(output["text"].strip()[:200])
            data = output.get("data", {})
            data.pop("application/vnd.jupyter.widget-view+json", None)
            if "image/png" in data:
                data["image/png"] = small(data["image/png"])
            if "text/html" in data:  # of what shows its picture itself
                data["text/html"] = re.sub(f"(?<={INSIDE})[A-Za-z0-9+/=]+", lambda m: small(m[0]), data["text/html"])
    book.metadata.pop("widgets", None)
    nbformat.write(book, path)
    return seconds, complaints


def small(png: str) -> str:
    """Return a PNG (base64) with 64 colours; plots need no more."""
    from PIL import Image

    buffer = io.BytesIO()
    picture = Image.open(io.BytesIO(base64.b64decode(png))).convert("RGB")
    picture.quantize(64, dither=Image.Dither.NONE).save(buffer, "PNG", optimize=True)
    return base64.b64encode(buffer.getvalue()).decode("ascii")


if __name__ == "__main__":
    sys.exit(main())
