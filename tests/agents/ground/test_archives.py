"""Archives of arrays: as NumPy reads them, the same bytes for the same arrays, and smaller than NumPy's own."""

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from agents.ground.archives import archive_of, save_arrays

RANDOM = np.random.default_rng(0)
ARRAYS = {
    "name": np.array("sac"),
    "letters": np.array([*"spam"], dtype="S1"),
    "hits": RANDOM.random(100) < 0.5,
    "units": RANDOM.integers(-500, 500, (3, 40)).astype(np.int16),
    "weights": RANDOM.standard_normal((64, 32)).astype(np.float32),
    "stated exactly": RANDOM.standard_normal((64, 32)),
    "turned": RANDOM.standard_normal((7, 5)).T,
    "none": np.zeros((0, 4)),
    "Über": np.array(1.0),
}


def test_numpy_reads_what_is_written(tmp_path: Path) -> None:
    save_arrays(tmp_path / "any.ending", ARRAYS)
    with np.load(tmp_path / "any.ending") as read:
        assert read.files == [*ARRAYS]
        for name, array in ARRAYS.items():
            assert read[name].dtype == array.dtype and read[name].shape == array.shape
            assert read[name].tobytes() == array.tobytes()
    assert zipfile.ZipFile(tmp_path / "any.ending").testzip() is None
    assert np.load(io.BytesIO(archive_of({}))).files == []


def test_the_same_arrays_have_the_same_bytes() -> None:
    assert archive_of(ARRAYS) == archive_of(dict(ARRAYS))


def test_numbers_that_were_computed_in_less_precision_take_half_of_what_numpy_writes() -> None:
    weights = {"weights": RANDOM.standard_normal((200, 100)).astype(np.float32).astype(np.float64)}
    plain = io.BytesIO()
    np.savez(plain, **weights)
    assert len(archive_of(weights)) < 0.5 * len(plain.getvalue())


def test_objects_are_not_written() -> None:
    with pytest.raises(ValueError, match="Object arrays"):
        archive_of({"objects": np.array([object()], dtype=object)})
