"""NumPy's archives of arrays (.npz) as this suite writes them: compressed by LZMA, and the same bytes each time.

`numpy.load` reads such archives like any other. NumPy's own writers leave a fifth more, and put today's date into them.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from zipfile import ZIP_LZMA, ZipFile, ZipInfo

import numpy as np


def archive_of(arrays: Mapping[str, Any]) -> bytes:
    """Arrays, or what NumPy makes arrays of, as the content of a file .npz; the same bytes for the same arrays."""
    content = io.BytesIO()
    with ZipFile(content, "w", ZIP_LZMA) as archive:
        for name, values in arrays.items():
            part = io.BytesIO()
            np.lib.format.write_array(part, np.asanyarray(values), allow_pickle=False)
            archive.writestr(ZipInfo(f"{name}.npy"), part.getvalue(), ZIP_LZMA)  # without the date of today
    return content.getvalue()


def save_arrays(path: Path, arrays: Mapping[str, Any]) -> None:
    """Write arrays, or what NumPy makes arrays of, to a file whose name may have any ending."""
    path.write_bytes(archive_of(arrays))
