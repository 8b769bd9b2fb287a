"""NumPy archives: one array per column, or pairs such as `q` (N, 2); nothing in them is ever executed."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path

import numpy as np

from ground.errors import RecordingError
from measurement.reading.raw import RawTable, table_from_arrays

SUFFIXES = (".npz",)
MOST_BYTES = 2_000_000_000
"""A small archive can unpack to any size."""
SIGNATURES = (b"PK\x03\x04",)


def read(path: Path) -> RawTable:
    """Return the columns of the archive; raises RecordingError when it is damaged or holds pickled
    objects."""
    if path.suffix.lower() != ".npz":
        raise RecordingError(
            "this is a ZIP archive (a spreadsheet?), not a table",
            where=str(path),
            remedy="in the spreadsheet, save as CSV; from NumPy, use the suffix .npz",
        )
    try:
        if not zipfile.is_zipfile(path):
            raise zipfile.BadZipFile("it is not a ZIP archive")
        with zipfile.ZipFile(path) as archive:
            size = sum(entry.file_size for entry in archive.infolist())
        if size > MOST_BYTES:
            raise RecordingError(
                f"the archive unpacks to {size / 1e9:.3g} GB", where=str(path), remedy="cut it into shorter recordings"
            )
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as content:
            arrays = {name: content[name] for name in content.files}
    except (ValueError, KeyError, EOFError, TypeError, SyntaxError, NotImplementedError) as error:
        if "pickle" in str(error):
            what = "it holds Python objects, which are never loaded because they can run code"
            remedy = "save plain number arrays: np.savez(path, t=t, q=q, tau=tau)"
        else:
            what, remedy = f"the NPZ archive cannot be read ({error})", "save it again with np.savez"
        raise RecordingError(what, where=str(path), remedy=remedy) from error
    except (zipfile.BadZipFile, zlib.error, RuntimeError) as error:
        raise RecordingError(
            f"the NPZ archive is damaged ({error})", where=str(path), remedy="copy or save it again"
        ) from error
    return table_from_arrays(arrays, where=str(path))
